#ifndef INSONIFY_DATASET_DESCRIPTION_HPP
#define INSONIFY_DATASET_DESCRIPTION_HPP

#include <insonify/insonify.hpp>
#include "range.hpp"
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dataset {

using namespace insonify;

/// What the samples of a dataset have in common, and what varies from one to the next. Lengths are millimetres, as on the
/// command line.
struct description {
    std::uint64_t seed = 1;
    std::uint32_t samples = 100;
    std::uint32_t size = 256; ///< columns and rows
    std::string output = "dataset";
    std::string format = "hdf5";           ///< hdf5 or png
    std::uint32_t part = 32;               ///< samples in each file
    bool iq = false;                       ///< store IQ and envelope, too
    std::string channels{};                ///< array whose channel data are stored, too; empty: none
    std::string transmits = "plane:11:20"; ///< of it
    bool no_truth = false;                 ///< store no maps but the labels
    bool plan = false;                     ///< print what would be done
    bool verify = false;                   ///< check the parts that there are

    std::vector<std::string> anatomy{};    ///< names of regions, and OBJ files; none: all regions
    std::vector<std::string> views{};      ///< of the regions; none: all
    std::vector<std::string> parameters{}; ///< of the regions: name=range; without, all of its own
    float unit = 1;                        ///< of the OBJ files
    std::string background = "fat";
    float skin = 1.5F;   ///< below the surface of an object that encloses all others
    bool repair = false; ///< of their meshes
    float pennation = 0; ///< of their muscles, degrees
    range scale{1, 1};
    range bend{0, 2}; ///< rms of a smooth random displacement
    float bend_length = 60;

    // Of OBJ files. A region has views.
    std::string around{}; ///< name of the object that the probe is placed on; empty: the first that it meets
    std::array<float, 3> from{0, 0, -1};   ///< direction from which the probe looks
    std::array<float, 3> lateral{1, 0, 0}; ///< of the array

    // What is missing varies about what a view has: see `draw_sample`.
    range spread{0, 10};                           ///< angle between the probe's place and that of the view, degrees
    range along{-8, 8}, across{-8, 8};             ///< shift of the probe along the array and across it
    range tilt{-5, 5}, rock{-5, 5}, turn{-10, 10}; ///< degrees
    range standoff{0, 1};                          ///< distance of the face from the surface
    std::optional<range> pressure{};               ///< how deep the face is pressed into the surface

    std::string probe{}; ///< linear, convex or phased; empty: that of the view
    std::uint32_t lines = 128, planes = 3, looks = 1;
    std::optional<range> frequency{}; ///< MHz
    std::optional<range> depth{}, focus{};
    range gain{-6, 6}; ///< dB
    range dynamic_range{85, 85};
    range noise{-135, -135};  ///< dB
    range media{0.8F, 1.25F}; ///< factor of attenuation and backscatter, each medium by itself

    float needle = 0.5F; ///< share of the samples that have one
    range gauge{18, 25}, needle_lateral{-5, 5};
    std::optional<range> needle_angle{}, needle_depth{};

    /// @throws usage_error  naming the option that is out of range
    void check() const {
        const auto within = [](const char* name, const range& of, float smallest, float largest) {
            if (!(of.from <= of.to))
                throw usage_error{std::string{name} + ": " + of.text() +
                                  " runs backwards; write the smaller number first"};
            if (!(of.from >= smallest) || !(of.to <= largest))
                throw usage_error{std::string{name} + ": " + of.text() + " is out of range; it must be from " +
                                  digits(smallest) + " to " + digits(largest)};
        };
        const auto counted = [](const char* name, std::uint32_t value, std::uint32_t smallest, std::uint32_t largest) {
            if (value < smallest || value > largest)
                throw usage_error{std::string{name} + ": " + std::to_string(value) +
                                  " is out of range; it must be from " + std::to_string(smallest) + " to " +
                                  std::to_string(largest)};
        };
        counted("--samples", samples, 1, 1'000'000'000);
        counted("--size", size, 16, 4096);
        counted("--part", part, 1, 8192); // they are in memory until they are written
        if (!channels.empty() && format == "png")
            throw usage_error{"--channels: PNG files have no place for them; use --format hdf5"};
        if (channels.empty() && transmits != description{}.transmits)
            throw usage_error{"--transmits: there are no channel data; choose an array, such as --channels l11_5v"};
        counted("--lines", lines, 8, 1024);
        counted("--looks", looks, 1, 31);
        within("--skin", {skin, skin}, 0, 20);
        within("--pennation", {pennation, pennation}, -90, 90);
        within("--scale", scale, 0.1F, 10);
        within("--bend", bend, 0, 20);
        within("--bend-length", {bend_length, bend_length}, 5, 10'000);
        within("--spread", spread, 0, 180);
        within("--along", along, -500, 500);
        within("--across", across, -500, 500);
        within("--tilt", tilt, -60, 60);
        within("--rock", rock, -60, 60);
        within("--turn", turn, -180, 180);
        within("--standoff", standoff, 0, 50);
        if (pressure) within("--pressure", *pressure, 0, 20);
        if (frequency) within("--frequency", *frequency, 0.5F, 50);
        if (depth) within("--depth", *depth, 5, 300);
        if (focus) within("--focus", *focus, 1, 300);
        within("--gain", gain, -60, 60);
        within("--dynamic-range", dynamic_range, 20, 120);
        within("--noise", noise, -300, 0);
        within("--media", media, 0.1F, 10);
        within("--needle", {needle, needle}, 0, 1);
        within("--gauge", gauge, 18, 25);
        if (needle_angle) within("--needle-angle", *needle_angle, 0, 85);
        if (needle_depth) within("--needle-depth", *needle_depth, 1, 200);
        within("--needle-lateral", needle_lateral, -100, 100);
        if (!(unit >= 1e-6F && unit <= 1e6F))
            throw usage_error{"--unit: must be from 1e-6 to 1e6: the length of 1 in the OBJ files, in mm"};
        if (!tissue::find(background)) throw usage_error{"--background: there is no tissue '" + background + "'"};
        if (planes != 1 && planes != 3 && planes != 5 && planes != 7)
            throw usage_error{"--planes: must be 1, 3, 5 or 7"};
    }
    /// Those of OBJ files. @throws usage_error  as `check`
    void check_directions() const {
        const vec3 towards{from[0], from[1], from[2]}, array{lateral[0], lateral[1], lateral[2]};
        for (const auto& [name, one] : {std::pair{"--from", towards}, std::pair{"--lateral", array}})
            if (!(length(one) >= 1e-6F && length(one) <= 1e6F))
                throw usage_error{std::string{name} + ": must be a direction, such as 0,-1,0"};
        if (length(cross(normalize(towards), normalize(array))) < 1e-3F)
            throw usage_error{
                "--lateral: must not be parallel to --from: the array lies across the direction of the probe"};
    }
};

} // namespace dataset
#endif
