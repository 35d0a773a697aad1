#ifndef INSONIFY_TRACING_PATHS_HPP
#define INSONIFY_TRACING_PATHS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/follow_sound.hpp>
#include <insonify/acoustics/layer.hpp>
#include <insonify/acoustics/physical.hpp>
#include <insonify/core/error.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/tracing/emit/tracer.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

/// How far sound is followed through refraction and reflection.
struct path_settings {
    std::uint32_t bounces = 16;  ///< reflections of a path before its last echo, at most
    float min_amplitude = 1e-5F; ///< a path is dropped where its own echo would be weaker
    float face_reflection = 0;   ///< of the probe's face, as pressure amplitude, for echoes that return to it
    bool pairs = true;           ///< sound also returns along a different path

    friend bool operator==(const path_settings&, const path_settings&) = default;
};

namespace detail {

/// The curvature of the wave front that a path follows. Waves leave the probe plane; curved mirrors spread or focus
/// them:
///
///     a(s) = 1 / sqrt(|det(I + s K)|)    amplitude after s metres
///
/// with the curvature K in 1/m, a symmetric tensor in the world whose null direction is the path's. Source:
/// conservation of energy in a tube of rays, as in geometrical acoustics.
class ray_tube {
  public:
    /// Whether the wave front is plane.
    INSONIFY_FN bool plane() const { return bend_ == mat3{0}; }

    /// How a distance across the path grows: per metre of it, per metre of the path.
    INSONIFY_FN float divergence(vec3 across) const { return dot(across, bend_ * across); }
    /// How the path turns, a distance across it away: radians.
    INSONIFY_FN vec3 turned(vec3 across) const { return bend_ * across; }

    /// a(s). Near a focus it is bounded: there the beam has its diffraction-limited width.
    INSONIFY_FN float amplitude(float metres) const {
        constexpr float smallest = 0.25F; // of the determinant: at most 6 dB
        return 1 / std::sqrt(max(std::fabs(determinant(mat3{1} + metres * bend_)), smallest));
    }

    /// The tube after s metres: K (I + s K)^-1.
    INSONIFY_FN ray_tube after(float metres) const {
        const mat3 grown = mat3{1} + metres * bend_;
        const float size = determinant(grown);
        ray_tube next;
        if (std::fabs(size) < 1e-3F) return next; // at a focus
        const mat3 inverse = mat3{cross(grown[1], grown[2]), cross(grown[2], grown[0]), cross(grown[0], grown[1])};
        next.bend_ = (1 / size) * (bend_ * transpose(inverse));
        return next;
    }

    /// The tube that a mirror makes of this one:
    ///
    ///     K' = M K M + 2 cos^2 i sum_jk H_jk t_j t_k^T,   M = I - 2 n n^T,   t_j = e_j - n (e_j . d') / (n . d')
    ///
    /// H are the second derivatives of the mirror's depth along the incident direction d, over the axes e_j across it;
    /// d' is the reflected direction, n the normal, i the angle of incidence. Source: equal phase of both waves on the
    /// mirror, to second order.
    /// @param curvature  H: along both axes, and mixed, 1/m
    INSONIFY_FN ray_tube mirrored(vec3 normal, vec3 reflected, vec3 across, vec3 elevation, vec3 curvature) const {
        const float towards = dot(normal, reflected);
        ray_tube next;
        if (std::fabs(towards) < 0.05F) return next;
        const mat3 mirror = mat3{1} - 2.0F * outerProduct(normal, normal);
        const vec3 x = across - (dot(across, reflected) / towards) * normal,
                   y = elevation - (dot(elevation, reflected) / towards) * normal;
        next.bend_ = mirror * bend_ * mirror +
                     (2 * towards * towards) * (curvature.x * outerProduct(x, x) + curvature.y * outerProduct(y, y) +
                                                curvature.z * (outerProduct(x, y) + outerProduct(y, x)));
        return next;
    }

