#ifndef INSONIFY_MOTION_PRESS_HPP
#define INSONIFY_MOTION_PRESS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/motion/body_motion.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/queries.hpp>
#include <algorithm>
#include <array>
#include <concepts>
#include <type_traits>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Displacement below pressed skin: exponential with depth, down to what is stiff.
/// @param depth  below the skin at rest, metres
/// @param stop   exp(-S / decay) of the depth S at which the displacement is 0; 0: at none
inline float sunk(float at_skin, float depth, float decay, float stop = 0) {
    constexpr float min_part = 1e-6F; // where the skin itself is stiff
    return at_skin * max(std::exp(-max(depth, 0) / decay) - stop, 0) / max(1 - stop, min_part);
}

/// How much of the displacement at the edge of a face is left beside it. @param away  from the edge, metres
inline float beside_face(float away, float recovery) { return std::exp(-away / recovery); }

} // namespace detail

/// A flat face pressed into flat skin, parallel to it: a map for `scene::deform`.
///
/// Skin below the face comes to lie on it. Beside the face it recovers exponentially, and the tissue below sinks
/// exponentially less with depth. No model of elasticity: volume is not preserved. `press` takes any skin.
struct indentation {
    pose at{};                ///< of the pressed face, to the world: x lateral, y elevation, z into the body
    float depth = 0;          ///< of the face below the skin at rest, metres; less than `decay`, or tissue folds over
    vec2 face{40e-3F, 8e-3F}; ///< its size along x and y, metres
    float decay = 20e-3F;     ///< depth at which the displacement is 1/e, metres
    float recovery = 8e-3F;   ///< distance beside the face at which it is, metres

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const vec3 local = at.local_point(rest);
        return rest + at.direction({0, 0, detail::sunk(at_skin(local), local.z + depth, decay)});
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        const vec3 local = at.local_point(now);
        const float above = at_skin(local); // the same all along z
        return detail::rest_along([&](float moved) { return detail::sunk(above, local.z - moved + depth, decay); }, now,
                                  at.direction({0, 0, 1}), decay);
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_rigid(at) || !(depth >= 0) || !(face.x > 0) || !(face.y > 0) || !(decay > depth) || !(recovery > 0) ||
            !is_finite(recovery))
            throw usage_error{
                "indentation: `depth` must be at least 0 and less than `decay`, the sizes of the face and "
                "`recovery` above 0 and finite, and `at` a rigid pose"};
    }

    friend bool operator==(const indentation&, const indentation&) = default;

  private:
    float at_skin(vec3 local) const {
        const vec2 beside{max(std::fabs(local.x) - 0.5F * face.x, 0), max(std::fabs(local.y) - 0.5F * face.y, 0)};
        return depth * detail::beside_face(length(beside), recovery);
    }
};

/// A face of a probe, flat or curved, pressed into skin of any shape: what `press` finds, and a map for
/// `scene::deform`. Like `indentation`, with a depth that differs from point to point of a grid on the face and around
/// it, at the rim of which the displacement ends.
struct pressed_face {
    /// Columns and rows beside each edge of the face, ever further apart, the last one at 3 `recovery`.
    static constexpr std::size_t margin = 6;
    static constexpr std::size_t columns = 33 + 2 * margin;      ///< along x, 33 of them from edge to edge
    static constexpr std::size_t rows = 5 + 2 * margin;          ///< along y, 5 of them from edge to edge
    using values = std::array<std::array<float, columns>, rows>; ///< one for each point of the grid
    /// Of the depth at which tissue would fold over, what it gives way by at most.
    static constexpr float max_of_fold = 0.75F;

    pose at{};               ///< probe to world
    float left = -20e-3F;    ///< edge of the face along x, metres
    float right = 20e-3F;    ///< the other one
    float elevation = 8e-3F; ///< its size along y, metres
    values skin{};           ///< z of the skin at rest, metres
    values depth{};          ///< by which it is displaced along z, metres; beside the face: see `recover_beside`
    float decay = 20e-3F;    ///< see `indentation`
    float recovery = 8e-3F;  ///< see `indentation`
    /// exp(-S / decay), where something stiff, which does not move, lies S metres below the skin; 0: nothing. Bone
    /// holds what is beside it, too, so that tissue does not tear there: as if it lay 2 metres deeper for each metre.
    values stop{};

