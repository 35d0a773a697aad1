#ifndef INSONIFY_CHANNELS_UFF_FILE_HPP
#define INSONIFY_CHANNELS_UFF_FILE_HPP

#include "../dataset/hdf5_file.hpp"
#include "recording.hpp"
#include <cmath>
#include <limits>
#include <string>
#include <vector>

/// Channel data as the class uff.channel_data of USTB, which MATLAB writes: axes are in reverse order, all numbers are
/// float32, and texts are the codes of their letters.
namespace channels {
namespace detail {

class uff_writer {
  public:
    uff_writer() { file_.set_text("version", "v1.2.0"); }

    std::string image() const { return file_.image(); }

    void add_object(const std::string& path, const std::string& type, std::size_t count = 1, bool is_array = false) {
        file_.add_group(path, type);
        describe(path, type);
        file_.set_numbers(path, "size", {1, static_cast<double>(count)});
        file_.set_numbers(path, "array", {is_array ? 1.0 : 0.0});
    }
    void add_number(const std::string& path, const std::string& unit, float value, const std::string& type = "double") {
        add_numbers(path, unit, {1, 1}, {value}, type);
    }
    void add_numbers(const std::string& path, const std::string& unit, const std::vector<hsize_t>& shape,
                     const std::vector<float>& values, const std::string& type = "double") {
        file_.add_array({path, unit, ""}, dataset::number_type::real, shape, values.data());
        describe(path, type);
        describe_real(path, false);
    }
    void add_text(const std::string& path, const std::string& text) {
        const std::vector<float> letters{text.begin(), text.end()};
        add_numbers(path, "", {letters.size(), 1}, letters, "char");
    }
    void add_point(const std::string& path, float distance, float azimuth) {
        add_object(path, "uff.point");
        add_number(path + "/distance", "m", distance);
        add_number(path + "/azimuth", "rad", azimuth);
        add_number(path + "/elevation", "rad", 0);
    }
    /// Real, or the two parts of complex numbers.
    std::vector<dataset::hdf5_file::piecewise_array> add_data(const std::string& path,
                                                              const std::vector<hsize_t>& shape, std::uint32_t parts) {
        const auto add = [&](const std::string& name, bool imaginary) {
            auto made = file_.add_pieces({name, "", "1 is the echo of a perfect mirror"}, shape);
            describe(name, "single");
            describe_real(name, imaginary);
            return made;
        };
        std::vector<dataset::hdf5_file::piecewise_array> made;
        if (parts == 1) {
            made.push_back(add(path, false));
            return made;
        }
        file_.add_group(path, "complex numbers");
        describe(path, "single");
        file_.set_numbers(path, "complex", {1});
        made.push_back(add(path + "/real", false));
        made.push_back(add(path + "/imag", true));
        return made;
    }

  private:
    void describe(const std::string& path, const std::string& type) {
        file_.set_text("class", type, path);
        file_.set_text("name", path.substr(path.rfind('/') + 1), path);
    }
    void describe_real(const std::string& path, bool imaginary) {
        file_.set_numbers(path, "imaginary", {imaginary ? 1.0 : 0.0});
        file_.set_numbers(path, "complex", {0});
    }