  private:
    mat3 bend_{0}; // K
};

/// A path that has not been followed yet: see `paths`.
struct path_branch {
    line_frame frame{};        ///< where its next piece begins, and along what
    echo_path path{};          ///< the state of the sound there
    ray_tube tube{};           ///< curvature of the wave front there
    object_surface left{};     ///< the surface it leaves
    std::uint32_t bounces = 0; ///< reflections so far
    std::uint32_t inside = 0;  ///< how many objects contain it: the last ones of `line_scratch::branch_objects`
    bool inverted = false;     ///< an odd number of the reflections turned the sign of the pressure
    float spacing = 0;         ///< between paths that stand for neighbouring lines, metres, as in `path_spread`
    float turn = 0;            ///< radians between these: how their distance grows
    std::uint32_t parts = 1;   ///< paths that the line is divided into here
    bool in_middle = true;     ///< of these
    bool to_mirror = false;    ///< it only leads to the mirror in front of which the line was divided
    label_id mirror{};         ///< the object of that
    bool is_beside = false;    ///< it begins beside the path that was divided, and may lie in other objects
};

/// A path that arrived at a surface. Sound that arrives along one such path may return along another: see `paths`.
struct path_arrival {
    line_frame frame{};        ///< of the path's last piece
    vec3 point{0, 0, 0};       ///< where it ended
    vec3 normal{0, 0, 0};      ///< of the surface
    echo_path path{};          ///< the state of the sound there
    layer above{};             ///< before the surface
    layer below{};             ///< behind it
    std::uint32_t bounces = 0; ///< reflections so far
    bool inverted = false;     ///< an odd number of the reflections turned the sign of the pressure
    bool at_face = false;      ///< the surface is the face of the probe
};

/// Models whose echoes can be computed layer by layer and surface by surface: `physical`, with any laws.
template <class Model>
concept path_model = acoustic_model<Model> && requires(const Model& m, const traced_line& line, const layer& one,
                                                       echo_path& path, const echo_line& echoes, const incidence& at) {
    m.emit_speckle(line, one, path, echoes);
    { m.add_interface(line, one, one, path, echoes) } -> std::same_as<response>;
    { m.at_interface(at) } -> std::same_as<response>;
    { m.roughness.coherent(at) } -> std::convertible_to<float>;
    { m.refracted(vec3{}, vec3{}, at.before, at.after) } -> std::convertible_to<vec3>;
};

/// Follows all paths of one line: a stack of branches, each of which ends at the next change of medium, where its
/// reflected and transmitted parts begin.
template <path_model Model>
class path_follower {
  public:
    INSONIFY_FN path_follower(const line_task& task, const Model& model, const path_settings& settings,
                              line_scratch& scratch, view<vec2> out)
        : scene_{task.scene}, model_{model}, settings_{settings}, line_{task.line}, face_{task.line.frame},
          echoes_{task.echoes(out)}, kernels_{task.kernels}, found_{scratch.found}, branches_{scratch.branches},
          branch_objects_{scratch.branch_objects}, arrivals_{scratch.arrivals} {
        for (const medium& m : scene_.media) fastest_ = max(fastest_, m.sound_speed);
    }

    /// @return false where the scratch is too small
    INSONIFY_FN bool run() {
        if (!find_crossings(scene_, {.origin = face_.origin, .direction = face_.path()}, range(0), found_))
            return false;
        layer_walk{scene_, face_, found_, range(0), false}.enter_at_face();
        push({.frame = face_}, found_.inside);
        while (count_ > 0 && !overflow_)
            if (!follow(branches_[--count_])) return false;
        if (!overflow_) add_pairs();
        return !overflow_;
    }

  private:
    static constexpr std::uint32_t spread_steps = 96; // of a piece of a path

    // Displayed depth at which paths end. Beyond the depth of the lines they may still be half of a pair.
    INSONIFY_FN float max_shown() const { return (settings_.pairs ? 2 : 1) * echoes_.depth(); }
    // How far a path can go on from a displayed depth, metres.
    INSONIFY_FN float range(float shown) const { return (max_shown() - shown) * fastest_ / display_speed; }

    // Distance to the face of the probe, where a path that comes back ends; FLT_MAX for one that moves away from it.
    INSONIFY_FN float to_face(const line_frame& at) const {
        const float towards = -dot(at.path(), face_.along);
        if (!(towards > 1e-3F)) return FLT_MAX;
        return max(dot(at.origin - face_.origin, face_.along), 0) / towards;
    }