    /// Where a row and a column are: x and y of the probe, metres.
    vec2 place(std::size_t row, std::size_t column) const {
        const auto along = [this](std::size_t number, std::size_t count, float low, float high) {
            const auto last = static_cast<float>(count - 1 - 2 * margin),
                       from_low = static_cast<float>(number) - margin, on_face = clamp(from_low, 0, last),
                       beside = (from_low - on_face) / margin;
            return low + (high - low) * (on_face / last) +
                   reach() * beside / (widening - (widening - 1) * std::fabs(beside));
        };
        return {along(column, columns, left, right), along(row, rows, -0.5F * elevation, 0.5F * elevation)};
    }
    /// Whether a row and a column are on the face.
    static bool is_on_face(std::size_t row, std::size_t column) {
        return row >= margin && row < rows - margin && column >= margin && column < columns - margin;
    }

    /// Four points of the grid: of this row and column, and of the next ones.
    struct cell {
        std::size_t row;    ///< of its first point
        std::size_t column; ///< of its first point
        vec2 part;          ///< of the way to the next column and row, 0 to 1
    };
    /// The cell where a place is, or the one nearest to it.
    cell cell_of(vec2 place) const {
        const auto number = [this](float x, std::size_t count, float low, float high) {
            constexpr float min_width = 1e-9F; // of a face, metres
            const auto last = static_cast<float>(count - 1 - 2 * margin);
            const float on_face = clamp((x - low) / max(high - low, min_width), 0, 1),
                        beside = (x - clamp(x, low, high)) / reach();
            return clamp(margin + on_face * last +
                             margin * widening * beside / (1 + (widening - 1) * std::fabs(beside)),
                         0, static_cast<float>(count - 1));
        };
        const vec2 at_place{number(place.x, columns, left, right),
                            number(place.y, rows, -0.5F * elevation, 0.5F * elevation)};
        const std::size_t row = std::min(static_cast<std::size_t>(at_place.y), rows - 2),
                          column = std::min(static_cast<std::size_t>(at_place.x), columns - 2);
        return {row, column, at_place - vec2{static_cast<float>(column), static_cast<float>(row)}};
    }
    /// z of the skin at rest at x and y of the probe, metres: linear between rows and columns.
    float skin_at(vec2 place) const { return mixed(skin, cell_of(place)); }
    /// By how much it is displaced along z, likewise.
    float depth_at(vec2 place) const { return mixed(depth, cell_of(place)); }

