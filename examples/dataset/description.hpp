#ifndef INSONIFY_DATASET_DESCRIPTION_HPP
#define INSONIFY_DATASET_DESCRIPTION_HPP

#include <insonify/insonify.hpp>
#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <sstream>
#include <string>
#include <vector>

namespace dataset {

using namespace insonify;

/// From what to what a number varies, uniformly: `3..5`, or `4` for one value.
struct range {
    float from = 0;
    float to = 0;

    friend std::istream& operator>>(std::istream& text, range& read) {
        std::string word;
        text >> word;
        const std::size_t dots = word.find("..");
        const auto number = [&](const std::string& part) {
            std::size_t used = 0;
            float value = 0;
            try {
                value = std::stof(part, &used);
            } catch (const std::exception&) {
                used = 0;
            }
            if (used == 0 || used != part.size() || !is_finite(value)) text.setstate(std::ios::failbit);
            return value;
        };
        read.from = number(word.substr(0, dots));
        read.to = dots == std::string::npos ? read.from : number(word.substr(dots + 2));
        return text;
    }
    static bool readable(const std::string& word) {
        std::istringstream text{word};
        range read;
        return word.find_first_of(" \t") == std::string::npos && static_cast<bool>(text >> read);
    }
    /// How to write what cannot be read; empty where it can.
    static std::string complaint(const std::string& word) {
        if (readable(word)) return "";
        const std::size_t mark = word.find_first_of("-:,", 1);
        const std::string meant = mark == std::string::npos ? "" : word.substr(0, mark) + ".." + word.substr(mark + 1);
        return "'" + word + "' is neither a number nor a range; a range is written " +
               (readable(meant) ? meant : "with two dots, such as 5..9");
    }
};

/// What the samples of a dataset have in common, and what varies from one to the next. Lengths are millimetres, as on the
/// command line.
struct description {
    std::uint64_t seed = 1;
    std::uint32_t samples = 100;
    std::uint32_t size = 256; ///< columns and rows
    std::string output = "dataset";
    std::string format = "hdf5"; ///< hdf5 or png
    std::uint32_t part = 32;     ///< samples in each file
    bool iq = false;             ///< store IQ and envelope, too
    bool plan = false;

    std::vector<std::string> anatomy{}; ///< OBJ files; none: the phantom of a nerve block
    float unit = 1;                     ///< of the OBJ files
    std::string background = "fat";
    range scale{1, 1};
    range bend{0, 0}; ///< rms of a smooth random displacement
    float bend_length = 60;

    std::string around{}; ///< name of the object that the probe is placed on; empty: the first that it meets
    std::array<float, 3> from{0, 0, -1};           ///< direction from which the probe looks
    std::array<float, 3> lateral{1, 0, 0};         ///< of the array
    range spread{0, 30};                           ///< angle between the probe's place and `from`, degrees
    range along{-8, 8}, across{-8, 8};             ///< shift of the probe along the array and across it
    range tilt{-5, 5}, rock{-5, 5}, turn{-10, 10}; ///< degrees
    range standoff{0, 1};                          ///< distance of the face from the surface
    range pressure{0, 0};                          ///< how deep the face is pressed into the surface

    std::string probe = "linear"; ///< linear, convex or phased
    std::uint32_t lines = 128, planes = 3, looks = 1;
    range frequency{7.5F, 7.5F}; ///< MHz
    range depth{40, 40};
    range focus{15, 25};
    range gain{0, 0}; ///< dB
    range dynamic_range{85, 85};
    range noise{-135, -135}; ///< dB
    range media{1, 1};       ///< factor of attenuation and backscatter, each medium by itself

    float needle = 0; ///< share of the samples that have one
    range gauge{18, 25}, needle_angle{5, 45}, needle_depth{10, 30};

