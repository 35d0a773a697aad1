#ifndef INSONIFY_TRACING_PATHS_HPP
#define INSONIFY_TRACING_PATHS_HPP

#include <insonify/acoustics/physical.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/execution/any_policy.hpp>
#include <insonify/tracing/beams.hpp>

namespace insonify::inline INSONIFY_ABI {

/// How far sound is followed as it bends and bounces.
struct path_settings {
    std::uint32_t bounces = 4;     ///< reflections that a path may undergo before its last echo
    float least_amplitude = 1e-5F; ///< a path that would bring back less of the sound is given up
    float face_reflection = 0;     ///< of the probe's face, as pressure amplitude, for echoes that come back to it
    std::uint32_t samples = 0;     ///< random paths a line (Monte-Carlo); 0: every path, split at each surface
    float rough_power = 40;        ///< random paths: normals of rough surfaces scatter as cos^rough_power
    std::uint64_t seed = 1;        ///< of random paths; another seed is another frame of the same picture
};

/// Follows one line through refraction and reflection.
///
/// Sound goes out along a path and comes back along the same one (the only paths that all return to where they began),
/// so each surface met on the way adds its echo, weakened by all that the path has met twice. A slab thus gives the
/// ladder of its reverberations, a mirror the image behind it, and a tilted layer shifts what lies below. The face of the
/// probe, where it reflects, is a plane without end; curved surfaces do not spread or gather the sound.
template <class Model>
class path_tracer {
  public:
    using model_type = Model; ///< a `physical`

    /// Refers to scene, model and settings: keep them.
    /// @param frequency    hertz
    /// @param pulse_sigma  metres of displayed depth
    path_tracer(const scene& body, const model_type& model, const path_settings& settings, float frequency,
                float pulse_sigma)
        : body_{body}, model_{model}, settings_{settings} {
        line_.media = body.media();
        line_.places = body.places();
        line_.frequency = frequency;
        line_.pulse_sigma = pulse_sigma;
        for (const medium& m : body.media()) fastest_ = greater(fastest_, m.sound_speed);
    }

    /// Adds the echoes of one line.
    /// @param height  metres out of the slice plane that the line stands for
    /// @param random  numbers the line's random paths: a different stream for each
    void operator()(const line_frame& frame, const line_beam& beam, float height, std::uint64_t random, float spacing,
                    view<vec2> out) {
        line_.beam = beam;
        line_.height = height;
        random_ = random;
        face_ = frame;
        const echo_line echoes{out, spacing, line_.frequency};
        find_crossings(body_, {.origin = frame.origin, .direction = frame.along}, reach(echoes, 0), found_);
        for (const crossing& at : found_.crossings) // those at the face belong to the face
            if (at.distance <= touching_distance) found_.inside.toggle(at.rank);
        waiting_.clear();
        waiting_.push_back({.frame = frame, .inside = found_.inside});
        while (!waiting_.empty()) {
            branch next = std::move(waiting_.back());
            waiting_.pop_back();
            follow(std::move(next), echoes);
        }
    }

  private:
    // A path on its way: where its last piece began, along what, inside which objects.
    struct branch {
        line_frame frame{};
        media_stack inside{};
        echo_path path{};
        std::uint32_t bounces = 0;
    };

    float reach(const echo_line& echoes, float shown) const {
        return (echoes.depth() - shown) * fastest_ / display_speed;
    }

    layer layer_of(std::uint32_t rank, float begin, float end) const {
        layer here{.begin = begin, .end = end};
        if (rank == media_stack::none) return here;
        const object& one = body_.ranked(rank);
        here.medium = one.medium_index;
        here.object = static_cast<std::uint32_t>(one.id);
        here.place = 1 + static_cast<std::uint32_t>(&one - body_.objects().data());
        return here;
    }

    // Distance to the face of the probe for a path that comes back to it; FLT_MAX where it does not.
    float to_face(const line_frame& at) const {
        const float towards = -dot(at.along, face_.along);
        if (settings_.face_reflection == 0 || !(towards > 0.5F)) return FLT_MAX;
        return dot(at.origin - face_.origin, face_.along) / towards;
    }