    INSONIFY_FN bool follow(path_branch now) {
        const float face = to_face(now.frame);
        const float limit = min(range(now.path.shown), face);
        const bool complete =
            find_crossings(scene_, {.origin = now.frame.origin, .direction = now.frame.path()}, limit, found_);
        objects_ -= now.inside;
        const bool is_beside = now.is_beside;
        now.is_beside = false;
        if (!is_beside)
            found_.inside.assign({.ranks = {branch_objects_.data() + objects_, now.inside}, .count = now.inside});
        if (!complete || found_.inside.overflow) return false;
        line_.frame = now.frame;
        aperture_gain spread[spread_steps];
        spread_sound(now, limit, spread);
        const auto parts = static_cast<float>(now.parts);
        echoes_.set_spread({now.spacing, now.turn, now.path.shown, parts, now.in_middle ? parts : 0.0F});
        // Surfaces that touch the face do not lie before it.
        layer_walk walk{scene_, now.frame, found_, limit == face ? limit - touching_distance : limit, true};
        walk.skip_departure(now.left);
        for (layer above; walk.next(above);) {
            if (walk.at_end()) above.end = limit;
            now.path.gains = now.path.gains.next(line_.gains, above, line_.media[above.medium]);
            if (!now.to_mirror) model_.emit_speckle(line_, above, now.path, echoes_);
            const echo_path entered = now.path;
            pass(model_, line_, above, now.path);
            if (walk.at_end()) break;
            layer below = walk.beyond();
            if (above.medium != below.medium) {
                split(now, entered, walk, above, below);
                return !found_.inside.overflow;
            }
        }
        if (limit == face && !now.to_mirror) return_from_face(now, face);
        return !found_.inside.overflow;
    }

    // Curved mirrors on the way spread the sound: its amplitude along the present piece of the path, as
    // `aperture_gains`.
    INSONIFY_FN void spread_sound(path_branch& now, float length, aperture_gain (&spread)[spread_steps]) {
        line_.gains = {};
        now.path.gains = {};
        if (now.tube.plane()) return;
        const float step = max(length, 1e-6F) / spread_steps;
        for (std::uint32_t i = 0; i < spread_steps; ++i) {
            const float amplitude = now.tube.amplitude(static_cast<float>(i + 1) * step);
            spread[i] = {amplitude, amplitude, 0};
        }
        line_.gains = {{spread, spread_steps}, step};
    }
    // Of the paths of neighbouring lines: see `ray_tube::divergence`.
    INSONIFY_FN static float divergence(const path_branch& now) {
        return now.tube.divergence(cross(now.frame.elevation, now.frame.along));
    }
    // A path at the end of a piece.
    INSONIFY_FN static path_branch arrived_at(path_branch now, float distance) {
        now.path.passed *= now.tube.amplitude(distance);
        now.path.gains = {};
        now.spacing += distance * now.turn;
        now.tube = now.tube.after(distance);
        return now;
    }

