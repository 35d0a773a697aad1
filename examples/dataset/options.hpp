#ifndef INSONIFY_DATASET_OPTIONS_HPP
#define INSONIFY_DATASET_OPTIONS_HPP

#include "../anatomy/regions.hpp"
#include "../channels/arrays.hpp"
#include "description.hpp"
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <istream>
#include <memory>
#include <string>
#include <vector>

/// The options of the command line and of the file of `--config`, whose lines are `option = value`.
namespace dataset {

/// An option whose value is written to `description.ini`.
struct described_option {
    std::string name;
    std::function<std::string()> value{}; ///< as the file has it; empty: it is left out
    bool alters_samples = true;           ///< whether two datasets that differ in it have different samples
};

/// Words in quotation marks where they need them.
inline std::string in_quotes(const std::string& text) {
    if (!text.empty() && text.find_first_of(" \t\"'#;=,") == std::string::npos) return text;
    const char mark = text.find('"') == std::string::npos ? '"' : '\'';
    return mark + text + mark;
}

/// Reads `option = value`, where words with spaces are in quotation marks and a comment starts with # or ;.
class configuration : public CLI::Config {
  public:
    explicit configuration(const CLI::App& app) : app_{app} {}

    std::string to_config(const CLI::App*, bool, bool, std::string) const override { return ""; }

    /// @throws usage_error  with the number of the line, for an unknown or repeated option
    std::vector<CLI::ConfigItem> from_config(std::istream& text) const override {
        std::vector<CLI::ConfigItem> made;
        std::string line;
        for (std::uint32_t number = 1; std::getline(text, line); ++number) {
            const auto fail = [&, number](const std::string& what) {
                throw usage_error{"--config: line " + std::to_string(number) + ": " + what};
            };
            constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
            if (number == 1 && line.starts_with(byte_order_mark)) line.erase(0, byte_order_mark.size());
            const std::string content = CLI::detail::trim_copy(line);
            if (std::any_of(content.begin(), content.end(), [](unsigned char c) { return c < ' ' && c != '\t'; }))
                fail("it has control characters; the file is no text, or a damaged one");
            if (content.empty() || content[0] == '#' || content[0] == ';') continue;
            const std::size_t sign = content.find('=');
            if (sign == std::string::npos) fail("'" + shortened(content) + "' is not of the form option = value");
            CLI::ConfigItem item;
            item.name = CLI::detail::trim_copy(content.substr(0, sign));
            check_name(item.name, fail);
            if (std::any_of(made.begin(), made.end(), [&](const auto& other) { return other.name == item.name; }))
                fail("'" + item.name + "' is given twice");
            item.inputs = words(content.substr(sign + 1), fail);
            if (item.inputs.empty()) fail("'" + item.name + "' has no value");
            made.push_back(std::move(item));
        }
        return made;
    }

  private:
    static std::string shortened(const std::string& text) {
        return as_utf8(text.size() > 40 ? text.substr(0, 40) + "..." : text);
    }
    template <class Fail>
    void check_name(const std::string& name, const Fail& fail) const {
        const CLI::Option* known = app_.get_option_no_throw("--" + name);
        if (known != nullptr && known->get_configurable()) return;
        if (known != nullptr) fail("'" + name + "' is an option of the command line alone");
        for (const CLI::Option* other : app_.get_options())
            for (const std::string& meant : other->get_lnames())
                if (name.size() < 30 && other->get_configurable() && edits_between(name, meant) <= 2)
                    fail("there is no option '" + name + "'; did you mean " + meant + "?");
        fail("there is no option '" + shortened(name) + "'; dataset --help lists all");
    }
    /// Letters to be inserted, removed or replaced to make one word of another, by recursion: words are short.
    static std::size_t edits_between(std::string_view one, std::string_view other, std::size_t allowed = 3) {
        if (one.empty() || other.empty()) return std::max(one.size(), other.size());
        if (one[0] == other[0]) return edits_between(one.substr(1), other.substr(1), allowed);
        if (allowed == 0) return 1;
        return 1 + std::min({edits_between(one.substr(1), other, allowed - 1),
                             edits_between(one, other.substr(1), allowed - 1),
                             edits_between(one.substr(1), other.substr(1), allowed - 1)});
    }
    template <class Fail>
    static std::vector<std::string> words(const std::string& text, const Fail& fail) {
        std::vector<std::string> all;
        for (std::size_t i = 0; i < text.size();) {
            if (std::string{" \t\r"}.find(text[i]) != std::string::npos) {
                ++i;
            } else if (text[i] == '#' || text[i] == ';') {
                break;
            } else if (text[i] == '"' || text[i] == '\'') {
                const std::size_t end = text.find(text[i], i + 1);
                if (end == std::string::npos) fail("a quotation mark is not closed");
                all.push_back(text.substr(i + 1, end - i - 1));
                i = end + 1;
            } else {
                const std::size_t end = std::min(text.find_first_of(" \t\r#;", i), text.size());
                all.push_back(text.substr(i, end - i));
                i = end;
            }
        }
        return all;
    }

