#ifndef INSONIFY_TRACING_APERTURE_APERTURE_SHADING_HPP
#define INSONIFY_TRACING_APERTURE_APERTURE_SHADING_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/aperture/aperture_view.hpp>
#include <insonify/tracing/aperture/turned_line.hpp>
#include <insonify/tracing/find/line_layers.hpp>
#include <insonify/tracing/find/slice_finder.hpp>
#include <algorithm>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Computes the gains of all lines of a frame: does the steps of `aperture_view`. Keeps its memory from frame to frame.
///
/// Lines that lie closer than the beam is wide share what arrives from the side: it is computed at some of them, the
/// points, and interpolated linearly in between where both lie in the same object. Two places of one object on either
/// side of a thin tilted sheet pass for the same; the error reaches one step of depth.
class aperture_shading {
  public:
    static constexpr std::uint32_t steps = sound_profile::steps; ///< of depth

    /// Takes over the lines of a probe.
    /// @return whether they can be turned or shifted: at equal distances on a plane or round face, or from one point of
    ///         a plane face; lines that are steered from a round one cannot
    bool assign(const probe_settings& probe, const line_fan& fan, const beam_model& beam) {
        const bool circle = probe.full_circle;
        const std::uint32_t lines = fan.size();
        if (!points_.face.assign(fan, circle)) return false;
        const float wide = beam.lateral_width(beam.focus) / probe.spacing(beam.focus);
        std::uint32_t stride = static_cast<std::uint32_t>(clamp(wide + 0.5F, 1, 16));
        while (circle && lines % stride != 0) --stride; // of a prime number of lines, each is a point
        points_.stride = stride;
        points_.first = circle ? 0 : (lines - 1) % stride / 2;
        fan_.assign(fan, points_.first, stride);
        points_.count = fan_.size();
        points_.beyond = 0;
        if (points_.count < 2 || !points_.face.assign(fan_, circle)) return false;
        if (is_point()) { // those that reach the edges of the sector from the ends of the aperture
            const float angle = std::asin(min(0.5F / beam.min_fnumber, 0.95F)), spacing = points_.face.spacing;
            points_.beyond = fan_.extend(static_cast<std::uint32_t>(std::ceil(angle / spacing)), spacing);
        }
        return true;
    }

    /// Makes the view and its tables, after `assign`; no step is done yet.
    /// @param directions  in which lines are traced to each point of a single plane; with several planes, each uses a
    ///                    quarter as many, at least 2, interleaved with the others'
    aperture_view prepare(const scene_view& scene, const frame_view& frame, std::uint32_t directions) {
        aperture_view all{.frame = frame,
                          .scene = scene,
                          .points = points_,
                          .fan = fan_.lines(),
                          .upright = fan_.upright(),
                          .directions = frame.planes == 1 ? directions : std::max((directions + 3) / 4, 2U),
                          // To the depth of the picture as if all sound had the display's speed; deeper, the last
                          // gain holds.
                          .spacing = frame.depth / steps};
        const std::size_t rows = std::size_t{frame.planes} * steps;
        profiles_.resize(std::size_t{frame.planes} * frame.count());
        sound_.resize(all.directions * rows * fan_.size());
        means_.resize(rows * points_.count);
        gains_.resize(profiles_.size() * steps);
        divide_aperture(all);
        all.turns = turns_;
        all.parts = parts_;
        all.profiles = profiles_;
        all.sound = sound_;
        all.means = means_;
        all.gains = {gains_, frame.count(), all.spacing};
        return all;
    }

    /// Does all steps.
    /// @param found   the layers of the lines of the probe, in `scene`
    /// @param slices  that they were found by; null: by rays, as everything else then is
    template <exec::policy Policy, states_arrivals Model>
    void compute(const Policy& policy, const aperture_view& all, const Model& model, const line_layers& found,
                 const slice_finder* slices) {
        const std::uint32_t lines = all.frame.count(), planes = all.frame.planes;
        exec::for_each_in_blocks(policy, lines, lines_per_block, 500, [&](std::size_t i) {
            const auto line = static_cast<std::uint32_t>(i);
            for (std::uint32_t plane = 0; plane < planes; ++plane)
                all.find_profile(line, plane, found(line, plane), model);
        });
        if (slices != nullptr) sort_segments(slices->segments());
        if (of_directions_.size() < all.directions) of_directions_.resize(all.directions);
        exec::for_each_block(
            policy, all.directions, 1, 500 * static_cast<float>(points_.count), [&](std::size_t k, std::size_t) {
                direction_memory& own = of_directions_[k];
                if (slices != nullptr)
                    own.crossings.find(fan_, {turns_.data() + k * planes, planes}, {segments_, max_elevation_planes});
                for (std::uint32_t plane = 0; plane < planes; ++plane)
                    for (std::uint32_t line = 0; line < fan_.size(); ++line)
                        own.line.fit([&](const line_room& room) {
                            return all.find_sound(
                                static_cast<std::uint32_t>(k), line, plane,
                                found.objects_behind_face(points_.line_of(points_.nearest(line)), plane), model,
                                slices != nullptr ? slices->source(own.crossings.of_line(line, plane))
                                                  : crossing_source{},
                                room);
                        });
            });
        exec::for_each_block(policy, std::size_t{planes} * steps, 1, 3000, [&](std::size_t row, std::size_t) {
            for (std::uint32_t first = 0; first < points_.count; first += all.points_at_once)
                all.find_means(static_cast<std::uint32_t>(row / steps), row % steps, first);
        });
        exec::for_each_in_blocks(policy, lines, lines_per_block, 100 * static_cast<float>(planes), [&](std::size_t i) {
            const auto line = static_cast<std::uint32_t>(i);
            for (std::uint32_t plane = 0; plane < planes; ++plane) all.find_gains(line, plane);
        });
    }

