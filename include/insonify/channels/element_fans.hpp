#ifndef INSONIFY_CHANNELS_ELEMENT_FANS_HPP
#define INSONIFY_CHANNELS_ELEMENT_FANS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/follow_sound.hpp>
#include <insonify/acoustics/layer.hpp>
#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/geometry/ray.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// What sound meets between each element and any point of the slice.
namespace insonify::inline INSONIFY_ABI::detail {

/// The lines on which one element looks into the slice: a probe.
struct element_fan {
    std::uint32_t lines = 2;
    float frequency = 1e6F; ///< hertz
    vec3 origin{0, 0, 0};
    float direction = 0; ///< of the element's normal, from z towards x, radians
    float span = 1;      ///< from the first to the last line, radians

    float angle(float line) const { return direction + (line / static_cast<float>(lines - 1) - 0.5F) * span; }
    ray beam(float line) const {
        return {.origin = origin, .direction = {std::sin(angle(line)), 0, std::cos(angle(line))}};
    }
    vec2 locate(vec2 p) const {
        const vec2 to{p.x - origin.x, p.y - origin.z};
        return {(std::remainder(std::atan2(to.x, to.y) - direction, 2 * pi) / span + 0.5F) *
                    static_cast<float>(lines - 1),
                length(to)};
    }
    void check() const {}
};

/// The wave of an element at the beginning of a layer of one line. Beside the line, at u metres across it, it arrives
/// after
///
///     time + tilt u + bend u^2 / 2
///
/// A layer of length d and speed c turns (tilt, bend) into m (tilt, bend) / (bend + m) with m = 1 / (c d), and the
/// earliest wave arrives tilt^2 / (2 (bend + m)) before the one along the line: Fermat's principle, within one step of
/// Newton's method. A surface z = a u + q u^2 / 2 between speeds c1 and c2 adds a (1/c1 - 1/c2) to the tilt and
/// q (1/c1 - 1/c2) to the bend.
struct element_wave {
    float begin = 0;          ///< metres along the line
    float time = 0;           ///< s
    float tilt = 0, bend = 0; ///< in the slice
    float bend_across = 0;    ///< out of the slice
    float spread = 0; ///< amplitude is 1 / sqrt(spread * spread_across): in a uniform medium both are the distance
    float spread_across = 0;   ///< metres
    float passed = 1;          ///< factor on amplitude of the interfaces so far, one way
    float lost = 0;            ///< attenuation at the carrier so far, one way, Np
    float lost_slope = 0;      ///< change of that with frequency, Np/Hz
    float slowness = 0;        ///< of the layer, s/m
    float per_metre = 0;       ///< attenuation of the layer, Np/m
    float slope_per_metre = 0; ///< Np/(m Hz)
    std::uint32_t medium = 0;  ///< see `layer`, as the next
    std::uint32_t object = ~0U;
};

/// The wave of an element at a point.
struct arrived_wave {
    float time = 0;       ///< s
    float amplitude = 0;  ///< 1 / m
    float range = 0;      ///< that of a uniform medium with the same curvature out of the slice, metres
    float lost_slope = 0; ///< Np/Hz
};

/// Layers of every element's lines, with what sound does on the way.
class element_fans {
  public:
    /// @param places  of the elements, in the frame of the probe
    /// @param reach   how far lines are followed, metres
    /// @param loss    loss(medium, frequency): attenuation there and back, dB/m
    /// @param passed  passed(before, after, cosine, roughness): factor on amplitude, there and back
    /// @param strip   strip(distance): half height of the element's beam out of the slice, where its power falls to
    ///                1/e, metres: sound passes beside obstacles that are narrower, such as a needle
    /// @throws usage_error  for an element inside of bone, metal or gas
    template <class Policy, class Loss, class Passed, class Strip>
    void assign(const Policy& policy, const scene& body, view<const ray> places, const pose& at, float frequency,
                float reach, const Loss& loss, const Passed& passed, const Strip& strip) {
        constexpr float spacing = 0.3e-3F; // of neighbouring lines at their ends, metres
        lines_ = static_cast<std::uint32_t>(clamp(std::ceil(span * reach / spacing), 64, 1024));
        fans_.resize(places.size());
        std::vector<std::uint8_t> blocked(places.size(), 0);
        exec::for_each_block(policy, places.size(), 1, 3e5F, [&](std::size_t i, std::size_t) {
            fan& own = fans_[i];
            own.shape = {.lines = lines_,
                         .frequency = frequency,
                         .origin = places[i].origin,
                         .direction = std::atan2(places[i].direction.x, places[i].direction.z),
                         .span = span};
            // The slice plane of an element out of y = 0 is its own.
            pose here = at;
            here.translation = at.point({0, places[i].origin.y, 0});
            own.shape.origin.y = 0;
            layer_search search;
            const line_layers& found = search(exec::seq, body, own.shape, here, {.depth = reach}, reach, true);
            blocked[i] = follow(found, frequency, loss, passed, strip, own);
        });
        for (std::size_t i = 0; i < blocked.size(); ++i)
            if (blocked[i] != 0)
                throw usage_error{joined({"trace_channels: element ", std::to_string(i),
                                          " lies inside of an object that blocks sound, such as bone, metal or gas; "
                                          "move the array, or the object"})};
    }