    dataset::hdf5_file file_{};
};

// A wave as USTB has it.
struct uff_wave {
    float distance, azimuth, delay;
    bool is_plane;
};

/// USTB computes when a wave arrives at a point p, seconds after t0, as p * direction / c for a plane wave, and as
/// (+-|p - source| + |source|) / c or, for sources more than 1 mm behind the origin, (|p - source| - |source|) / c
/// (process/das.m). So t0 is when the wave passes the origin; of a single element, which has no such time, it is
/// |source| / c before it fires. The delay is from t0 to the time at which `initial_time` counts from 0.
inline uff_wave uff_wave_of(const transmit& one, const channel_data& of) {
    std::uint32_t first = 0;
    while (one.weight(first) == 0) ++first;
    const vec3 from = of.places[first].origin; // its wave is part of the front
    const float fires = one.delays[first], c = of.sound_speed;
    if (one.front == transmit::wave::plane) {
        const float arrives = dot(from, vec3{std::sin(one.angle), 0, std::cos(one.angle)}) / c;
        return {std::numeric_limits<float>::infinity(), one.angle, arrives - fires, true};
    }
    const float distance = length(one.source), apart = length(from - one.source);
    constexpr float behind = -1e-3F; // by USTB
    const bool is_focused = one.front == transmit::wave::focused;
    const float arrives = (is_focused ? -apart : apart) + (one.source.z < behind ? -distance : distance);
    return {distance, distance > 0 ? std::atan2(one.source.x, one.source.z) : 0, arrives / c - fires, false};
}

inline void add_probe(uff_writer& file, const channel_data& of) {
    file.add_object("channel_data/probe", "uff.probe");
    file.add_point("channel_data/probe/origin", 0, 0);
    std::vector<float> rows[7]; // x y z theta phi width height
    for (const ray& one : of.places) {
        const float values[7]{
            one.origin.x,     one.origin.y, one.origin.z, std::atan2(one.direction.x, one.direction.z), 0,
            of.element_width, of.height};
        for (int i = 0; i < 7; ++i) rows[i].push_back(values[i]);
    }
    std::vector<float> geometry;
    for (const std::vector<float>& row : rows) geometry.insert(geometry.end(), row.begin(), row.end());
    file.add_numbers("channel_data/probe/geometry", "m, rad", {7, of.elements}, geometry);
}

inline void add_sequence(uff_writer& file, const channel_data& of) {
    const std::string sequence = "channel_data/sequence";
    file.add_object(sequence, "uff.wave", of.transmits, true);
    for (std::uint32_t t = 0; t < of.transmits; ++t) {
        char name[24];
        std::snprintf(name, sizeof name, "/sequence_%04u", t + 1);
        const std::string path = sequence + name;
        const uff_wave wave = uff_wave_of(of.sent[t], of);
        file.add_object(path, "uff.wave");
        file.add_number(path + "/wavefront", "", wave.is_plane ? 0 : 1, "uff.wavefront");
        file.add_point(path + "/source", wave.distance, wave.azimuth);
        file.add_number(path + "/event", "", static_cast<float>(t + 1));
        file.add_number(path + "/delay", "s", wave.delay);
        file.add_number(path + "/sound_speed", "m/s", of.sound_speed);
        file.add_object(path + "/apodization", "uff.apodization");
        file.add_number(path + "/apodization/window", "", 0, "uff.window"); // none
    }
}

} // namespace detail

/// The bytes of a file.
inline std::string uff_file(const recording& of) {
    frame_data first = of.trace_one(0);
    check_size(of, first);
    const channel_data data = insonify::detail::same_acquisition<float>(first.received);
    const std::uint32_t parts = first.parts();
    detail::uff_writer file;
    file.add_object("channel_data", "uff.channel_data");
    file.add_text("channel_data/name", of.title);
    file.add_number("channel_data/sampling_frequency", "Hz", data.sampling_frequency);
    file.add_number("channel_data/initial_time", "s", data.start);
    file.add_number("channel_data/sound_speed", "m/s", data.sound_speed);
    file.add_number("channel_data/modulation_frequency", "Hz", parts == 1 ? 0 : data.frequency);
    file.add_object("channel_data/pulse", "uff.pulse");
    file.add_number("channel_data/pulse/center_frequency", "Hz", data.frequency);
    file.add_number("channel_data/pulse/fractional_bandwidth", "", data.bandwidth);
    file.add_number("channel_data/pulse/phase", "rad", 0);
    if (!of.points.empty()) {
        std::vector<float> rows[4]; // x y z Gamma
        for (const point_scatterer& one : of.points) {
            const float values[4]{one.position.x, one.position.y, one.position.z, one.scattering_length};
            for (int i = 0; i < 4; ++i) rows[i].push_back(values[i]);
        }
        std::vector<float> points;
        for (const std::vector<float>& row : rows) points.insert(points.end(), row.begin(), row.end());
        file.add_object("channel_data/phantom", "uff.phantom");
        file.add_numbers("channel_data/phantom/points", "m", {4, of.points.size()}, points);
        file.add_number("channel_data/phantom/sound_speed", "m/s", data.sound_speed);
    }
    detail::add_probe(file, data);
    detail::add_sequence(file, data);
    const std::vector<dataset::hdf5_file::piecewise_array> arrays =
        file.add_data("channel_data/data", {of.frames, data.transmits, data.elements, data.samples}, parts);
    std::vector<float> piece(std::size_t{data.samples} * data.elements);
    for_each_transmit(of, std::move(first), [&](std::uint32_t frame, std::uint32_t t, const frame_data& one) {
        for (std::uint32_t part = 0; part < parts; ++part) {
            std::size_t i = 0;
            for (std::uint32_t e = 0; e < data.elements; ++e)
                for (std::uint32_t k = 0; k < data.samples; ++k) piece[i++] = one(part, t, e, k);
            arrays[part].write(frame, t, piece);
        }
    });
    return file.image();
}

} // namespace channels
#endif