    // Splits a path at a surface into a transmitted and a reflected branch.
    // @param entered  the state of the sound where the layer above began
    INSONIFY_FN void split(const path_branch& arriving, const echo_path& entered, const layer_walk<>& walk,
                           const layer& above, const layer& below) {
        const medium &before = line_.media[above.medium], &after = line_.media[below.medium];
        const path_branch now = arriving.tube.plane() ? arriving : arrived_at(arriving, below.begin);
        const vec3 smooth = walk.met().normal, flat = walk.met().flat;
        // Wave fronts are not tilted; but a surface along the slice is crossed only because of the tilt, which then
        // counts.
        line_frame frame = now.frame;
        const bool by_tilt = walk.met().cosine <= steep_cosine || std::fabs(dot(smooth, frame.elevation)) > 0.5F;
        if (frame.tilt != 0 && by_tilt)
            frame = {frame.origin, normalize(frame.path()), frame.elevation, 0, frame.steering};
        const vec3 along = frame.along;
        const incidence at{before, after, walk.met().cosine, line_.frequency, below.roughness};
        const response met =
            now.to_mirror ? model_.at_interface(at) : model_.add_interface(line_, above, below, now.path, echoes_);
        if (settings_.pairs && !now.to_mirror) record(now, below.begin, walk.met().normal, above, below);
        // There and back. A rough surface mirrors only its coherent part.
        const float mirrored = model_.roughness.coherent(at);
        const float back = met.reflected * met.reflected * mirrored * mirrored;

        // A smooth normal that would send the path to the wrong side of the face is replaced by the face's own.
        const auto crosses = [&](vec3 direction) { return dot(direction, flat) * dot(along, flat) > 0; };
        const auto transmitted_by = [&](vec3 normal) { return model_.refracted(along, normal, before, after); };
        const auto mirrored_by = [&](vec3 normal) { return along - 2 * dot(along, normal) * normal; };
        vec3 onwards = transmitted_by(smooth), reflected = mirrored_by(smooth);
        if (!crosses(onwards)) onwards = transmitted_by(flat);
        if (onwards == vec3{0, 0, 0} && met.transmitted > 0)
            onwards = along; // the law transmits where Snell's does not
        if (crosses(reflected)) reflected = mirrored_by(flat);

        const vec3 point = now.frame.at(below.begin);
        path_branch on = now, off = now;
        const bool straight_on = length(onwards - along) < 1e-6F;
        on.frame = straight_on ? turned(now.frame, point, now.frame.along) : turned(frame, point, onwards);
        off.frame = turned(frame, point, reflected);
        on.path.passed *= met.transmitted;
        off.path.passed *= back;
        if (below.curvature != vec3{0, 0, 0} || !now.tube.plane())
            off.tube =
                now.tube.mirrored(smooth, reflected, cross(frame.elevation, along), frame.elevation, below.curvature);
        if (off.spacing == 0 && !off.tube.plane()) {
            const kernel_sample lines = kernels_.at(now.path.shown);
            off.spacing = lines.line_spacing;
            off.turn = lines.divergence * lines.line_spacing;
        }
        off.turn += (divergence(off) - divergence(now)) * off.spacing;
        on.left = off.left = {};
        (walk.is_own() ? on : off).left = {std::fabs(dot(smooth, along)), smooth};
        off.inverted = now.inverted != (met.reflected < 0);
        ++off.bounces;
        off.to_mirror = false;
        const label_id mirror = walk.is_own() ? below.object : above.object;
        const bool at_mirror = now.to_mirror && mirror == now.mirror;
        if (!at_mirror) push(on, found_.inside);
        walk.step_back(found_.inside);
        if (now.to_mirror && !at_mirror) return;
        if (const std::uint32_t parts = now.to_mirror ? 1 : parts_behind(off); parts > 1)
            divide(arriving, entered, above, mirror, parts);
        else
            push(off, found_.inside);
    }

    // Into how many paths sound divides that a curved mirror would spread to more than the distance of the lines. Their
    // images are half of that apart: at all of it, steep ones would lose 1 dB more.
    INSONIFY_FN std::uint32_t parts_behind(const path_branch& off) const {
        constexpr float faintest = 0.1F; // amplitude of what goes on: behind gas and bone, not soft tissue
        constexpr float max_apart = 15;  // distances of lines
        if (!(off.path.passed * static_cast<float>(off.parts) >= faintest)) return 1;
        const float left = min(max(echoes_.depth() - off.path.shown, 0), to_face(off.frame));
        const float lines = kernels_.at(echoes_.depth()).line_spacing * static_cast<float>(off.parts);
        const float apart = std::fabs(off.spacing + left * off.turn) / max(lines, 1e-9F);
        return apart < 1.5F ? 1 : 2 * static_cast<std::uint32_t>(min(apart, max_apart)) + 1;
    }
    // Divides a path in front of a mirror into parts, side by side. Each finds the mirror by itself.
    // @param above  the layer in front of the mirror, on the path
    INSONIFY_FN void divide(const path_branch& arriving, const echo_path& entered, layer above, label_id mirror,
                            std::uint32_t parts) {
        path_branch now = arriving;
        above.end = 0.5F * (above.begin + above.end);
        now.path = entered;
        pass(model_, line_, above, now.path);
        const vec3 point = now.frame.at(above.end), along = now.frame.along, across = cross(now.frame.elevation, along);
        now = arrived_at(now, above.end);
        now.left = {};
        now.to_mirror = now.is_beside = true;
        now.mirror = mirror;
        now.parts *= parts;
        now.path.passed /= static_cast<float>(parts);
        const kernel_sample lines = kernels_.at(now.path.shown);
        const float spacing = now.spacing == 0 ? lines.line_spacing : now.spacing,
                    width = spacing / static_cast<float>(now.parts);
        // Radians to the neighbours, but for those by which the wave front is curved.
        const float fan = now.spacing == 0 ? lines.divergence : now.turn / spacing - divergence(now);
        const line_frame before = now.frame;
        for (std::uint32_t i = 0; i < parts; ++i) {
            const float beside = (static_cast<float>(i) - 0.5F * static_cast<float>(parts - 1)) * width;
            path_branch part = now;
            part.frame = turned(before, point + beside * across - 0.5F * beside * beside * divergence(now) * along,
                                normalize(along + beside * (now.tube.turned(across) + fan * across)));
            part.in_middle = now.in_middle && 2 * i + 1 == parts;
            push(part, {});
        }
    }