    /// Values of the grid, lowered so that they rise by at most a slope from point to point. @param slope  per metre
    values with_slope(values of, float slope) const {
        for (std::size_t pass = 0; pass < 2; ++pass)
            for (std::size_t n = 0; n < rows; ++n)
                for (std::size_t m = 0; m < columns; ++m) { // forwards, then backwards
                    const std::size_t k = pass == 0 ? n : rows - 1 - n, i = pass == 0 ? m : columns - 1 - m;
                    const auto lower = [&](std::size_t row, std::size_t column) {
                        if (row < rows && column < columns)
                            of[k][i] =
                                min(of[k][i], of[row][column] + slope * length(place(k, i) - place(row, column)));
                    };
                    lower(pass == 0 ? k - 1 : k + 1, i);
                    lower(k, pass == 0 ? i - 1 : i + 1);
                }
        return of;
    }
    /// Sets the depth beside the face from that at its edge: it recovers exponentially, up to the rim of the grid, and
    /// is at most three quarters of that by which tissue above something stiff would fold over.
    void recover_beside() {
        for (std::size_t k = 0; k < rows; ++k)
            for (std::size_t i = 0; i < columns; ++i) {
                if (is_on_face(k, i)) continue;
                const std::size_t row = std::clamp(k, margin, rows - 1 - margin),
                                  column = std::clamp(i, margin, columns - 1 - margin);
                const float left_over = detail::beside_face(length(place(k, i) - place(row, column)), recovery);
                const bool at_rim = k == 0 || i == 0 || k == rows - 1 || i == columns - 1;
                depth[k][i] = at_rim ? 0 : min(depth[row][column] * left_over, max_of_fold * decay * (1 - stop[k][i]));
            }
    }

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const vec3 local = at.local_point(rest);
        const pressed_skin here = pressed_at(local);
        return rest + at.direction({0, 0, detail::sunk(here.displacement, local.z - here.z, decay, here.stop)});
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        const vec3 local = at.local_point(now);
        const pressed_skin here = pressed_at(local); // the same all along z
        return detail::rest_along(
            [&](float moved) { return detail::sunk(here.displacement, local.z - moved - here.z, decay, here.stop); },
            now, at.direction({0, 0, 1}), decay);
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        bool valid = is_rigid(at) && is_finite(left) && is_finite(right) && elevation > 0 && decay > 0 &&
                     recovery > 0 && is_finite(recovery);
        for (std::size_t k = 0; k < rows; ++k)
            for (std::size_t i = 0; i < columns; ++i)
                valid = valid && is_finite(skin[k][i]) && stop[k][i] >= 0 &&
                        (depth[k][i] == 0 || (depth[k][i] > 0 && depth[k][i] < decay * (1 - stop[k][i])));
        if (!valid)
            throw usage_error{
                "pressed_face: `depth` must be at least 0 and less than `decay` at each point of the grid, or than "
                "`decay` (1 - `stop`) above what is stiff, `left`, `right` and `skin` finite, `elevation` and "
                "`recovery` above 0 and finite, and `at` a rigid pose"};
    }

    friend bool operator==(const pressed_face&, const pressed_face&) = default;

  private:
    static constexpr float widening = 4; // ratio of the mean distance of columns beside the face to that at its edge
    float reach() const { return 3 * recovery; } // beside the face

    // Where the skin at rest is at some x and y, how far it is displaced along z, and see `stop`.
    struct pressed_skin {
        float z, displacement, stop;
    };
    pressed_skin pressed_at(vec3 local) const {
        const cell here = cell_of({local.x, local.y});
        return {mixed(skin, here), mixed(depth, here), mixed(stop, here)};
    }
    static float mixed(const values& all, const cell& at) {
        const auto along = [&](std::size_t row) {
            return all[row][at.column] + at.part.x * (all[row][at.column + 1] - all[row][at.column]);
        };
        const float lower = along(at.row);
        return lower + at.part.y * (along(at.row + 1) - lower);
    }
};

namespace detail {

/// Where lines along z through the points of a face's grid leave a body of several surfaces, and where something is
/// stiff. Keeps its memory.
class skin_heights {
  public:
    using heights = std::array<float, pressed_face::columns>; ///< z of the face at each column, metres

    pressed_face::values depth{}; ///< of the face below the skin, metres; below 0: how far in front of it the skin is
    /// z of what is stiff, metres; FLT_MAX: nothing. The least one in the cells around each point, so that nothing is
    /// missed between the points.
    pressed_face::values stiff{};

