#ifndef INSONIFY_CHANNELS_ZONES_HPP
#define INSONIFY_CHANNELS_ZONES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/channels/element_fans.hpp>
#include <insonify/channels/pair_sums.hpp>
#include <insonify/channels/reflectors.hpp>
#include <insonify/core/math.hpp>
#include <insonify/execution/policy.hpp>
#include <algorithm>
#include <cfloat>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Reflectors on whose way attenuation changes about equally with frequency. One filter applies it to all of them.
struct zone {
    std::size_t begin = 0, end = 0; ///< reflectors
    float slope = 0;                ///< there and back: change with frequency, Np/Hz
};

struct zone_key {
    vec2 place;
    float slope; // there and back, Np/Hz
    std::uint32_t zone, reflector;
};

// Of the attenuation there and back from the elements that see a place: what others see through bone is of no
// account. The nearest element and some others stand for all.
template <class Deferred = void>
float smallest_slope(vec2 place, const element_fans& fans, view<const ray> places) {
    float smallest = FLT_MAX;
    const auto see = [&](std::size_t element) {
        const auto at = fans.find<1>(element, place);
        const float line = sum(at.line);
        if (!(line >= 0)) return;
        const arrived_wave wave = fans.at_point(element, line, sum(at.distance));
        if (wave.passed > 0) smallest = min(smallest, 2 * wave.lost_slope);
    };
    see(nearest_element(places, place));
    for (std::size_t k = 1; k < 8; k += 2) see(k * places.size() / 8);
    return smallest < FLT_MAX ? smallest : 0;
}

// Neighbours in the order of reflectors, which are halved again and again.
struct key_range {
    zone_key *begin, *end;

    std::size_t size() const { return static_cast<std::size_t>(end - begin); }
    bool is_block() const { return size() <= reflectors_per_block; }
    zone_key* middle() const { // at whole blocks
        const std::size_t blocks = (size() + reflectors_per_block - 1) / reflectors_per_block;
        return begin + blocks / 2 * reflectors_per_block;
    }
};

// Halves a range across its longer side, or sorts a block. Those at one place keep their order.
template <class Deferred = void>
void halve(const key_range& one) {
    const auto by_x = [](const zone_key& a, const zone_key& b) {
        return std::tuple{a.place.x, a.place.y, a.reflector} < std::tuple{b.place.x, b.place.y, b.reflector};
    };
    const auto by_depth = [](const zone_key& a, const zone_key& b) {
        return std::tuple{a.place.y, a.place.x, a.reflector} < std::tuple{b.place.y, b.place.x, b.reflector};
    };
    if (one.is_block()) {
        std::sort(one.begin, one.end, by_x);
        return;
    }
    const auto [left, right] = std::minmax_element(one.begin, one.end, by_x);
    const auto [top, bottom] = std::minmax_element(one.begin, one.end, by_depth);
    if (right->place.x - left->place.x > bottom->place.y - top->place.y)
        std::nth_element(one.begin, one.middle(), one.end, by_x);
    else
        std::nth_element(one.begin, one.middle(), one.end, by_depth);
}

template <exec::policy Policy>
void sort_into_blocks(const Policy& policy, const key_range& all) {
    for (std::vector<key_range> ranges{all}; !ranges.empty();) {
        exec::for_each_in_blocks(policy, ranges.size(), 1, 30 * static_cast<float>(ranges[0].size()),
                                 [&](std::size_t i) { halve(ranges[i]); });
        std::vector<key_range> halves;
        for (const key_range& one : ranges)
            if (!one.is_block()) halves.insert(halves.end(), {{one.begin, one.middle()}, {one.middle(), one.end}});
        ranges = std::move(halves);
    }
}

/// Sorts reflectors into zones, and each zone into blocks that are small in space, so that each adds to few samples of
/// a pair of elements. Within a block they are sorted by x: neighbours, which differ in depth, add to different
/// samples.
/// @param sigma_frequency  of the amplitude spectrum, hertz
template <exec::policy Policy>
std::vector<zone> sort_into_zones(const Policy& policy, std::vector<reflector>& all, const element_fans& fans,
                                  view<const ray> places, float sigma_frequency) {
    constexpr float last = 12;   // returns less than -90 dB, of a carrier three deviations from 0 Hz
    constexpr float step = 0.3F; // Np over a standard deviation of the spectrum; its square over 8 is neglected
    std::vector<zone_key> keys(all.size());
    exec::for_each_in_blocks(policy, all.size(), 256, 100, [&](std::size_t i) {
        const float slope = smallest_slope(all[i].place, fans, places);
        keys[i] = {all[i].place, slope, static_cast<std::uint32_t>(clamp(slope * sigma_frequency / step, 0, last)),
                   static_cast<std::uint32_t>(i)};
    });
    std::sort(keys.begin(), keys.end(), [](const zone_key& a, const zone_key& b) {
        return a.zone < b.zone || (a.zone == b.zone && a.reflector < b.reflector);
    });
    std::vector<zone> zones;
    for (std::size_t begin = 0, end = 0; begin < keys.size(); begin = end) {
        while (end < keys.size() && keys[end].zone == keys[begin].zone) ++end;
        sort_into_blocks(policy, {keys.data() + begin, keys.data() + end});
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += static_cast<double>(keys[i].slope);
        zones.push_back({begin, end, static_cast<float>(sum / static_cast<double>(end - begin))});
    }
    std::vector<reflector> sorted(all.size());
    for (std::size_t i = 0; i < keys.size(); ++i) sorted[i] = all[keys[i].reflector];
    all = std::move(sorted);
    return zones;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
