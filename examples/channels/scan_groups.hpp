#ifndef INSONIFY_CHANNELS_SCAN_GROUPS_HPP
#define INSONIFY_CHANNELS_SCAN_GROUPS_HPP

#include <insonify/channels/channel_data.hpp>
#include "../dataset/hdf5_file.hpp"
#include "arrays.hpp"
#include <cmath>
#include <limits>
#include <string>
#include <vector>

/// How channel data were acquired, as zea describes it.
namespace channels {

using dataset::hdf5_file, dataset::no_unit, dataset::number_type;

namespace detail {

// What a file says of each transmit.
struct transmit_facts {
    float focus = 0, polar = 0;
};
inline transmit_facts facts_of(const transmit& one) {
    const vec3 away = one.front == transmit::wave::diverging ? one.origin - one.source : one.source - one.origin;
    switch (one.front) {
    case transmit::wave::focused:
        return {length(away), std::atan2(away.x, away.z)};
    case transmit::wave::diverging:
        return {-length(away), length(away) > 0 ? std::atan2(away.x, away.z) : 0};
    default:
        return {std::numeric_limits<float>::infinity(), one.angle};
    }
}

} // namespace detail

/// The group of the transmits. @param of  the acquisition; its samples do not matter
inline void add_scan(hdf5_file& file, const channel_data& of) {
    const std::string scan = "tracks/track_0/scan";
    file.add_group(scan, "how the data were acquired");
    const auto number = [&](const char* name, const char* unit, const char* text, float value) {
        file.add_number({scan + "/" + name, unit, text}, value);
    };
    const hsize_t transmits = of.transmits, elements = of.elements;
    const auto array = [&](const char* name, const std::string& unit, const char* text, std::vector<hsize_t> shape,
                           const std::vector<float>& values) {
        file.add_array({scan + "/" + name, unit, text}, number_type::real, shape, values.data());
    };
    number("sampling_frequency", "Hz", "of raw_data", of.sampling_frequency);
    number("center_frequency", "Hz", "of the carrier", of.frequency);
    number("demodulation_frequency", "Hz", "of the carrier: IQ has been demodulated with it, RF may be", of.frequency);
    number("sound_speed", "m/s", "that delays assume; that of the tissue is in sos_map", of.sound_speed);
    std::vector<float> delays, weights, focus, polar, origins;
    for (const transmit& one : of.sent) {
        delays.insert(delays.end(), one.delays.begin(), one.delays.end());
        for (std::uint32_t e = 0; e < of.elements; ++e) weights.push_back(one.weight(e));
        const detail::transmit_facts facts = detail::facts_of(one);
        focus.push_back(facts.focus);
        polar.push_back(facts.polar);
        origins.insert(origins.end(), {one.origin.x, one.origin.y, one.origin.z});
    }
    array("initial_times", "s",
          "from the first element firing to the first sample; the envelope of an echo peaks at its travel time",
          {transmits}, std::vector<float>(transmits, of.start));
    array("t0_delays", "s", "when each element fires; the first one at 0", {transmits, elements}, delays);
    array("tx_apodizations", no_unit, "weight with which each element fires", {transmits, elements}, weights);
    array("focus_distances", "m",
          "from the origin to the focus; negative: to a virtual source behind the face; infinite: plane wave; 0: one "
          "element alone",
          {transmits}, focus);
    array("transmit_origins", "m", "middle of the elements that fire", {transmits, 3}, origins);
    array("polar_angles", "rad", "of the beam, from z towards x", {transmits}, polar);
    array("azimuth_angles", "rad", "of the beam: all lie in the plane of x and z", {transmits},
          std::vector<float>(transmits, 0));

    // Of the pulse there and back: a Gaussian around the carrier.
    constexpr float rate = 250e6F; // by zea
    const float sigma = 2.3548F / (2 * pi * of.bandwidth * of.frequency);
    const int half = static_cast<int>(std::ceil(4 * sigma * rate));
    std::vector<float> pulse;
    for (int k = -half; k <= half; ++k) {
        const float time = static_cast<float>(k) / rate, x = time / sigma;
        pulse.push_back(std::exp(-0.5F * x * x) * std::cos(2 * pi * of.frequency * time));
    }
    std::vector<float> all;
    for (std::uint32_t t = 0; t < of.transmits; ++t) all.insert(all.end(), pulse.begin(), pulse.end());
    array("waveforms_two_way", "V",
          "pulse there and back, sampled at 250 MHz, of amplitude 1; its middle sample, the peak of its envelope, is "
          "received at the travel time of an echo",
          {transmits, pulse.size()}, all);
}

/// The group of the array.
inline void add_probe(hdf5_file& file, const named_array& array, const channel_data& of) {
    file.add_group("probe", "the array");
    file.add_text({"probe/name", no_unit, "of the array"}, array.title);
    file.add_text({"probe/type", no_unit, "linear, curved or phased"}, array.type);
    file.add_number({"probe/probe_center_frequency", "Hz", "of the carrier"}, of.frequency);
    file.add_number({"probe/probe_bandwidth_percent", "%", "of the pulse there and back, at -6 dB"},
                    100 * of.bandwidth);
    file.add_number({"probe/element_width", "m", "along the array"}, of.element_width);
    file.add_number({"probe/element_height", "m", "out of the slice plane"}, of.height);
    std::vector<float> places;
    for (const ray& one : of.places) places.insert(places.end(), {one.origin.x, one.origin.y, one.origin.z});
    file.add_array({"probe/probe_geometry", "m", "centre of each element: x lateral, y elevation, z depth"},
                   number_type::real, {of.elements, 3}, places.data());
}

} // namespace channels
#endif
