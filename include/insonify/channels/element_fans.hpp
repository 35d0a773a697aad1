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
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/geometry/ray.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

    // Lines are equal steps of the tangent of half their angle apart: points are located without an arc tangent.
    float end() const { return std::tan(0.25F * span); }
    float angle(float line) const {
        return direction + 2 * std::atan((2 * line / static_cast<float>(lines - 1) - 1) * end());
    }
    ray beam(float line) const {
        return {.origin = origin, .direction = {std::sin(angle(line)), 0, std::cos(angle(line))}};
    }
    vec2 locate(vec2 p) const {
        const vec2 to{p.x - origin.x, p.y - origin.z};
        const float angle = std::remainder(std::atan2(to.x, to.y) - direction, 2 * pi);
        return {0.5F * (std::tan(0.5F * angle) / end() + 1) * static_cast<float>(lines - 1), length(to)};
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
struct alignas(64) element_wave { // a cache line
    float begin = 0;              ///< metres along the line
    float time = 0;               ///< s
    float tilt = 0, bend = 0;     ///< in the slice
    float bend_across = 0;        ///< out of the slice
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

/// The wave of an element at a point. Its amplitude is passed exp(-lost) / sqrt(spread * range), 1/m.
struct arrived_wave {
    float time = 0;       ///< s
    float passed = 0;     ///< factor on amplitude of the interfaces on the way; 0: nothing arrives
    float lost = 0;       ///< attenuation at the carrier, Np
    float spread = 1;     ///< the distance, in a uniform medium, metres
    float range = 1;      ///< the same out of the slice, metres
    float lost_slope = 0; ///< change of attenuation with frequency, Np/Hz
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
    /// @param max_bytes  what takes more is counted, but not kept: see `bytes`
    /// @throws usage_error  for an element inside of bone, metal or gas
    template <class Policy, class Loss, class Passed, class Strip>
    void assign(const Policy& policy, const scene& body, view<const ray> places, const pose& at, float frequency,
                float reach, const Loss& loss, const Passed& passed, const Strip& strip,
                std::uint64_t max_bytes = ~std::uint64_t{0}) {
        constexpr float spacing = 0.3e-3F; // of neighbouring lines at their ends, at most, metres
        lines_ = static_cast<std::uint32_t>(clamp(std::ceil(4 * std::tan(0.25F * span) * reach / spacing), 64, 1024));
        fans_.resize(places.size());
        for (std::vector<float>* const each : {&origin_x_, &origin_z_, &normal_x_, &normal_z_})
            each->assign(places.size() + max_simd_width, 0.0F); // in whole registers
        for (std::size_t i = 0; i < places.size(); ++i) {
            origin_x_[i] = places[i].origin.x;
            origin_z_[i] = places[i].origin.z;
            normal_x_[i] = places[i].direction.x;
            normal_z_[i] = places[i].direction.z;
        }
        enum class face : std::uint8_t { free, in_object, in_background }; // in front of an element: what blocks sound
        std::vector<face> faces(places.size(), face::free);
        std::atomic<std::uint64_t> bytes{0};
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
            own.slowness = 1 / found.media[found(lines_ / 2)[0].medium].sound_speed;
            for (std::uint32_t line = 0; line < found.lines; ++line)
                if (const layer& first = found(line)[0]; blocks_sound(found.media[first.medium])) {
                    faces[i] = first.object == ~0U ? face::in_background : face::in_object;
                    return;
                }
            std::size_t layers = 0;
            for (std::uint32_t line = 0; line < found.lines; ++line) layers += found(line).size();
            const std::uint64_t size =
                layers * (sizeof(element_wave) + sizeof(float)) + found.lines * sizeof(std::uint32_t);
            if (bytes.fetch_add(size) + size <= max_bytes) follow(found, layers, frequency, loss, passed, strip, own);
        });
        bytes_ = bytes;
        for (std::size_t i = 0; i < faces.size(); ++i) {
            if (faces[i] == face::in_object)
                throw usage_error{"trace_channels: element ", i,
                                  " lies inside of an object that blocks sound, such as bone, metal or gas; "
                                  "move the array, or the object"};
            if (faces[i] == face::in_background)
                throw usage_error{"trace_channels: element ", i,
                                  " lies in the background of the scene, which blocks sound as bone, metal or "
                                  "gas do; move the array into an object, or give the scene another "
                                  "background, such as tissue::gel"};
        }
    }

    /// What the layers of all lines take; beyond `max_bytes` they were not kept.
    std::uint64_t bytes() const { return bytes_; }

    /// Where a point lies among the lines of N elements.
    template <int N>
    struct located {
        lanes<N> line{0.0F};      ///< between two; negative: the element does not see the point
        lanes<N> distance{0.0F};  ///< from the element, metres, at least 1e-6
        lanes<N> per_metre{0.0F}; ///< 1 / distance
        lanes<N> sine{0.0F};      ///< of the angle to the element's normal
        lanes<N> cosine{0.0F};
    };
    /// @param first  of the elements; those beyond the last one have places without meaning
    template <int N>
    located<N> find(std::size_t first, vec2 p) const {
        using floats = lanes<N>;
        const auto row = [first](const std::vector<float>& of) { return load<N>(of.data() + first); };
        const floats x = floats(p.x) - row(origin_x_), z = floats(p.y) - row(origin_z_);
        const floats along_x = row(normal_x_), along_z = row(normal_z_);
        located<N> found;
        const floats distance = sqrt(x * x + z * z), nearest(1e-6F);
        found.distance = max(distance, nearest);
        found.per_metre = floats(1.0F) / found.distance;
        found.sine = (x * along_z - z * along_x) * found.per_metre;
        found.cosine = (x * along_x + z * along_z) * found.per_metre;
        const floats tangent = found.sine / max(floats(1.0F) + found.cosine, floats(1e-3F)); // of half the angle
        const float middle = 0.5F * static_cast<float>(lines_ - 1);
        const floats line = floats(middle) + floats(middle / std::tan(0.25F * span)) * tangent;
        const auto seen = floats(0.0F) <= line && line < floats(2 * middle) && nearest < distance;
        found.line = select(seen, line, floats(-1.0F));
        return found;
    }

    /// The wave at a point inside of a medium. @param line, distance  see `located`
    arrived_wave at_point(std::size_t element, float line, float distance) const {
        const fan& own = fans_[element];
        const auto first = static_cast<std::uint32_t>(line);
        const auto one = [&](std::uint32_t on) {
            const std::uint32_t begin = own.begin_of(on);
            std::uint32_t i = own.ends[on] - 1;
            while (i > begin && own.begins[i] > distance) --i;
            return wave_at(own.waves[i], distance);
        };
        return mixed(one(first), one(first + 1), line - static_cast<float>(first));
    }
    /// The wave in front of a surface of two objects, of which lines know where they cross it.
    /// @param before, after  the objects on this side and behind it
    arrived_wave at_surface(std::size_t element, float line, float distance, std::uint32_t before,
                            std::uint32_t after) const {
        const fan& own = fans_[element];
        const auto first = static_cast<std::uint32_t>(line);
        const float part = line - static_cast<float>(first);
        // Neighbouring lines meet a steep surface at other distances; beyond this one, it is another part of it.
        const float near = 1e-3F + 0.1F * distance;
        bool found[2] = {};
        arrived_wave wave[2];
        for (std::uint32_t i = 0; i < 2; ++i) {
            const view<const element_wave> waves = own.line(first + i);
            float nearest = near;
            for (std::size_t k = 1; k < waves.size(); ++k) {
                const float apart = std::fabs(waves[k].begin - distance);
                if (waves[k - 1].object != before || waves[k].object != after || !(apart < nearest)) continue;
                nearest = apart;
                found[i] = true;
                wave[i] = wave_at(waves[k - 1], distance);
            }
        }
        if (found[0] && found[1]) return mixed(wave[0], wave[1], part);
        if (!found[0] && !found[1]) return {};
        arrived_wave alone = found[0] ? wave[0] : wave[1];
        alone.passed *= found[0] ? 1 - part : part;
        return alone;
    }

    /// Sound speed in front of an element, m/s.
    float speed_at_face(std::size_t element) const { return 1 / fans_[element].slowness; }

  private:
    static constexpr float span = 160 * pi / 180;

    struct fan {
        element_fan shape{};
        float slowness = 0; // in front of the element, s/m
        std::vector<element_wave> waves{};
        std::vector<float> begins{};       // of waves, together: what is searched
        std::vector<std::uint32_t> ends{}; // of each line, in `waves`

        std::uint32_t begin_of(std::uint32_t line) const { return line == 0 ? 0 : ends[line - 1]; }
        view<const element_wave> line(std::uint32_t i) const {
            return {waves.data() + begin_of(i), ends[i] - begin_of(i)};
        }
    };

    static arrived_wave wave_at(const element_wave& from, float distance) {
        const float length = distance - from.begin, sound = from.slowness;
        const float lost = from.lost + from.per_metre * length, slope = from.lost_slope + from.slope_per_metre * length;
        if (from.begin == 0) return {length * sound, 1, lost, distance, distance, slope};
        const float open = 1 + from.bend * length / sound, open_across = 1 + from.bend_across * length / sound;
        float time = from.time + length * sound;
        // tilt^2 / (2 (bend + m)) with m = slowness / length
        if (length > 0 && open > min_open) time -= 0.5F * from.tilt * from.tilt * length / (sound * open);
        return {
            time, from.passed, lost, from.spread * max(open, min_open), from.spread_across * max(open_across, min_open),
            slope};
    }
    static constexpr float min_open = 0.1F; // near a caustic, amplitudes grow no further

    // Between two lines, a at part 0 and b at 1, by their shares of the amplitude: where one of them runs through bone,
    // the other one says when sound arrives.
    static arrived_wave mixed(const arrived_wave& a, const arrived_wave& b, float part) {
        const float min_lost = min(a.lost, b.lost);
        const auto left = [min_lost](const arrived_wave& one) {
            return one.lost == min_lost ? one.passed : one.passed * std::exp(min_lost - one.lost);
        };
        const float of_a = (1 - part) * left(a), of_b = part * left(b), passed = of_a + of_b;
        if (!(passed > 0)) return {};
        const float fraction = of_b / passed;
        const auto mix = [fraction](float from, float to) { return from + fraction * (to - from); };
        return {mix(a.time, b.time),
                passed,
                min_lost,
                mix(a.spread, b.spread),
                mix(a.range, b.range),
                mix(a.lost_slope, b.lost_slope)};
    }

    // The wave at the beginning of a layer, from that in the layer before. @param without  the same, without what sound
    // has met
    static element_wave carried(const element_wave& before, const element_wave& without) {
        element_wave entered = without; // by value, GCC would note the ABI of aligned parameters
        const float length = entered.begin - before.begin, sound = before.slowness;
        const bool first = before.begin == 0; // the wave comes from the element itself
        const float from_there =
            length > 0 ? sound / length : FLT_MAX; // bend of a wave from the beginning of the layer
        const arrived_wave end = wave_at(before, entered.begin);
        const auto fraction = [&](float bend) {
            return first ? 1 : from_there / max(bend + from_there, min_open * from_there);
        };
        entered.time = end.time;
        entered.tilt = before.tilt * fraction(before.bend);
        entered.bend = first ? from_there : before.bend * fraction(before.bend);
        entered.bend_across = first ? from_there : before.bend_across * fraction(before.bend_across);
        entered.spread = first ? entered.begin : before.spread / fraction(before.bend);
        entered.spread_across = end.range;
        entered.passed = before.passed;
        entered.lost = before.lost + before.per_metre * length;
        entered.lost_slope = before.lost_slope + before.slope_per_metre * length;
        return entered;
    }

    // Follows the wave along each line. @param layers  of all lines
    template <class Loss, class Passed, class Strip>
    static void follow(const line_layers& found, std::size_t layers, float frequency, const Loss& loss,
                       const Passed& passed, const Strip& strip, fan& own) {
        own.waves.clear();
        own.ends.clear();
        own.waves.reserve(layers);
        own.ends.reserve(found.lines);
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
            const view<const layer> own_layers = found(line);
            element_wave before = medium_of(own_layers[0]), above = before; // in the last layer, and in the one before
            own.waves.push_back(before);
            for (std::size_t i = 1; i < own_layers.size(); ++i) {
                element_wave now = enter(before, own_layers[i]);
                const layer& obstacle = own_layers[i - 1];
                if (i > 1 && obstacle.own_begin.cosine > 0 && obstacle.own_end.cosine > 0) {
                    // As along lines of pictures (`add_sound_beside`): by power, at the time of what passes beside it.
                    element_wave around = enter(above, own_layers[i]);
                    const float through = now.passed / max(around.passed, 1e-30F) * std::exp(around.lost - now.lost);
                    const float power =
                        through < 0.5F ? power_beside(obstacle, own_layers[i], strip(obstacle.begin)) : 0.0F;
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
        own.begins.clear();
        own.begins.reserve(layers);
        for (const element_wave& one : own.waves) own.begins.push_back(one.begin);
    }

    std::uint32_t lines_ = 2;
    std::uint64_t bytes_ = 0;
    std::vector<fan> fans_{};
    std::vector<float> origin_x_{}, origin_z_{}, normal_x_{}, normal_z_{}; // of the elements
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