    /// @param accepts   bool(object_id): of the body, which is at rest
    /// @param is_stiff  bool(object_id)
    template <class Accepts, class IsStiff>
    void find(const scene& body, const pressed_face& face, const heights& height, const Accepts& accepts,
              const IsStiff& is_stiff) {
        for (std::size_t i = 0; i < columns; ++i) x_[i] = face.place(0, i).x;
        for (std::size_t k = 0; k < rows; ++k) y_[k] = face.place(k, 0).y;
        crossings_.clear();
        ranks_.resize(body.objects().size());
        for (auto& row : stiff) row.fill(FLT_MAX);
        std::uint32_t surface = 0;
        cell first{0, 0}; // of a triangle: near that of the one before
        for (const object& one : body.objects()) {
            if (!accepts(one.id)) continue;
            const pose to_face = inverse(face.at) * one.at;
            points_.clear();
            for (const vec3& p : body.rest_positions(one.id)) points_.push_back(to_face.point(p));
            const bool stays = is_stiff(one.id);
            for (const uvec3& corner : one.surface.faces) {
                const triangle t{points_[corner.x], points_[corner.y], points_[corner.z]};
                const aabb box{min(min(t.a, t.b), t.c), max(max(t.a, t.b), t.c)};
                if (box.upper.x < x_.front() || box.lower.x > x_.back() || box.upper.y < y_.front() ||
                    box.lower.y > y_.back())
                    continue;
                while (first.row > 0 && y_[first.row] > box.lower.y) --first.row;
                while (first.row + 2 < rows && y_[first.row + 1] <= box.lower.y) ++first.row;
                while (first.column > 0 && x_[first.column] > box.lower.x) --first.column;
                while (first.column + 2 < columns && x_[first.column + 1] <= box.lower.x) ++first.column;
                find_crossings(first, height, t, box, surface);
                // Bone behind the probe holds nothing back.
                if (stays && box.upper.z > height[first.column] - 3 * face.recovery) find_stiff(first, t, box);
            }
            ++surface;
        }
        constexpr float touching = 10e-6F; // layers that touch are one body
        std::sort(crossings_.begin(), crossings_.end(), [](const crossing& a, const crossing& b) {
            return a.point < b.point || (a.point == b.point && a.behind < b.behind);
        });
        for (auto& row : depth) row.fill(-FLT_MAX);
        media_stack inside{.ranks = ranks_};
        bool ended = false; // the body that the face touches, or is in
        for (std::size_t i = 0; i < crossings_.size(); ++i) {
            const crossing& one = crossings_[i];
            const bool is_first = i == 0 || one.point != crossings_[i - 1].point;
            if (is_first) inside.clear();
            float& own = depth[one.point / columns][one.point % columns];
            const bool apart = inside.count == 0 && one.behind > max(own, 0) + touching;
            ended = apart || (ended && !is_first);
            inside.toggle(one.surface);
            if (one.behind < 0 || (inside.count == 0 && !ended)) own = one.behind;
        }
    }

  private:
    static constexpr std::size_t columns = pressed_face::columns, rows = pressed_face::rows;
    struct cell {
        std::size_t row, column;
    };
    struct crossing {
        std::uint32_t point; // row * columns + column
        float behind;        // the face, metres; below 0: in front of it
        std::uint32_t surface;
    };

    void find_crossings(const cell& first, const heights& height, const triangle& t, const aabb& box,
                        std::uint32_t surface) {
        for (std::size_t row = first.row; row < rows && y_[row] <= box.upper.y; ++row)
            for (std::size_t i = first.column; i < columns && x_[i] <= box.upper.x; ++i) {
                if (y_[row] < box.lower.y || x_[i] < box.lower.x) continue;
                if (const hit at = intersect(ray{.origin = {x_[i], y_[row], height[i]}, .direction = {0, 0, -1}}, t))
                    crossings_.push_back({static_cast<std::uint32_t>(row * columns + i), at.distance, surface});
            }
    }

    // The least z of a triangle in each cell, or less.
    void find_stiff(const cell& first, const triangle& t, const aabb& box) {
        constexpr float flat = 1e-20F; // m^2
        const vec3 normal = cross(t.b - t.a, t.c - t.a);
        const vec2 a{t.a.x, t.a.y}, slope = -vec2{normal.x, normal.y} / (std::fabs(normal.z) > flat ? normal.z : flat);
        for (std::size_t row = first.row; row + 1 < rows && y_[row] <= box.upper.y; ++row)
            for (std::size_t i = first.column; i + 1 < columns && x_[i] <= box.upper.x; ++i) {
                const vec2 low = max(vec2{x_[i], y_[row]}, {box.lower.x, box.lower.y}) - a,
                           high = min(vec2{x_[i + 1], y_[row + 1]}, {box.upper.x, box.upper.y}) - a,
                           rise = min(slope * low, slope * high);
                const float z = max(t.a.z + rise.x + rise.y, box.lower.z);
                for (float* const corner :
                     {&stiff[row][i], &stiff[row][i + 1], &stiff[row + 1][i], &stiff[row + 1][i + 1]})
                    *corner = min(*corner, z);
            }
    }

    heights x_{};                 // of each column
    std::array<float, rows> y_{}; // of each row
    std::vector<vec3> points_{};
    std::vector<crossing> crossings_{};
    std::vector<std::uint32_t> ranks_{};
};

} // namespace detail