    // Goes on to the next change of medium; there the path ends, and its reflected and transmitted parts begin.
    void follow(branch now, const echo_line& echoes) {
        const ray piece{.origin = now.frame.origin, .direction = now.frame.along};
        const float face = to_face(now.frame);
        const float limit = lesser(reach(echoes, now.path.shown), face);
        find_crossings(body_, piece, limit, found_);
        line_.frame = now.frame;
        const std::vector<crossing>& crossings = found_.crossings;
        std::size_t next = 0;
        while (next < crossings.size() && crossings[next].distance <= touching_distance) ++next; // where it began
        std::uint32_t current = now.inside.top();
        float begin = 0;
        while (next < crossings.size()) {
            const float place = crossings[next].distance;
            const std::size_t first = next;
            media_stack beyond = now.inside;
            for (; next < crossings.size() && crossings[next].distance <= place + touching_distance; ++next)
                beyond.toggle(crossings[next].rank);
            const std::uint32_t after = beyond.top();
            layer above = layer_of(current, begin, place), below = layer_of(after, place, place);
            if (after == current) {
                now.inside = beyond;
                continue;
            }
            model_.add_layer(line_, above, now.path, echoes);
            if (above.medium != below.medium) {
                const crossing& surface = surface_of_change(crossings, first, next, current, after);
                return meet(now, beyond, above, below, surface, echoes);
            }
            now.inside = beyond;
            current = after;
            begin = place;
        }
        model_.add_layer(line_, layer_of(current, begin, limit), now.path, echoes);
        if (face < FLT_MAX && limit == face) return_to_face(now, face, echoes);
    }

    const crossing& surface_of_change(const std::vector<crossing>& crossings, std::size_t first, std::size_t end,
                                      std::uint32_t before, std::uint32_t after) const {
        std::size_t i = first;
        while (i + 1 < end && crossings[i].rank != after && crossings[i].rank != before) ++i;
        return crossings[i];
    }

    void meet(const branch& now, const media_stack& beyond, const layer& above, layer& below, const crossing& at,
              const echo_line& echoes) {
        const object& one = body_.ranked(at.rank);
        const surface_incidence smooth = incidence_on(one, at.primitive, now.frame);
        const vec3 smooth_normal = one.at.direction(
            unit_normal(mesh_view{one.surface}[at.primitive], -one.at.local_direction(now.frame.along)));
        vec3 normal = smooth_normal;
        const medium &before = line_.media[above.medium], &after = line_.media[below.medium];
        if (settings_.samples > 0 && rms_height(before, after) > 0)
            normal = perturbed_normal(dot(normal, now.frame.along) > 0 ? -normal : normal, settings_.rough_power,
                                      uniform_pair());
        below.cosine = smooth.cosine;
        below.tilt = smooth.tilt;
        const response met = model_.add_interface(line_, above, below, now.path, echoes);
        const vec3 point = now.frame.origin + below.begin * now.frame.along;
        // There and back. A rough surface mirrors only its coherent part; random paths have its facets instead.
        const bool random = settings_.samples > 0;
        const float mirrored =
            random ? 1.0F : model_.roughness.coherent({before, after, smooth.cosine, line_.frequency});
        const float back = met.reflected * met.reflected * mirrored * mirrored;

        // A facet that would send the path to the wrong side of the surface gives way to the surface as a whole.
        const auto crosses = [&](vec3 direction) {
            return dot(direction, smooth_normal) * dot(now.frame.along, smooth_normal) > 0;
        };
        const auto onwards = [&](vec3 facet) {
            if (model_.timing != timing::sound_speed) return now.frame.along;
            return refracted(now.frame.along, facet, before, after);
        };
        const auto mirrored_by = [&](vec3 facet) { return now.frame.along - 2 * dot(now.frame.along, facet) * facet; };
        const vec3 through = onwards(normal), thrown = mirrored_by(normal);
        branch on = now, off = now;
        on.inside = beyond;
        on.frame = turned(now.frame, point, crosses(through) ? through : onwards(smooth_normal));
        off.frame = turned(now.frame, point, crosses(thrown) ? mirrored_by(smooth_normal) : thrown);
        on.path.passed *= met.transmitted;
        off.path.passed *= back;
        ++off.bounces;
        if (random) { // one of the two, with the probability of its share: its weight stays
            const float share = back + met.transmitted;
            if (!(share > 0)) return;
            const bool reflects = uniform() * share < back;
            (reflects ? off : on).path.passed = now.path.passed * share;
            return push(std::move(reflects ? off : on));
        }
        push(std::move(on));
        push(std::move(off));
    }

