#ifndef INSONIFY_CHANNELS_OPTIONS_HPP
#define INSONIFY_CHANNELS_OPTIONS_HPP

#include "../body_options.hpp"
#include "arrays.hpp"
#include <cstdint>
#include <optional>
#include <string>

namespace channels {

/// The command line of `channels`; lengths in millimetres, frequencies in megahertz, angles in degrees.
struct options : body_options {
    std::string phantom = "nerve_block";
    std::string array{}; ///< empty: of the kind of the probe of a view
    std::string transmits = "plane:11:20";
    std::optional<float> depth{};
    std::uint32_t frames = 1;
    float sampling_frequency = 0; ///< 0: four times the carrier
    std::optional<float> noise{};
    float memory = 4;
    bool iq = false, wave_fronts = false;
    std::string format = "zea";
    std::string output = "channels.hdf5";
};

/// Declares the options and where their values are stored.
inline void add_options(CLI::App& app, options& into) {
    using namespace command_line;
    app.description(
        "Writes what each element of an ultrasound array receives from an OBJ file, a region of the body or a "
        "phantom.\n"
        "Lengths are in millimetres unless a unit follows (4cm), frequencies in megahertz, angles in "
        "degrees.");
    CLI::Option* const file = add_body_options(app, into, "array");
    add(app, "--phantom", into.phantom, "NAME",
        "without a file or a region: nerve_block, a limb; points, nine point scatterers in a fluid of 1540 m/s "
        "(nerve_block)")
        ->check(CLI::IsMember({"nerve_block", "points"}))
        ->excludes(file)
        ->excludes(app.get_option("--anatomy"));
    add(app, "--array", into.array, "NAME",
        "l11_5v, l12_3v: linear; c5_2v: convex; p4_2v: phased (l11_5v; of a view the first that scans as its probe)")
        ->check(CLI::IsMember(array_names()));
    add(app, "--transmits", into.transmits, "KIND",
        "plane:COUNT:ANGLE, plane waves spread over an angle; diverging:COUNT:ANGLE:LENGTH, from so far behind the "
        "face; focused:COUNT:DEPTH, beams side by side; focused:COUNT:DEPTH:ANGLE, beams from the middle of the face; "
        "fsa, every element alone (plane:11:20)")
        ->check(name());
    add(app, "--depth", into.depth, "LENGTH", "to be recorded, at most 1m (40; of a view its own)")
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
    add(app, "--memory", into.memory, "NUMBER", "memory that a frame may take, GB, 0.1 to 1000 (4)")
        ->check(number(0.1, 1000));
    app.add_flag("--iq", into.iq, "IQ, demodulated with the carrier, instead of RF");
    app.add_flag("--wave-fronts", into.wave_fronts,
                 "each transmit as one wave front: faster, without waves from the ends of the aperture");
    add(app, "--format", into.format, "NAME", "zea, or uff: the channel data of USTB (zea)")
        ->check(CLI::IsMember({"zea", "uff"}));
    add(app, "--output", into.output, "FILE", "HDF5 file that is written (channels.hdf5)")->check(name());
}

} // namespace channels
#endif