    // Ends a path at the face of the probe, and starts its reflection there if the face reflects.
    INSONIFY_FN void return_from_face(path_branch now, float distance) {
        constexpr float min_cosine = 0.5F; // beyond 60 degrees no sound that is reflected again comes back to the array
        if (settings_.face_reflection == 0 || -dot(now.frame.along, face_.along) < min_cosine) return;
        if (!now.tube.plane()) now = arrived_at(now, distance);
        add_face_echo(now.path);
        const vec3 point = now.frame.at(distance);
        if (settings_.pairs) record(now, distance, face_.along, {}, {}, true);
        now.frame = turned(now.frame, point, now.frame.along - 2 * dot(now.frame.along, face_.along) * face_.along);
        if (!now.tube.plane())
            now.tube = now.tube.mirrored(face_.along, now.frame.along, {0, 0, 0}, {0, 0, 0}, {0, 0, 0});
        now.path.passed *= settings_.face_reflection * settings_.face_reflection;
        now.inverted = now.inverted != (settings_.face_reflection < 0);
        ++now.bounces;
        push(now, found_.inside);
    }

    // The echo that the face itself sends back.
    INSONIFY_FN void add_face_echo(const echo_path& path) const {
        echoes_.add(path.shown, {path.passed * settings_.face_reflection *
                                     amplitude_of_decibels(-pulse_loss(model_, line_, path.loss_db)),
                                 0});
    }

    INSONIFY_FN void record(const path_branch& now, float distance, vec3 normal, const layer& above, const layer& below,
                            bool at_face = false) {
        if (!now.in_middle) return;
        overflow_ = overflow_ || arrived_ == arrivals_.size();
        if (overflow_) return;
        const vec3 point = now.frame.at(distance);
        path_arrival& one = arrivals_[arrived_++];
        one = {now.frame, point, normal, now.path, above, below, now.bounces, now.inverted, at_face};
        one.path.passed *= static_cast<float>(now.parts); // the middle part stands for the whole
    }

    // Sound that goes out along one path may return along another that reaches the same surface, at the mean of both
    // times. A sequence of reflections and its reverse add up, hence the 2.
    INSONIFY_FN void add_pairs() {
        echoes_.set_spread({});
        for (std::uint32_t i = 0; i < arrived_; ++i)
            for (std::uint32_t j = i + 1; j < arrived_; ++j) {
                const path_arrival &out = arrivals_[i], &home = arrivals_[j];
                if (out.bounces != home.bounces || out.at_face != home.at_face) continue;
                if (out.above.object != home.above.object || out.below.object != home.below.object) continue;
                const float sign = out.inverted == home.inverted ? 2.0F : -2.0F;
                const echo_path both{.shown = 0.5F * (out.path.shown + home.path.shown),
                                     .loss_db = 0.5F * (out.path.loss_db + home.path.loss_db),
                                     .passed =
                                         sign * in_common(out, home) * std::sqrt(out.path.passed * home.path.passed)};
                if (both.passed == 0 || both.shown >= echoes_.depth()) continue;
                line_.frame = out.frame;
                if (out.at_face)
                    add_face_echo(both);
                else
                    model_.add_interface(line_, out.above, out.below, both, echoes_);
            }
    }