    /// The lines for which slices must be cut beside those of the probe: turned ones, and those of a phased array
    /// beyond.
    outer_lines beyond(const frame_view& frame) const {
        if (!is_point()) return {.keep_all = true};
        return {true, &fan_, half_aperture(frame, frame.depth)};
    }

  private:
    struct direction_memory {
        turned_crossings crossings{};
        line_memory line{};
    };

    bool is_point() const { return points_.face.form == face_form::point; }
    static float half_aperture(const frame_view& frame, float depth) {
        return 0.5F * depth / frame.aperture.fnumber(depth);
    }

    // The largest turn whose line is still received at some depth, within the angles for which depths and places of
    // turned lines are accurate: the tangent on a plane face, at most 0.9 of that of a line along the face; the angle
    // on a round one; the shift along the face of a phased array.
    float widest(const aperture_view& all) const {
        const face_shape& face = points_.face;
        if (is_point()) return half_aperture(all.frame, all.frame.depth);
        const float incline = std::fabs(face.incline);
        float max_turn = 0;
        for (std::uint32_t step = 0; step < steps; ++step) {
            const float z = static_cast<float>(step + 1) * all.spacing, half = half_aperture(all.frame, z);
            if (face.form == face_form::plane) {
                max_turn = max(max_turn, half / (z - min(incline * half, 0.9F * z)));
            } else {
                const float place = min(half / face.radius, 0.9F), down = std::sqrt(1 - place * place);
                max_turn =
                    max(max_turn, std::asin(place) + std::atan(face.radius * place / (z + face.radius * (1 - down))));
            }
        }
        return min(max_turn, face.form == face_form::plane ? min(3, 0.9F / max(incline, 0.1F)) : 1.3F);
    }

    // Divides the aperture of each plane among the directions.
    void divide_aperture(const aperture_view& all) {
        const frame_view& frame = all.frame;
        const face_shape& face = points_.face;
        const float max_turn = widest(all);
        const auto turned_by = [&](float part) -> line_turn { // -1 to 1
            if (is_point()) return {.face = face, .shift = part * max_turn};
            const float angle = face.form == face_form::plane ? std::atan(part * max_turn) : part * max_turn;
            return {face, std::sin(angle), std::cos(angle)};
        };
        turns_.resize(std::size_t{all.directions} * frame.planes);
        parts_.resize(turns_.size() * steps);
        for (std::uint32_t k = 0; k < all.directions; ++k)
            for (std::uint32_t plane = 0; plane < frame.planes; ++plane) {
                // Planes to both sides of the slice are shifted to both sides: 0, 1, -1, 2, -2 parts of a cell.
                const auto pair = static_cast<float>((plane + 1) / 2);
                const float shift = (plane % 2 == 0 ? -pair : pair) / static_cast<float>(frame.planes);
                const auto edge = [&](float i) {
                    return 2 * (static_cast<float>(k) + shift + i) / static_cast<float>(all.directions) - 1;
                };
                const line_turn turn = turned_by(edge(0.5F)), left = turned_by(k == 0 ? -1.0F : edge(0)),
                                right = turned_by(k + 1 == all.directions ? 1.0F : edge(1));
                turns_[std::size_t{k} * frame.planes + plane] = turn;
                for (std::uint32_t step = 0; step < steps; ++step) {
                    const float z = static_cast<float>(step + 1) * all.spacing, half = half_aperture(frame, z);
                    parts_[all.row_of(k, plane, step)] = {
                        max(min(right.place_on_face(z), half) - max(left.place_on_face(z), -half), 0),
                        is_point() ? 0.0F : turn.lines_crossed(z)};
                }
            }
    }

    void sort_segments(const slice_cut& cut) {
        for (slice_segments& slice : segments_) slice.clear();
        cut.for_each_segment([&](const cut_segment& one) {
            if (!one.again) segments_[one.slice].add(one);
        });
        for (slice_segments& slice : segments_) slice.sort();
    }

    line_fan fan_{};
    shaded_lines points_{};
    std::vector<line_turn> turns_{};
    std::vector<aperture_part> parts_{};
    std::vector<sound_profile> profiles_{};
    std::vector<sound_at_depth> sound_{};
    std::vector<aperture_mean> means_{};
    std::vector<aperture_gain> gains_{};
    slice_segments segments_[max_elevation_planes] = {};
    std::vector<direction_memory> of_directions_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