/// Settings of `press`.
struct press_settings {
    float stiffness = 500;  ///< of the body under the face, N/m: see `contact::force`
    float gel = 0.5e-3F;    ///< lines whose face is no further than this from the skin touch it, metres
    float decay = 20e-3F;   ///< see `indentation`
    float recovery = 8e-3F; ///< see `indentation`
    /// Where the face is so deep that tissue would fold over: true: tissue gives way by three quarters of what it can;
    /// false: an error.
    bool yields = false;
};

/// How a probe touches a body: see `press`.
struct contact {
    float depth = 0;                   ///< of the face in the body at rest, metres: the largest; 0: it is not pressed
    float mean_depth = 0;              ///< the mean over the face, metres
    float force = 0;                   ///< stiffness times mean depth, N: a spring, not a model of elasticity
    float pressure = 0;                ///< force over the part of the face that is pressed, Pa: `collapse::outside`
    std::uint32_t touching = 0;        ///< number of lines that touch the body
    std::vector<std::uint8_t> lines{}; ///< 1 for each line that touches, 0 for the others
    pressed_face deformation{};        ///< for `scene::deform`
};

/// `press`, frame after frame: holds the contact and memory, so that it allocates only while buffers grow.
class presser {
  public:
    /// See `insonify::press`. @return valid until the next call
    template <transducer Probe, std::predicate<object_id> Filter = any_object,
              std::predicate<object_id> Stiff = no_object>
    const contact& press(const scene& body, const Probe& probe, const pose& at, const press_settings& settings = {},
                         const Filter& accepts = {}, const Stiff& is_stiff = {}) {
        constexpr float behind = 0.05e-3F;
        constexpr float beside_stiff = 2; // see `pressed_face::stop`; by convention
        probe.check();
        body.require_built();
        detail::check_rigid(at, "press");
        if (!(settings.stiffness >= 0) || !(settings.gel >= 0) || !(settings.decay > 0) || !(settings.recovery > 0) ||
            !is_finite(settings.recovery))
            throw usage_error{"press: `stiffness` and `gel` must be at least 0, `decay` and `recovery` above 0, and "
                              "`recovery` finite"};
        if (is_full_circle(probe))
            throw usage_error{
                "press: the lines of the probe run all around it, so it has no face that presses; use a linear, "
                "convex or phased array"};
        contact& found = touch_;
        found = {.lines = std::move(found.lines),
                 .deformation = {.at = at, .decay = settings.decay, .recovery = settings.recovery}};
        found.lines.clear();
        pressed_face& face = found.deformation;
        const float one_end = probe.beam(-0.5F).origin.x,
                    other_end = probe.beam(static_cast<float>(probe.lines) - 0.5F).origin.x;
        face.left = min(one_end, other_end);
        face.right = max(one_end, other_end);
        if constexpr (requires { probe.aperture(); })
            if (one_end == other_end) { // lines that leave one point of a plane face
                face.right = 0.5F * probe.aperture();
                face.left = -face.right;
            }
        if constexpr (requires { probe.elevation_height; }) face.elevation = probe.elevation_height;
        detail::skin_heights::heights height;
        for (std::size_t i = 0; i < pressed_face::columns; ++i)
            height[i] = height_at(probe, clamp(face.place(0, i).x, face.left, face.right));
        skin_.find(body, face, height, accepts, is_stiff);
        const pressed_face::values holding = face.with_slope(skin_.stiff, beside_stiff);
        float sum = 0, points = 0, pressed = 0;
        vec2 folding{0, 0}; // the largest depth at which tissue would fold over, and how far below something is stiff
        for (std::size_t row = 0; row < pressed_face::rows; ++row)
            for (std::size_t i = 0; i < pressed_face::columns; ++i) {
                const float found_depth = skin_.depth[row][i],
                            skin = height[i] - (found_depth > -FLT_MAX ? found_depth : 0),
                            below = skin_.stiff[row][i] < FLT_MAX ? max(skin_.stiff[row][i] - skin, 0) : FLT_MAX;
                face.skin[row][i] = skin;
                const float stop = below < FLT_MAX ? std::exp(-below / settings.decay) : 0;
                // Beside bone as much as the face leaves without folding.
                const float beside = std::exp(-max(holding[row][i] - skin, 0) / settings.decay),
                            left = 1 - max(found_depth, 0) / (pressed_face::max_of_fold * settings.decay);
                face.stop[row][i] = max(stop, min(beside, left));
                if (!pressed_face::is_on_face(row, i)) continue;
                const float depth = max(found_depth, 0), folds = settings.decay * (1 - stop);
                found.depth = max(found.depth, depth);
                sum += depth;
                points += 1;
                pressed += depth > 0 ? 1.0F : 0.0F;
                face.depth[row][i] = max(depth - behind, 0);
                if (settings.yields)
                    face.depth[row][i] = min(face.depth[row][i], pressed_face::max_of_fold * folds);
                else if (depth > folding.x && !(depth < folds))
                    folding = {depth, below};
            }
        if (folding.x > 0) too_deep(folding.x, folding.y, settings.decay);
        face.recover_beside();
        found.mean_depth = sum / points;
        found.force = settings.stiffness * found.mean_depth;
        const float area = (face.right - face.left) * face.elevation * pressed / points;
        found.pressure = area > 0 ? found.force / area : 0;
        for (std::uint32_t line = 0; line < probe.lines; ++line) {
            const pressed_face::cell at_line = face.cell_of(vec2(probe.beam(static_cast<float>(line)).origin.x, 0));
            const float* const depth = &skin_.depth[pressed_face::rows / 2][at_line.column];
            const bool touches = depth[0] + at_line.part.x * (depth[1] - depth[0]) >= -settings.gel;
            found.lines.push_back(touches ? 1 : 0);
            found.touching += touches ? 1 : 0;
        }
        return found;
    }