    const CLI::App& app_;
};

/// What is wrong with a word that is no whole number of 64 bits; empty: nothing. CLI11 takes -1 for the largest one.
inline std::string whole_number(const std::string& word) {
    const std::string largest = "18446744073709551615";
    const bool digits_only = !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
    const bool fits = word.size() < largest.size() || (word.size() == largest.size() && word <= largest);
    return digits_only && fits ? "" : "'" + word + "' is not a whole number from 0 to " + largest;
}

/// Adds all options.
/// @return those of `description.ini`
inline std::vector<described_option> add_options(CLI::App& app, description& d) {
    std::vector<described_option> described;
    const char* group = "";
    app.footer("A..B is a range: each sample has a value of its own in it. One number is for all samples.");
    app.config_formatter(std::make_shared<configuration>(app));
    app.set_config("--config", "", "A file of lines such as: frequency = 5..9", false)->configurable(false);
    app.get_help_ptr()->configurable(false);
    const auto option = [&](const std::string& name, auto& value, const char* help) {
        described.push_back({name, [&value] {
                                 using type = std::decay_t<decltype(value)>;
                                 if constexpr (std::is_same_v<type, std::string>)
                                     return value.empty() ? std::string{} : in_quotes(value);
                                 else
                                     return digits(value);
                             }});
        CLI::Option* made = app.add_option("--" + name, value, help)->capture_default_str()->group(group);
        if constexpr (std::is_unsigned_v<std::decay_t<decltype(value)>>) made->check(CLI::Validator{whole_number, ""});
        return made;
    };
    const auto flag = [&](const std::string& name, bool& value, const char* help) {
        described.push_back({name, [&value] { return std::string{value ? "true" : "false"}; }});
        app.add_flag("--" + name, value, help)->group(group);
    };
    const auto command = [&](const std::string& name, bool& value, const char* help) {
        app.add_flag("--" + name, value, help)->configurable(false)->group(group);
    };
    const auto varies = [&](const std::string& name, range& value, const char* help) {
        described.push_back({name, [&value] { return value.text(); }});
        app.add_option("--" + name, value, help)
            ->type_name("A..B")
            ->check(CLI::Validator{range::complaint, ""})
            ->default_str(value.text())
            ->group(group);
    };
    const auto varies_or = [&](const std::string& name, std::optional<range>& value, const char* help) {
        described.push_back({name, [&value] { return value ? value->text() : std::string{}; }});
        app.add_option("--" + name, value, help)
            ->type_name("A..B")
            ->check(CLI::Validator{range::complaint, ""})
            ->group(group);
    };
    const auto words = [&](const std::string& name, std::vector<std::string>& value, const char* type,
                           const char* help) {
        described.push_back({name, [&value] {
                                 std::string all;
                                 for (const std::string& one : value) all += (all.empty() ? "" : " ") + in_quotes(one);
                                 return all;
                             }});
        app.add_option("--" + name, value, help)->type_name(type)->group(group);
    };
    const auto direction = [&](const std::string& name, std::array<float, 3>& value, const char* help) {
        described.push_back(
            {name, [&value] { return digits(value[0]) + "," + digits(value[1]) + "," + digits(value[2]); }});
        app.add_option("--" + name, value, help)
            ->capture_default_str()
            ->delimiter(',')
            ->type_name("X,Y,Z")
            ->group(group);
    };
    group = "Dataset";
    option("samples", d.samples, "Number of samples; a larger one later adds samples to those that there are");
    described.back().alters_samples = false;
    option("seed", d.seed, "Another number gives other samples");
    option("size", d.size, "Columns and rows of the images, 16 to 4096");
    app.add_option("--output", d.output, "Folder to write to; a run that was stopped goes on where it was")
        ->capture_default_str()
        ->group(group);
    option("format", d.format, "HDF5 files, or PNG files beside JSON files")->check(CLI::IsMember({"hdf5", "png"}));
    option("part", d.part, "Samples in each part, 1 to 8192; a part is in memory until it is written as a whole");
    flag("iq", d.iq, "Store envelope and IQ along the lines, too");
    option("channels", d.channels,
           "Store RF of each element, too, of an array where the probe is: l11_5v, l12_3v (linear), c5_2v (convex), "
           "p4_2v (phased); without: none")
        ->check(CLI::IsMember(channels::array_names()));
    option("transmits", d.transmits,
           "Of --channels: plane:COUNT:ANGLE, diverging:COUNT:ANGLE:LENGTH, focused:COUNT:DEPTH, "
           "focused:COUNT:DEPTH:ANGLE or fsa");
    flag("no-truth", d.no_truth,
         "Store no incidence, transmission and depth of each pixel, only its label, and no maps of tissue");
    command("plan", d.plan, "Print what varies, how long it takes and how large it will be, and write nothing");
    command("verify", d.verify,
            "Read all parts in the folder, name those that are missing or damaged, and write nothing");

    group = "Anatomy";
    app.add_option("--anatomy", d.anatomy,
                   "Regions of the body, and OBJ files whose materials are tissues; ./neck is a file, neck the region; "
                   "without: all regions")
        ->type_name("NAME")
        ->group(group);
    described.push_back({"anatomy",
                         [&d] {
                             std::string all;
                             for (const std::string& one : d.anatomy)
                                 all += (all.empty() ? "" : " ") +
                                        in_quotes(anatomy::region_named(one) != nullptr
                                                      ? one
                                                      : std::filesystem::absolute(one).lexically_normal().string());
                             return all;
                         },
                         false}); // the content of files does, and the names of regions
    words("view", d.views, "NAME", "Views of the regions; without: all");
    words("parameter", d.parameters, "NAME=A..B",
          "Range of a parameter of the regions, such as fat=3..5 or fat=6mm; lengths in mm and angles in degrees, "
          "unless a "
          "unit follows; without: all of its range");
    varies("scale", d.scale, "Factor of all lengths");
    varies("bend", d.bend, "Rms of a smooth random displacement, mm");
    option("bend-length", d.bend_length, "Its wavelength, mm");
    varies("media", d.media, "Factor of attenuation and of backscatter, for each label by itself");

    group = "OBJ files";
    option("unit", d.unit, "Length of 1 in the files, such as 1mm; without a unit, mm")
        ->transform(command_line::length());
    option("background", d.background,
           "Tissue outside the objects; its layers are parallel to the skin under the probe");
    option("skin", d.skin,
           "Thickness of skin below the surface of an object that encloses all others, up to 20mm; a structure of its "
           "own; 0: none")
        ->transform(command_line::length());
    flag("repair", d.repair, "Close and orient meshes that enclose nothing, and say what was done");
    option("pennation", d.pennation,
           "Angle between the fibres of muscles and their long axis, degrees, of those without `fibres`; negative "
           "turns the other way")
        ->transform(command_line::angle());
    option("around", d.around,
           "Name of the object whose surface the probe is placed on; without: the first that it meets");
    direction("from", d.from, "Direction from the middle of that object to the probe");
    direction("lateral", d.lateral, "Direction of the array");

    group = "Place of the probe, from that of the view";
    varies("spread", d.spread, "Angle about the middle of the image, or of the object, degrees");
    varies("along", d.along, "Shift of the probe along its array, mm");
    varies("across", d.across, "Shift of the probe across it, mm");
    varies("tilt", d.tilt, "Turn of the probe about its array, degrees");
    varies("rock", d.rock, "Turn within the slice, degrees");
    varies("turn", d.turn, "Turn about its axis, degrees");
    varies("standoff", d.standoff, "Gel between face and surface, mm; none where the probe is pressed");
    varies_or(
        "pressure", d.pressure,
        "How deep the probe is pressed into the surface, mm; the tissue below yields, but for bone and cartilage; "
        "without: 0.75 to 1.25 times that of the view, files 0");

    group = "Probe and image";
    option("probe", d.probe, "Array; without: that of the view, files linear")
        ->check(CLI::IsMember({"linear", "convex", "phased"}));
    option("lines", d.lines, "Scan lines, 8 to 1024");
    option("planes", d.planes, "Elevation planes, which sample the slice thickness: 1, 3, 5 or 7");
    option("looks", d.looks, "Looks over 20 degrees that are averaged, 1 to 31");
    varies_or("frequency", d.frequency,
              "Carrier frequency, MHz; without: 0.9 to 1.1 times that of the view, files 7.5");
    varies_or("depth", d.depth, "Of the image, mm; without: 0.85 to 1.15 times that of the view, files 40");
    varies_or("focus", d.focus,
              "Depth of the transmit focus, mm; without: 0.75 to 1.25 times that of the view, files 20");
    varies("gain", d.gain, "Added to every level, dB");
    varies("dynamic-range", d.dynamic_range, "From black to white, dB");
    varies("noise", d.noise, "Electronic noise, dB relative to the echo of a perfect mirror");

    group = "Needle, from the left and from the right in turn";
    option("needle", d.needle, "Fraction of the samples that have a needle, 0 to 1");
    varies("gauge", d.gauge, "Its size, 18 (thick) to 25 (thin)");
    varies_or("needle-angle", d.needle_angle,
              "Angle to the face of the probe, degrees; without: within 10 of the path of the view, or so that it "
              "pierces the "
              "skin 2 to 30 mm beside the face");
    varies_or(
        "needle-depth", d.needle_depth,
        "Depth of its tip, mm; without: within 5 of the target of the view, or 0.25 to 0.75 of the depth of the image");
    varies("needle-lateral", d.needle_lateral,
           "Distance of its tip along the array from the target of the view, or from the middle, mm");
    return described;
}

} // namespace dataset
#endif