    // How much of what arrives along one path returns along the other: all where they meet at one point from one
    // direction. An estimate: it falls linearly to 0 at 3 degrees and at half a millimetre, on the same surface within
    // 20 um. +-30 %: below 0.05 dB rms.
    INSONIFY_FN static float in_common(const path_arrival& a, const path_arrival& b) {
        const vec3 between = a.point - b.point;
        const float radians = length(a.frame.along - b.frame.along), height = std::fabs(dot(between, a.normal));
        return max(1 - radians / 0.05F, 0) * max(1 - length(between) / 0.5e-3F, 0) * max(1 - height / 20e-6F, 0);
    }

    INSONIFY_FN void push(path_branch next, const media_stack& inside) {
        const float amplitude = next.path.passed * amplitude_of_decibels(-pulse_loss(model_, line_, next.path.loss_db));
        if (next.frame.along == vec3{0, 0, 0} || !(amplitude >= settings_.min_amplitude)) return;
        if (next.bounces > settings_.bounces || next.path.shown >= max_shown()) return;
        overflow_ = overflow_ || count_ == branches_.size() || objects_ + inside.count > branch_objects_.size();
        if (overflow_) return;
        next.inside = inside.count;
        for (std::uint32_t i = 0; i < inside.count; ++i) branch_objects_[objects_++] = inside.ranks[i];
        branches_[count_++] = next;
    }

    INSONIFY_FN static line_frame turned(const line_frame& before, vec3 point, vec3 along) {
        const vec3 elevation = before.elevation - dot(before.elevation, along) * along;
        const float size = length(elevation);
        return {point, along, size > 1e-3F ? elevation / size : before.elevation, before.tilt, before.steering};
    }

    const scene_view& scene_;
    const Model& model_;
    const path_settings& settings_;
    traced_line line_;
    line_frame face_;
    compensated_echoes echoes_;
    const line_kernels& kernels_;
    line_crossings& found_;
    view<path_branch> branches_;
    view<std::uint32_t> branch_objects_;
    view<path_arrival> arrivals_;
    float fastest_ = display_speed;
    std::uint32_t count_ = 0, objects_ = 0; // branches, and the objects that contain them
    std::uint32_t arrived_ = 0;             // arrivals at surfaces
    bool overflow_ = false;
};

} // namespace detail
/// Refraction and multiple reflection: a `tracer` for `trace` and `b_mode`.
///
/// Sound goes out along a path and returns along the same one, so each surface on the way adds its echo, weakened
/// by all that the path crosses twice. A plate thus gives the ladder of its reverberations, a mirror the image
/// behind it, and a tilted layer displaces what lies below. Where two paths meet a surface at one point from one
/// direction, sound also goes out along one and returns along the other: plane layers thus give all of their
/// echoes, as the sum over every sequence of reflections does, above `min_amplitude`. Directions follow the model's
/// own interface law where it gives one, else Snell's. The face of the probe is an infinite plane, where paths end.
/// Curved mirrors spread or focus the sound, curved surfaces that refract it do not: where a mirror would spread it to
/// more than the distance of the lines, the line is divided. Speckle is that of sound which returns as it went out.
struct paths {
    path_settings settings{}; ///< how far they are followed

    /// @throws usage_error  for settings out of range
    void check() const {
        if (!(settings.min_amplitude > 0 && settings.min_amplitude <= 1) || !(std::fabs(settings.face_reflection) <= 1))
            throw usage_error{"paths: `min_amplitude` must be above 0, at most 1, `face_reflection` from -1 to 1"};
    }

    /// Traces one line: see `tracer`.
    template <class Policy, detail::path_model Model>
    INSONIFY_FN bool operator()(const Policy&, const line_task& task, const Model& model, line_scratch& scratch,
                                view<vec2> out) const {
        return detail::path_follower<Model>{task, model, settings, scratch, out}.run();
    }

    friend bool operator==(const paths&, const paths&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