    /// @throws usage_error  naming the option that is out of range
    void check() const {
        const auto ordered = [](const char* name, const range& of, float least, float most) {
            if (!(of.from <= of.to))
                throw usage_error{std::string{name} + ": " + detail::number_text(of.from) + ".." +
                                  detail::number_text(of.to) + " runs backwards; write the smaller number first"};
            if (!(of.from >= least) || !(of.to <= most))
                throw usage_error{std::string{name} + ": must be from " + detail::number_text(least) + " to " +
                                  detail::number_text(most)};
        };
        if (samples < 1 || part < 1) throw usage_error{"--samples and --part: must be at least 1"};
        if (size < 16 || size > 4096) throw usage_error{"--size: must be from 16 to 4096 pixels"};
        ordered("--scale", scale, 0.1F, 10);
        ordered("--bend", bend, 0, 20);
        ordered("--spread", spread, 0, 180);
        ordered("--along", along, -500, 500);
        ordered("--across", across, -500, 500);
        ordered("--tilt", tilt, -60, 60);
        ordered("--rock", rock, -60, 60);
        ordered("--turn", turn, -180, 180);
        ordered("--standoff", standoff, 0, 50);
        ordered("--pressure", pressure, 0, 20);
        ordered("--frequency", frequency, 0.5F, 50);
        ordered("--depth", depth, 5, 300);
        ordered("--focus", focus, 1, 300);
        ordered("--gain", gain, -60, 60);
        ordered("--dynamic-range", dynamic_range, 20, 120);
        ordered("--noise", noise, -300, 0);
        ordered("--media", media, 0.1F, 10);
        ordered("--gauge", gauge, 18, 25);
        ordered("--needle-angle", needle_angle, 0, 85);
        ordered("--needle-depth", needle_depth, 1, 200);
        if (!(bend_length >= 5)) throw usage_error{"--bend-length: must be at least 5 mm"};
        if (!(needle >= 0 && needle <= 1)) throw usage_error{"--needle: must be from 0 to 1"};
        if (!(unit > 0)) throw usage_error{"--unit: must be above 0: the length of 1 in the OBJ files, in mm"};
        if (!tissue::find(background)) throw usage_error{"--background: there is no tissue '" + background + "'"};
        if (planes != 1 && planes != 3 && planes != 5 && planes != 7)
            throw usage_error{"--planes: must be 1, 3, 5 or 7"};
        for (const std::string& file : anatomy)
            if (!std::filesystem::is_regular_file(file))
                throw io_error{"--anatomy: there is no file '" + file + "'; paths are relative to the current folder"};
    }
};

/// The options of the command line and of the file of `--config`, whose lines are `option = value`.
inline void add_options(CLI::App& app, description& d) {
    const char* group = "";
    app.footer("A..B is a range: each sample has a value of its own in it. One number is for all samples.");
    app.set_config("--config", "", "A file of lines such as: frequency = 5..9", false);
    const auto option = [&](const char* name, auto& value, const char* help) {
        return app.add_option(name, value, help)->capture_default_str()->group(group);
    };
    const auto flag = [&](const char* name, bool& value, const char* help) {
        app.add_flag(name, value, help)->group(group);
    };
    const auto varies = [&](const char* name, range& value, const char* help) {
        app.add_option(name, value, help)
            ->type_name("A..B")
            ->check(CLI::Validator{range::complaint, ""})
            ->default_str(detail::number_text(value.from) +
                          (value.from == value.to ? "" : ".." + detail::number_text(value.to)))
            ->group(group);
    };
    const auto direction = [&](const char* name, std::array<float, 3>& value, const char* help) {
        option(name, value, help)->delimiter(',')->type_name("X,Y,Z");
    };
    group = "Dataset";
    option("--samples", d.samples, "Number of samples");
    option("--seed", d.seed, "Another number gives other samples");
    option("--size", d.size, "Columns and rows of the images");
    option("--output", d.output, "Folder to write to; a run that was stopped goes on where it was");
    option("--format", d.format, "HDF5 files, or PNG files beside JSON files")->check(CLI::IsMember({"hdf5", "png"}));
    option("--part", d.part, "Samples in each HDF5 file; it is written as a whole");
    flag("--iq", d.iq, "Store envelope and IQ along the lines, too");
    flag("--plan", d.plan, "Print what varies, how long it takes and how large it will be, and stop");

    group = "Anatomy";
    option("--anatomy", d.anatomy, "OBJ files whose materials are tissues; without: the phantom of a nerve block");
    option("--unit", d.unit, "Length of 1 in the OBJ files, such as 1mm; without a unit, mm")
        ->transform(CLI::AsNumberWithUnit(std::map<std::string, float>{{"mm", 1}, {"cm", 10}, {"m", 1000}}));
    option("--background", d.background,
           "Tissue outside the objects of the OBJ files; its layers are parallel to the skin under the probe");
    varies("--scale", d.scale, "Factor of all lengths");
    varies("--bend", d.bend, "Rms of a smooth random displacement, mm");
    option("--bend-length", d.bend_length, "Its wavelength, mm");
    varies("--media", d.media, "Factor of attenuation and of backscatter, for each tissue by itself");

    group = "Place of the probe";
    option("--around", d.around,
           "Name of the object whose surface the probe is placed on; without: the first that it meets");
    direction("--from", d.from, "Direction from the middle of that object to the probe");
    direction("--lateral", d.lateral, "Direction of the array");
    varies("--spread", d.spread, "Angle between the direction of the probe and --from, degrees");
    varies("--along", d.along, "Shift of the probe along its array, mm");
    varies("--across", d.across, "Shift of the probe across it, mm");
    varies("--tilt", d.tilt, "Turn of the probe about its array, degrees");
    varies("--rock", d.rock, "Turn within the slice, degrees");
    varies("--turn", d.turn, "Turn about its axis, degrees");
    varies("--standoff", d.standoff, "Gel between face and surface, mm; none where the probe is pressed");
    varies("--pressure", d.pressure, "How deep the probe is pressed into the surface, mm; the tissue below yields");

    group = "Probe and image";
    option("--probe", d.probe, "Array")->check(CLI::IsMember({"linear", "convex", "phased"}));
    option("--lines", d.lines, "Scan lines");
    option("--planes", d.planes, "Elevation planes, which sample the slice thickness: 1, 3, 5 or 7");
    option("--looks", d.looks, "Looks over 10 degrees that are averaged");
    varies("--frequency", d.frequency, "Carrier frequency, MHz");
    varies("--depth", d.depth, "Of the image, mm");
    varies("--focus", d.focus, "Depth of the transmit focus, mm");
    varies("--gain", d.gain, "Added to every level, dB");
    varies("--dynamic-range", d.dynamic_range, "From black to white, dB");
    varies("--noise", d.noise, "Electronic noise, dB relative to the echo of a perfect mirror");

    group = "Needle";
    option("--needle", d.needle, "Fraction of the samples that have a needle, 0 to 1");
    varies("--gauge", d.gauge, "Its size, 18 (thick) to 25 (thin)");
    varies("--needle-angle", d.needle_angle, "Angle to the face of the probe, degrees");
    varies("--needle-depth", d.needle_depth, "Depth of its tip, mm");
}

} // namespace dataset
#endif