    const contact& touch() const { return touch_; } ///< of the last call

  private:
    // z of the face at some x; columns are evenly spaced along x, lines in any way.
    template <transducer Probe>
    static float height_at(const Probe& probe, float x) {
        float before = -0.5F, after = static_cast<float>(probe.lines) - 0.5F;
        const bool rises = probe.beam(after).origin.x > probe.beam(before).origin.x;
        for (int i = 0; i < 24; ++i) {
            const float line = 0.5F * (before + after);
            ((probe.beam(line).origin.x < x) == rises ? before : after) = line;
        }
        return probe.beam(before).origin.z;
    }

    [[noreturn]] static void too_deep(float depth, float stiff_below, float decay) {
        const auto text = [](float length) { return detail::number_text(length * 1e3F) + " mm"; };
        throw usage_error{"press: the face is ", text(depth), " deep in the body, more than ",
                          stiff_below < FLT_MAX
                              ? "the tissue gives way above what is stiff " + text(stiff_below) + " below the skin"
                              : "`decay`, " + text(decay),
                          ": tissue would fold over; raise the probe or `decay`"};
    }

    contact touch_{};
    detail::skin_heights skin_{}; // where the skin is
};

/// How a probe at a pose touches the body at rest, whatever the present deformation: how deep its face is in the body,
/// what deformation that makes, and which lines touch.
///
///     const contact touch = press(body, probe, at);
///     body.deform(exec::par, touch.deformation);
///
/// The body is what is inside of any object that is accepted, and not the background. Pressed skin comes to lie 0.05 mm
/// behind the face, so that lines start in tissue. Costs one pass over the vertices and faces.
/// @param accepts   bool(object_id): objects that belong to the body, such as all but the needle
/// @param is_stiff  bool(object_id): those of them that do not give way, such as bone: the displacement falls to 0 on
///                  their surface, under the face and beside it
/// @throws usage_error     for a probe or a setting out of range, a scene that was not built, or a face so deep that
///                         tissue would fold over, unless it `yields`
/// @throws geometry_error  for a pose that is not rigid
template <transducer Probe, std::predicate<object_id> Filter = any_object, std::predicate<object_id> Stiff = no_object>
contact press(const scene& body, const Probe& probe, const pose& at, const press_settings& settings = {},
              const Filter& accepts = {}, const Stiff& is_stiff = {}) {
    return presser{}.press(body, probe, at, settings, accepts, is_stiff);
}

/// Two maps for `scene::deform`, one after the other: see `compose`.
template <deformation_map First, deformation_map Then>
struct composed {
    First first{}; ///< from rest
    Then then{};   ///< of what the first one gives

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const { return then(first(rest)); }
    /// The inverse.
    vec3 rest_of(vec3 now) const requires invertible_map<First> && invertible_map<Then> {
        return first.rest_of(then.rest_of(now));
    }

