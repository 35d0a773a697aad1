#ifndef INSONIFY_DATASET_SAMPLE_HPP
#define INSONIFY_DATASET_SAMPLE_HPP

#include "anatomy.hpp"
#include <cmath>
#include <utility>

namespace dataset {

/// A side of the image.
enum class image_side { left, right };

/// The numbers of one sample.
struct sample {
    std::uint32_t number = 0;
    std::uint64_t seed = 0; ///< of everything random in this sample, but for its body
    spot at{};              ///< its anatomy, body and view
    float scale = 1, bend = 0, spread = 0, azimuth = 0, along = 0, across = 0, tilt = 0, rock = 0, turn = 0,
          standoff = 0, pressure = 0;
    float frequency = 0, depth = 0, focus = 0, gain = 0, dynamic_range = 0, noise = 0;
    bool needle = false;
    image_side needle_from = image_side::left;
    std::uint32_t gauge = 22;
    float needle_angle = 0, needle_depth = 0, needle_lateral = 0;
};

/// How far the face of a probe reaches to either side, metres.
inline float half_face(const any_array& probe) {
    return std::visit(
        [](const auto& one) {
            const float edge = std::fabs(one.beam(-0.5F).origin.x);
            return edge > 0 ? edge : 0.5F * one.aperture();
        },
        probe);
}

/// By how much a sample may depart from what its view has, where options leave it out: fractions, degrees, millimetres.
namespace about_view {
inline constexpr float depth = 0.15F, frequency = 0.1F, focus = 0.25F, pressure = 0.25F;
inline constexpr float needle_angle = 10, needle_depth = 5; // of its path
inline constexpr range beside_face{2, 30};                  // where the needle pierces the skin, if there is no path
} // namespace about_view

/// The largest numbers of the samples of a view.
struct limits_of_sample {
    float depth = 0, frequency = 0;
};
/// @param deepest  of the view in any body, metres
inline limits_of_sample limits_of(const description& d, const anatomy::view& view, float deepest) {
    const float frequency = std::visit([](const auto& probe) { return probe.frequency; }, view.probe);
    return {d.depth ? d.depth->to : deepest / 1_mm * (1 + about_view::depth),
            d.frequency ? d.frequency->to : frequency / 1_MHz * (1 + about_view::frequency)};
}

/// The angle of a needle that pierces the skin so far beside the face, degrees. @param away  millimetres
inline float angle_beside_face(const sample& s, const anatomy::view& view, float away) {
    const float outwards = s.needle_from == image_side::right ? -s.needle_lateral : s.needle_lateral;
    return std::atan2(s.needle_depth, max(half_face(view.probe) / 1_mm + outwards + away, 1)) / 1_deg;
}

/// Sample `number` in a view of its body: it depends on the seed and the number alone. What options leave out varies about
/// what the view has: see `about_view`.
inline sample draw_sample(const description& d, const spot& at, const anatomy::view& view) {
    sample s{.number = at.number, .seed = hash_bits(d.seed, at.number), .at = at};
    std::uint64_t next = 0, next_of_body = 0;
    const auto uniform = [&] { return hash_uniform(s.seed, next++); };
    const auto within = [&](const range& of) { return of.from + (of.to - of.from) * uniform(); };
    const auto within_or = [&](const std::optional<range>& of, float usual, float part) {
        return within(of ? *of : range{usual * (1 - part), usual * (1 + part)});
    };
    const auto of_body = [&](const range& of) {
        return of.from + (of.to - of.from) * hash_uniform(at.body, next_of_body++);
    };
    s.scale = of_body(d.scale);
    s.bend = of_body(d.bend);
    s.gauge = static_cast<std::uint32_t>(std::lround(of_body(d.gauge)));
    s.spread = within(d.spread);
    s.azimuth = 360 * uniform();
    s.along = within(d.along);
    s.across = within(d.across);
    s.tilt = within(d.tilt);
    s.rock = within(d.rock);
    s.turn = within(d.turn);
    s.standoff = within(d.standoff);
    const auto [frequency, focus] = std::visit(
        [](const auto& probe) {
            return std::pair{probe.frequency, probe.focus};
        },
        view.probe);
    const float deep = view.settings.depth / 1_mm;
    s.frequency = within_or(d.frequency, frequency / 1_MHz, about_view::frequency);
    s.depth = within_or(d.depth, deep, about_view::depth);
    s.focus = within_or(d.focus, focus > 0 ? focus / 1_mm : 0.5F * deep, about_view::focus);
    s.gain = within(d.gain);
    s.dynamic_range = within(d.dynamic_range);
    s.noise = within(d.noise);
    s.pressure = within_or(d.pressure, view.pressed / 1_mm, about_view::pressure);
    if (s.pressure > 0) s.standoff = 0;

    // Needles of a view come from the left and from the right in turn.
    const std::uint64_t of_view = hash_bits(hash_bits(d.seed, at.anatomy), at.view);
    const double first = hash_uniform(of_view, 0), fraction = d.needle;
    const auto needles_before = [&](std::uint64_t cycle) {
        return static_cast<std::uint64_t>(std::floor(first + fraction * static_cast<double>(cycle)));
    };
    s.needle = needles_before(at.cycle + std::uint64_t{1}) > needles_before(at.cycle);
    const bool from_right = (needles_before(at.cycle) + (hash_bits(of_view, 1) & 1U)) % 2 == 1;
    s.needle_from = from_right ? image_side::right : image_side::left;

    s.needle_lateral = within(d.needle_lateral);
    float path_angle = -1;
    range tip{0.25F * deep, 0.75F * deep};
    if (view.needle) {
        const vec3 entry = view.at.local_point(view.needle->entry), target = view.at.local_point(view.needle->target);
        path_angle = std::atan2(target.z - entry.z, std::fabs(target.x - entry.x)) / 1_deg;
        tip = {target.z / 1_mm - about_view::needle_depth, target.z / 1_mm + about_view::needle_depth};
        s.needle_lateral += target.x / 1_mm;
    }
    s.needle_depth = within(d.needle_depth ? *d.needle_depth : tip);
    // The skin is pierced beside the face.
    const auto angle_at = [&](float away) { return angle_beside_face(s, view, away); };
    constexpr range away = about_view::beside_face;
    if (d.needle_angle)
        s.needle_angle = within(*d.needle_angle);
    else if (path_angle >= 0)
        s.needle_angle = min(within({path_angle - about_view::needle_angle, path_angle + about_view::needle_angle}),
                             angle_at(away.from));
    else
        s.needle_angle = angle_at(within(away));
    return s;
}

} // namespace dataset
#endif