    /// Where a point lies among the lines of an element.
    struct place {
        std::uint32_t line = 0; ///< the point lies between this one and the next
        float part = 0;         ///< 0 on this one, 1 on the next
        float distance = 0;     ///< from the element, metres
        float sine = 0;         ///< of the angle to the element's normal
        float cosine = 0;
        bool seen = false; ///< by the fan
    };
    place find(std::size_t element, vec2 p) const {
        const element_fan& shape = fans_[element].shape;
        const vec2 to{p.x - shape.origin.x, p.y - shape.origin.z};
        place found;
        found.distance = std::sqrt(dot(to, to));
        const float along_x = std::sin(shape.direction), along_z = std::cos(shape.direction);
        if (!(found.distance > 1e-6F)) return found;
        found.sine = (to.x * along_z - to.y * along_x) / found.distance;
        found.cosine = (to.x * along_x + to.y * along_z) / found.distance;
        const float angle = std::atan2(found.sine, found.cosine);
        const float line = (angle / span + 0.5F) * static_cast<float>(lines_ - 1);
        if (!(line >= 0 && line < static_cast<float>(lines_ - 1))) return found;
        found.line = static_cast<std::uint32_t>(line);
        found.part = line - static_cast<float>(found.line);
        found.seen = true;
        return found;
    }

    /// The wave at a point inside of a medium.
    arrived_wave at_point(std::size_t element, const place& at) const {
        const fan& own = fans_[element];
        const auto one = [&](std::uint32_t line) {
            const view<const element_wave> waves = own.line(line);
            std::size_t i = waves.size() - 1;
            while (i > 0 && waves[i].begin > at.distance) --i;
            return wave_at(waves[i], at.distance);
        };
        return mixed(one(at.line), 1 - at.part, one(at.line + 1), at.part);
    }
    /// The wave in front of a surface of two objects, of which lines know where they cross it.
    /// @param before, after  the objects on this side and behind it
    arrived_wave at_surface(std::size_t element, const place& at, std::uint32_t before, std::uint32_t after) const {
        const fan& own = fans_[element];
        // Neighbouring lines meet a steep surface at other distances; beyond this one, it is another part of it.
        const float near = 1e-3F + 0.1F * at.distance;
        bool found[2] = {};
        arrived_wave wave[2];
        for (int i = 0; i < 2; ++i) {
            const view<const element_wave> waves = own.line(at.line + static_cast<std::uint32_t>(i));
            float nearest = near;
            for (std::size_t k = 1; k < waves.size(); ++k) {
                const float apart = std::fabs(waves[k].begin - at.distance);
                if (waves[k - 1].object != before || waves[k].object != after || !(apart < nearest)) continue;
                nearest = apart;
                found[i] = true;
                wave[i] = wave_at(waves[k - 1], at.distance);
            }
        }
        if (found[0] && found[1]) return mixed(wave[0], 1 - at.part, wave[1], at.part);
        if (!found[0] && !found[1]) return {};
        const int seen = found[0] ? 0 : 1;
        arrived_wave alone = wave[seen];
        alone.amplitude *= found[0] ? 1 - at.part : at.part;
        return alone;
    }

    /// Sound speed in front of an element, m/s.
    float speed_at_face(std::size_t element) const { return 1 / fans_[element].line(lines_ / 2)[0].slowness; }

  private:
    static constexpr float span = 160 * pi / 180;

    struct fan {
        element_fan shape{};
        std::vector<element_wave> waves{};
        std::vector<std::uint32_t> ends{}; // of each line, in `waves`

        view<const element_wave> line(std::uint32_t i) const {
            const std::uint32_t begin = i == 0 ? 0 : ends[i - 1];
            return {waves.data() + begin, ends[i] - begin};
        }
    };

    static arrived_wave wave_at(const element_wave& from, float distance) {
        const float length = distance - from.begin, sound = from.slowness;
        float time = from.time + length * sound;
        const float open = 1 + from.bend * length / sound, open_across = 1 + from.bend_across * length / sound;
        // tilt^2 / (2 (bend + m)) with m = slowness / length
        if (length > 0 && open > min_open) time -= 0.5F * from.tilt * from.tilt * length / (sound * open);
        const float spread = from.begin == 0 ? distance : from.spread * max(open, min_open);
        const float across = from.begin == 0 ? distance : from.spread_across * max(open_across, min_open);
        return {.time = time,
                .amplitude = from.passed * std::exp(-(from.lost + from.per_metre * length)) /
                             std::sqrt(max(spread * across, 1e-10F)),
                .range = across,
                .lost_slope = from.lost_slope + from.slope_per_metre * length};
    }
    static constexpr float min_open = 0.1F; // near a caustic, amplitudes grow no further