    /// @throws usage_error, geometry_error  as the two maps
    void check() const {
        if constexpr (requires { first.check(); }) first.check();
        if constexpr (requires { then.check(); }) then.check();
    }
};

/// Returns the tissue that a face touches to the face, from where other maps take it along z of the probe: made by
/// `keep_contact`. Displacements decrease away from the face as those of `pressed_face` do.
class kept_contact {
  public:
    kept_contact() = default;
    /// @param map   all maps that deform the body, with the one of the face
    /// @param face  without it
    template <deformation_map Map>
    kept_contact(const Map& map, const pressed_face& face) : back_{face} {
        // Wider than the face, by two columns: skin is straight between its vertices, of which some lie beside the
        // face.
        constexpr std::size_t first = pressed_face::margin, last = pressed_face::columns - 1 - first;
        const float wider = (face.right - face.left) * 2 / (last - first - 4);
        back_.left -= wider;
        back_.right += wider;
        back_.depth = {};
        back_.stop = {};
        pressed_face::values moved{};
        vec2 place[pressed_face::rows][pressed_face::columns];
        flags touches{};
        bool away = false;
        for (std::size_t k = 0; k < pressed_face::rows; ++k)
            for (std::size_t i = 0; i < pressed_face::columns; ++i) {
                place[k][i] = back_.place(k, i);
                const vec2 nearest = on_face(face, place[k][i]);
                back_.skin[k][i] = face.skin_at(nearest) + face.depth_at(nearest);
                touches[k][i] = pressed_face::is_on_face(k, i) && face.depth_at(nearest) > 0;
                if (touches[k][i]) moved[k][i] = distance_from_face(map, face, place[k][i]);
                away = away || std::fabs(moved[k][i]) > 1e-7F;
            }
        if (!away) return;
        lower_to_ridges(moved, touches, 0, 1, (place[first][first + 1].x - place[first][first].x) / face.recovery);
        lower_to_ridges(moved, touches, 1, 0, (place[first + 1][first].y - place[first][first].y) / face.recovery);
        for (auto& row : moved) {
            row[first] = row[first + 1] = row[first + 2];
            row[last] = row[last - 1] = row[last - 2];
        }
        // Displacements recover beside the part of the face that touches.
        for_each_on_face([&](std::size_t k, std::size_t i) {
            float nearest = FLT_MAX;
            for_each_on_face([&](std::size_t row, std::size_t column) {
                const float distance = length(place[k][i] - place[row][column]);
                if (!touches[row][column] || !(distance < nearest)) return;
                nearest = distance;
                back_.depth[k][i] = moved[row][column] * detail::beside_face(distance, face.recovery);
            });
        });
        back_.recover_beside();
        for (std::size_t k = 0; k < pressed_face::rows; ++k)
            for (std::size_t i = 0; i < pressed_face::columns; ++i) back_.skin[k][i] -= back_.depth[k][i];
    }

    /// Where a point is that all other maps have moved.
    vec3 operator()(vec3 moved) const { return back_(moved); }
    /// The inverse.
    vec3 rest_of(vec3 now) const { return back_.rest_of(now); }

    friend bool operator==(const kept_contact&, const kept_contact&) = default;

  private:
    template <class Visit>
    static void for_each_on_face(const Visit& visit) {
        for (std::size_t k = pressed_face::margin; k < pressed_face::rows - pressed_face::margin; ++k)
            for (std::size_t i = pressed_face::margin; i < pressed_face::columns - pressed_face::margin; ++i)
                visit(k, i);
    }
    using flags = std::array<std::array<bool, pressed_face::columns>, pressed_face::rows>;