    void return_to_face(branch now, float distance, const echo_line& echoes) {
        echoes.add(now.path.shown,
                   {now.path.passed * settings_.face_reflection * std::pow(10.0F, -now.path.lost_db / 20), 0});
        const vec3 point = now.frame.origin + distance * now.frame.along;
        now.frame = turned(now.frame, point, now.frame.along - 2 * dot(now.frame.along, face_.along) * face_.along);
        now.path.passed *= settings_.face_reflection * settings_.face_reflection;
        ++now.bounces;
        push(std::move(now));
    }

    void push(branch&& next) {
        const float amplitude = next.path.passed * std::pow(10.0F, -next.path.lost_db / 20);
        if (next.frame.along == vec3{0, 0, 0} || !(amplitude >= settings_.least_amplitude)) return;
        if (next.bounces <= settings_.bounces) waiting_.push_back(std::move(next));
    }

    static line_frame turned(const line_frame& before, vec3 point, vec3 along) {
        const vec3 elevation = before.elevation - dot(before.elevation, along) * along;
        const float size = length(elevation);
        return {point, along, size > 1e-3F ? elevation / size : before.elevation};
    }

    float uniform() { return hash_uniform(settings_.seed, random_++); }
    vec2 uniform_pair() {
        const float first = uniform();
        return {first, uniform()};
    }

    const scene& body_;
    const model_type& model_;
    const path_settings& settings_;
    traced_line line_;
    line_frame face_;
    float fastest_ = display_speed;
    std::uint64_t random_ = 0;
    line_crossings found_;
    std::vector<branch> waiting_;
};

/// `trace_paths`, compiled once for all policies.
template <transducer Probe, class... Parts>
iq_lines path_lines(const exec::any_policy<false>& policy, const scene& body, const Probe& probe, const pose& at,
                    const physical<Parts...>& model, const acquisition& scan, const path_settings& settings) {
    const std::uint32_t samples = check_acquisition(body, probe, at, model, scan);
    body.require_trees();
    if (!(settings.least_amplitude > 0) || !(std::fabs(settings.face_reflection) <= 1) || !(settings.rough_power > 0))
        throw usage_error{
            "trace_paths: `least_amplitude` and `rough_power` must be above 0, `face_reflection` within 1"};
    const elevation_planes planes{beam_of(probe, scan.depth), scan.planes};
    const beam_table beams = make_beam_table(policy, probe, scan.depth, planes, model);
    iq_lines lines{probe.lines, samples, scan.depth};
    const float spacing = scan.depth / static_cast<float>(samples);
    std::vector<float> weights;
    planes.weights_of_samples(samples, spacing, weights);
    const float pulse_sigma = nominal_pulse(probe).sigma_z(probe.frequency);
    const std::uint32_t times = std::max(1U, settings.samples);
    const vec3 elevation = at.direction({0, 1, 0});
    exec::for_each_block(policy, probe.lines, 8, 1e6F, [&](std::size_t begin, std::size_t end) {
        path_tracer<physical<Parts...>> tracer{body, model, settings, probe.frequency, pulse_sigma};
        std::vector<vec2> slice(samples);
        for (std::size_t i = begin; i < end; ++i)
            for (std::uint32_t plane = 0; plane < planes.count(); ++plane) {
                const ray beam = world_beam(probe, at, static_cast<float>(i));
                const line_frame frame{beam.origin + planes.offset(plane) * elevation, beam.direction, elevation};
                std::fill(slice.begin(), slice.end(), vec2{0, 0});
                for (std::uint64_t sample = 0; sample < times; ++sample)
                    tracer(frame, beams.of_line(static_cast<std::uint32_t>(i)), planes.height(plane),
                           hash_bits(i * planes.count() + plane, sample), spacing, slice);
                const float* weight = weights.data() + std::size_t{plane} * samples;
                const float share = 1 / static_cast<float>(times);
                for (std::uint32_t k = 0; k < samples; ++k)
                    lines.values[i * samples + k] += share * weight[k] * slice[k];
            }
    });
    return lines;
}

/// Echoes with refraction, multiple reflections, mirror images and reverberation; else as `trace_beams`, and equal to it
/// where nothing bends and nothing is reflected twice.
///
/// With `settings.samples` the paths are chosen at random and averaged; another seed gives an independent estimate of
/// the same lines (see `path_estimate`).
/// @throws usage_error, geometry_error  as `trace_beams`
template <exec::policy Policy, transducer Probe, class... Parts>
iq_lines trace_paths(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                     const physical<Parts...>& model, const acquisition& scan, const path_settings& settings = {}) {
    return path_lines(exec::any_policy<false>{policy}, body, probe, at, model, scan, settings);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