    static arrived_wave mixed(const arrived_wave& a, float of_a, const arrived_wave& b, float of_b) {
        return {of_a * a.time + of_b * b.time, of_a * a.amplitude + of_b * b.amplitude, of_a * a.range + of_b * b.range,
                of_a * a.lost_slope + of_b * b.lost_slope};
    }

    // The wave at the beginning of a layer, from that in the layer before. @param entered  without what sound has met
    static element_wave carried(const element_wave& before, element_wave entered) {
        const float length = entered.begin - before.begin, sound = before.slowness;
        const bool first = before.begin == 0; // the wave comes from the element itself
        const float from_there =
            length > 0 ? sound / length : FLT_MAX; // bend of a wave from the beginning of the layer
        const arrived_wave end = wave_at(before, entered.begin);
        const auto share = [&](float bend) {
            return first ? 1 : from_there / max(bend + from_there, min_open * from_there);
        };
        entered.time = end.time;
        entered.tilt = before.tilt * share(before.bend);
        entered.bend = first ? from_there : before.bend * share(before.bend);
        entered.bend_across = first ? from_there : before.bend_across * share(before.bend_across);
        entered.spread = first ? entered.begin : before.spread / share(before.bend);
        entered.spread_across = end.range;
        entered.passed = before.passed;
        entered.lost = before.lost + before.per_metre * length;
        entered.lost_slope = before.lost_slope + before.slope_per_metre * length;
        return entered;
    }

    // Follows the wave along each line. @return whether the element lies inside of what blocks sound
    template <class Loss, class Passed, class Strip>
    static bool follow(const line_layers& found, float frequency, const Loss& loss, const Passed& passed,
                       const Strip& strip, fan& own) {
        own.waves.clear();
        own.ends.clear();
        const float beside = 1e-3F * frequency;
        const auto medium_of = [&](const layer& here) {
            const medium& m = found.media[here.medium];
            constexpr float one_way = 0.115129255F / 2; // Np per dB there and back
            return element_wave{
                .begin = here.begin,
                .slowness = 1 / m.sound_speed,
                .per_metre = one_way * loss(m, frequency),
                .slope_per_metre = one_way * (loss(m, frequency + beside) - loss(m, frequency - beside)) / (2 * beside),
                .medium = here.medium,
                .object = here.object};
        };
        const auto enter = [&](const element_wave& before, const layer& here) {
            element_wave now = carried(before, medium_of(here));
            if (here.medium == before.medium) return now;
            const float change = before.slowness - now.slowness;
            constexpr float steepest = 3; // beyond 72 degrees a surface is not plane as far as sound bends
            now.tilt -= clamp(here.slope.x, -steepest, steepest) * change;
            now.bend += clamp(here.curvature.x, -1e3F, 1e3F) * change;
            now.bend_across += clamp(here.curvature.y, -1e3F, 1e3F) * change;
            now.passed *= std::sqrt(
                max(passed(found.media[before.medium], found.media[here.medium], here.cosine, here.roughness), 0));
            return now;
        };
        for (std::uint32_t line = 0; line < found.lines; ++line) {
            const view<const layer> layers = found(line);
            if (blocks_sound(found.media[layers[0].medium])) return true;
            element_wave before = medium_of(layers[0]), above = before; // in the last layer, and in the one before
            own.waves.push_back(before);
            for (std::size_t i = 1; i < layers.size(); ++i) {
                element_wave now = enter(before, layers[i]);
                const layer& obstacle = layers[i - 1];
                if (i > 1 && obstacle.own_surfaces.x > 0 && obstacle.own_surfaces.y > 0) {
                    // As along lines of pictures (`add_sound_beside`): by power, at the time of what passes beside it.
                    element_wave around = enter(above, layers[i]);
                    const float through = now.passed / max(around.passed, 1e-30F) * std::exp(around.lost - now.lost);
                    const float power =
                        through < 0.5F ? power_beside(obstacle, layers[i], strip(obstacle.begin)) : 0.0F;
                    if (power > 0) {
                        around.passed *= std::sqrt((1 - power) * through * through + power);
                        now = around;
                    }
                }
                own.waves.push_back(now);
                above = before;
                before = now;
            }
            own.ends.push_back(static_cast<std::uint32_t>(own.waves.size()));
        }
        return false;
    }

    std::uint32_t lines_ = 2;
    std::vector<fan> fans_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
