#ifndef INSONIFY_CHANNELS_OPTIONS_HPP
#define INSONIFY_CHANNELS_OPTIONS_HPP

#include <insonify/channels/element_array.hpp>
#include <insonify/channels/transmit.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include "../command_line.hpp"
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace channels {

using namespace insonify;

/// The command line of `channels`; lengths in millimetres, frequencies in megahertz, angles in degrees.
struct options {
    std::string file{}; ///< empty: a phantom
    float unit = 1;
    std::string background = "deep_fat";
    bool repair = false;
    float pennation = 0;
    std::string phantom = "nerve_block";
    std::optional<std::array<float, 3>> from{}, towards{};
    std::array<float, 3> lateral{1, 0, 0};
    std::string array = "l11_5v";
    std::string transmits = "plane:11:20";
    float depth = 40;
    std::uint32_t frames = 1;
    float sampling_frequency = 0; ///< 0: four times the carrier
    std::optional<float> noise{};
    bool iq = false, wave_fronts = false;
    std::string format = "zea";
    std::string output = "channels.hdf5";
};

/// The arrays that --array names: see `find_array`.
inline const std::vector<std::string> array_names{"l11_5v", "l12_3v", "c5_2v", "p4_2v"};

/// Declares the options and where their values are stored.
inline void add_options(CLI::App& app, options& into) {
    using namespace command_line;
    app.description("Writes what each element of an ultrasound array receives from an OBJ file or a phantom.\n"
                    "Lengths are in millimetres unless a unit follows (4cm), frequencies in megahertz, angles in "
                    "degrees.");
    CLI::Option* const file =
        add(app, "file", into.file, "OBJ", "Wavefront OBJ; its materials name the tissues")->check(name());
    add(app, "--unit", into.unit, "LENGTH", "length of 1 in the file, above 0, at most 10m (1mm)")
        ->transform(length())
        ->check(positive_number(1e4))
        ->needs(file);
    add(app, "--background", into.background, "TISSUE", "medium around the objects of the file (deep_fat)")
        ->check(name())
        ->needs(file);
    add_mesh_options(app, into.repair, into.pennation, file);
    add(app, "--phantom", into.phantom, "NAME",
        "without a file: nerve_block, a limb; points, nine point scatterers in a fluid of 1540 m/s (nerve_block)")
        ->check(CLI::IsMember({"nerve_block", "points"}))
        ->excludes(file);
    auto* const from = add_list<3, float>(app, "--from", into.from, ',', length(), "X,Y,Z",
                                          "position of the array: the middle of its face");
    auto* const towards =
        add_list<3, float>(app, "--towards", into.towards, ',', length(), "X,Y,Z",
                           "point that the array looks at (default: along y, at the centre of all objects)");
    from->needs(towards);
    towards->needs(from);
    add_list<3, float>(app, "--lateral", into.lateral, ',', number(-1e6, 1e6), "X,Y,Z",
                       "direction of the array, with --from (1,0,0)")
        ->needs(from);
    add(app, "--array", into.array, "NAME", "l11_5v, l12_3v: linear; c5_2v: convex; p4_2v: phased (l11_5v)")
        ->check(CLI::IsMember(array_names));
    add(app, "--transmits", into.transmits, "KIND",
        "plane:COUNT:ANGLE, plane waves spread over an angle; diverging:COUNT:ANGLE:LENGTH, from so far behind the "
        "face; focused:COUNT:DEPTH, beams side by side; focused:COUNT:DEPTH:ANGLE, beams from the middle of the face; "
        "fsa, every element alone (plane:11:20)")
        ->check(name());
    add(app, "--depth", into.depth, "LENGTH", "to be recorded, at most 1m (40)")
        ->transform(length())
        ->check(positive_number(1000));
    add_whole_number(app, "--frames", into.frames, "COUNT", "frames, which differ in flowing media and noise", 1, 1000);
    add(app, "--sampling-frequency", into.sampling_frequency, "FREQUENCY",
        "of RF, at most 1000MHz; 0: four times the carrier (0)")
        ->transform(frequency())
        ->check(number(0, 1000));
    add(app, "--noise", into.noise, "NUMBER",
        "electronic noise of an element, dB relative to the echo of a perfect mirror, -200 to 0 (none)")
        ->check(number(-200, 0));
    app.add_flag("--iq", into.iq, "IQ, demodulated with the carrier, instead of RF");
    app.add_flag("--wave-fronts", into.wave_fronts,
                 "each transmit as one wave front: faster, without waves from the ends of the aperture");
    add(app, "--format", into.format, "NAME", "zea, or uff: the channel data of USTB (zea)")
        ->check(CLI::IsMember({"zea", "uff"}));
    add(app, "--output", into.output, "FILE", "HDF5 file that is written (channels.hdf5)")->check(name());
}

/// An array that --array names.
struct named_array {
    const char* name; ///< of the option
    const char* title;
    const char* type;  ///< linear, phased or curved
    float opening_deg; ///< beyond the ends of the array, of the slice that is covered
    std::variant<element_array, convex_element_array> elements;
};

inline const named_array& find_array(const std::string& name) {
    static const named_array all[] = {
        {"l11_5v", "L11-5v", "linear", 30, presets::l11_5v_elements},
        {"l12_3v", "L12-3v", "linear", 30, presets::l12_3v_elements},
        {"c5_2v", "C5-2v", "curved", 30, presets::c5_2v_elements},
        {"p4_2v", "P4-2v", "phased", 45, presets::p4_2v_elements},
    };
    for (const named_array& one : all)
        if (one.name == name) return one;
    throw usage_error{"--array: there is no array '" + name + "'"};
}

/// The transmits that --transmits names.
/// @throws usage_error  for a word that is none of its kinds, or numbers out of range
template <element_transducer Array>
std::vector<transmit> transmits_named(const std::string& text, const Array& array) {
    const std::vector<std::string> words = CLI::detail::split(text, ':');
    const std::string& kind = words[0];
    const auto fail = [&](const std::string& what) -> usage_error {
        return usage_error{"--transmits: '" + text + "': " + what};
    };
    if (text == "fsa") return full_synthetic_aperture(array);
    const bool is_complete =
        !text.ends_with(':') && ((kind == "plane" && words.size() == 3) || (kind == "diverging" && words.size() == 4) ||
                                 (kind == "focused" && (words.size() == 3 || words.size() == 4)));
    if (!is_complete)
        throw fail("it must be plane:COUNT:ANGLE, diverging:COUNT:ANGLE:LENGTH, focused:COUNT:DEPTH, "
                   "focused:COUNT:DEPTH:ANGLE or fsa");
    if (const std::string fault = command_line::whole_number(1, 1024)(words[1]); !fault.empty())
        throw fail("the count " + fault);
    const auto count = static_cast<std::uint32_t>(std::stoul(words[1]));
    const auto length_of = [&](std::string word) {
        if (std::string fault = command_line::length()(word); !fault.empty()) throw fail(fault);
        if (const std::string fault = command_line::positive_number(1000)(word); !fault.empty())
            throw fail("the length " + fault);
        return static_cast<float>(units::number_of(word)) * 1_mm;
    };
    const auto angle_of = [&](std::string word) {
        if (std::string fault = command_line::angle()(word); !fault.empty()) throw fail(fault);
        if (const std::string fault = command_line::number(0, 160)(word); !fault.empty())
            throw fail("the angle " + fault);
        return static_cast<float>(units::number_of(word)) * 1_deg;
    };
    const auto fraction = [&](std::uint32_t i) { // -0.5 to 0.5, both ends included
        return count == 1 ? 0.0F : static_cast<float>(i) / static_cast<float>(count - 1) - 0.5F;
    };
    const auto towards = [&](float angle) { return vec3{std::sin(angle), 0, std::cos(angle)}; };
    if (kind == "plane") return plane_waves(array, count, angle_of(words[2]));
    std::vector<vec3> points(count);
    if (kind == "diverging") {
        const float spread = angle_of(words[2]), behind = length_of(words[3]);
        for (std::uint32_t i = 0; i < count; ++i) points[i] = -behind * towards(spread * fraction(i));
        return diverging_waves(array, points);
    }
    const float depth = length_of(words[2]);
    if (words.size() == 4) {
        const float spread = angle_of(words[3]);
        for (std::uint32_t i = 0; i < count; ++i) points[i] = depth * towards(spread * fraction(i));
        return focused(array, points);
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        const float place = (static_cast<float>(i) + 0.5F) / static_cast<float>(count);
        const ray beam = array.element(static_cast<std::uint32_t>(place * static_cast<float>(array.elements)));
        points[i] = beam.origin + depth * beam.direction;
    }
    return focused(array, points, array.fnumber);
}

} // namespace channels
#endif