    // Skin that was at the edge of the face at rest bends where it is now, between two points b and c: lowers these so
    // that it does not come to lie in front of the face. Neighbours on either side tell its slopes.
    // @param row, column  from a point to the next
    // @param bend         part by which a slope beside the face changes from a point to the next
    static void lower_to_ridges(pressed_face::values& moved, const flags& touches, std::size_t row, std::size_t column,
                                float bend) {
        pressed_face::values above{};
        for_each_on_face([&](std::size_t k, std::size_t i) {
            if (!touches[k - row][i - column] || !touches[k][i] || !touches[k + row][i + column] ||
                !touches[k + 2 * row][i + 2 * column])
                return;
            const float b = moved[k][i], c = moved[k + row][i + column],
                        before = max(moved[k - row][i - column] - 2 * b + c, 0),
                        after = max(moved[k + 2 * row][i + 2 * column] - 2 * c + b, 0);
            if (!(before + after > 0)) return;
            const float ridge = (before + bend * after) * (after + bend * before) / ((before + after) * (1 + bend));
            for (float* const one : {&above[k][i], &above[k + row][i + column]}) *one = max(*one, ridge);
        });
        for_each_on_face([&](std::size_t k, std::size_t i) { moved[k][i] -= above[k][i]; });
    }
    static vec2 on_face(const pressed_face& face, vec2 place) {
        return {clamp(place.x, face.left, face.right), clamp(place.y, -0.5F * face.elevation, 0.5F * face.elevation)};
    }
    // How far tissue that comes to lie at a place of the face is in front of where the face holds it, metres along z.
    template <deformation_map Map>
    static float distance_from_face(const Map& map, const pressed_face& face, vec2 place) {
        vec2 from = place; // where that tissue is at rest
        vec3 now{0, 0, 0};
        for (int i = 0; i < 4; ++i) {
            now = face.at.local_point(map(face.at.point({from, face.skin_at(from)})));
            from += place - vec2{now.x, now.y};
        }
        const float largest = 0.9F * face.decay;
        const vec2 held = on_face(face, place);
        return clamp(face.skin_at(held) + face.depth_at(held) - now.z, -largest, largest);
    }

    pressed_face back_{}; // its depths are those by which skin is in front of the face; below 0: behind it
};

/// A map that contains a pressed face, followed by what keeps the skin that the face touches on it, whatever the rest
/// of the map does there. `compose` does this by itself; it is needed for a map of your own:
///
///     const auto both = [&](vec3 rest) { return drag(touch.deformation(rest)); };
///     body.deform(exec::par, keep_contact(both, touch.deformation));
///
/// @param face  of `press`: where its depth is 0, it does not touch
template <deformation_map Map>
composed<Map, kept_contact> keep_contact(Map map, const pressed_face& face) {
    kept_contact keeper{map, face};
    return {std::move(map), keeper};
}

namespace detail {

/// The last face of a map; void where it has none.
template <class Map>
void face_of(const Map&) {}
inline const pressed_face& face_of(const pressed_face& map) { return map; }
inline pressed_face face_of(const indentation& map) {
    pressed_face same{.at = map.at,
                      .left = -0.5F * map.face.x,
                      .right = 0.5F * map.face.x,
                      .elevation = map.face.y,
                      .decay = map.decay,
                      .recovery = map.recovery};
    for (auto& row : same.skin) row.fill(-map.depth);
    for (auto& row : same.depth) row.fill(map.depth);
    same.recover_beside();
    return same;
}
template <class First, class Then>
auto face_of(const composed<First, Then>& map) {
    if constexpr (std::is_void_v<decltype(face_of(map.then))>)
        return face_of(map.first);
    else
        return face_of(map.then);
}

template <class First, class Then, class... Others>
auto in_order(First first, Then then, Others... others) {
    composed<First, Then> both{std::move(first), std::move(then)};
    if constexpr (sizeof...(Others) == 0)
        return both;
    else
        return in_order(std::move(both), std::move(others)...);
}

} // namespace detail

/// The map that applies several maps, from the first to the last.
///
///     body.deform(exec::par, compose(pulsation{.time = t}, breathing{.time = t}));
///
/// What the face of a probe touches (`pressed_face`, `indentation`) stays in touch with it, wherever the face is in the
/// list: see `keep_contact`.
template <deformation_map First, deformation_map Second, deformation_map... Others>
auto compose(First first, Second second, Others... others) {
    auto all = detail::in_order(std::move(first), std::move(second), std::move(others)...);
    if constexpr (std::is_void_v<decltype(detail::face_of(all))>)
        return all;
    else
        return keep_contact(all, detail::face_of(all));
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
