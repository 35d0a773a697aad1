#ifndef INSONIFY_DATASET_LAYOUT_HPP
#define INSONIFY_DATASET_LAYOUT_HPP

#include "quaternion.hpp"
#include "render.hpp"
#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

/// What a dataset stores: arrays with a row for each sample. Pictures, labels and signals are maps of zea's layout; the rest,
/// in the group `insonify`, says how a sample came about.
namespace dataset {

/// Numbers of a sample: one, or an array.
struct fact {
    array_name name;
    std::vector<hsize_t> shape; ///< of a row; empty: one number
    std::function<void(const record&, std::vector<float>&)> append;

    /// After the last slash.
    std::string short_name() const { return name.path.substr(name.path.rfind('/') + 1); }
    std::vector<float> of(const record& one) const {
        std::vector<float> values;
        append(one, values);
        return values;
    }
};

/// An array of packed rows.
struct packed_array {
    array_name name;
    number_type numbers;
    std::vector<hsize_t> shape; ///< of a row
    bool split;                 ///< whether each index of the last axis is a chunk, or the whole row
    float missing;              ///< in `dataset.h5`, where a part is missing
    std::function<std::vector<packed_chunk>(const record&)> pack;
};

/// A sample as it is read again.
struct stored_sample {
    std::vector<std::uint8_t> image{}, label{}; ///< empty: it could not be read
    std::vector<float> numbers{};               ///< in the order of `layout::scalars`
};

/// A whole number of a sample.
struct whole_fact {
    array_name name;
    std::uint32_t (*of)(const record&);

    std::string short_name() const { return name.path.substr(name.path.rfind('/') + 1); }
};

class layout {
  public:
    layout(const description& d, const anatomies& all)
        : d_{d}, samples_{dataset::line_samples(d, all)}, recorded_{acquisition_of(d, all)} {
        add_numbers(all);
        add_records(all);
        add_maps(all);
        if (recorded_) add_channels();
        if (has_tissue()) add_tissue();
    }

    /// Numbers that floats cannot represent.
    static const std::vector<whole_fact>& whole_facts() {
        static const std::vector<whole_fact> all{
            {{"insonify/number", no_unit, "number of the sample in the dataset"},
             [](const record& one) { return one.numbers.number; }},
            {{"insonify/body_seed", no_unit,
              "of the parameters of the body: `simulate --anatomy ... --seed` makes it again; one for the samples that "
              "share a body"},
             [](const record& one) { return one.numbers.at.body_seed; }}};
        return all;
    }
    const std::vector<fact>& facts() const { return facts_; }
    const std::vector<packed_array>& arrays() const { return arrays_; }
    /// The groups of the maps.
    const std::vector<map_name>& maps() const { return maps_; }
    /// Coordinates that several maps share: a path, and what it is another name of.
    const std::vector<std::pair<std::string, std::string>>& links() const { return links_; }
    /// The channel data that there are, if there are.
    const std::optional<acquisition>& recorded() const { return recorded_; }
    /// Whether there are maps of tissue on the slice of the array of channel data.
    bool has_tissue() const { return recorded_ && !d_.no_truth; }
    /// The first facts are numbers that options give, and that vary.
    std::size_t option_count() const { return options_; }

    /// Those numbers, and the side of the body.
    std::vector<const fact*> scalars() const {
        std::vector<const fact*> found;
        for (std::size_t i = 0; i < facts_.size(); ++i)
            if (i < options_ || facts_[i].short_name() == "side") found.push_back(&facts_[i]);
        return found;
    }

    /// Compresses the arrays of a sample, and frees them.
    void pack(record& one) const {
        for (const packed_array& each : arrays_) one.packed.push_back(each.pack(one));
        one.image = {};
        one.label = {};
        one.incidence = one.transmitted = one.depth = {};
        one.iq = {};
        one.beams = {};
        one.channels = {};
        one.tissue = {};
    }

    static constexpr const char *image_path = "tracks/track_0/data/image/values", *label_path = "insonify/label";

  private:
    static constexpr float nan = std::numeric_limits<float>::quiet_NaN();

    template <class Of>
    void number(const char* name, const char* unit, const char* text, const Of& of) {
        facts_.push_back({{std::string{"insonify/"} + name, unit, text}, {}, [of](const record& one, auto& values) {
                              values.push_back(of(one.numbers));
                          }});
    }
    void add_numbers(const anatomies& all) {
        const char* none = no_unit.c_str();
        using s = const sample&;
        number("anatomy", none, "index into `anatomies`", [](s one) { return static_cast<float>(one.at.anatomy); });
        number("view", none, "index into `views`", [&all](s one) { return static_cast<float>(all.view_of(one.at)); });
        number("scale", none, "factor of all lengths of the anatomy", [](s one) { return one.scale; });
        number("bend", "mm", "rms of the displacement of the anatomy", [](s one) { return one.bend; });
        number("spread", "degrees", "angle between the place of the probe and that of the view, or `from`",
               [](s one) { return one.spread; });
        number("azimuth", "degrees", "of that place about the view's", [](s one) { return one.azimuth; });
        number("along", "mm", "shift of the probe along its array", [](s one) { return one.along; });
        number("across", "mm", "shift of the probe across its array", [](s one) { return one.across; });
        number("tilt", "degrees", "turn of the probe about its array", [](s one) { return one.tilt; });
        number("rock", "degrees", "turn of the probe within its slice", [](s one) { return one.rock; });
        number("turn", "degrees", "turn of the probe about its axis", [](s one) { return one.turn; });
        number("standoff", "mm", "distance of the face from the surface", [](s one) { return one.standoff; });
        number("pressure", "mm", "how deep the face is pressed into the surface at rest",
               [](s one) { return one.pressure; });
        number("frequency", "MHz", "carrier frequency, with which echoes are demodulated",
               [](s one) { return one.frequency; });
        number("image_depth", "mm", "depth of the image", [](s one) { return one.depth; });
        number("focus", "mm", "depth of the transmit focus", [](s one) { return one.focus; });
        number("gain", "dB", "added to every level", [](s one) { return one.gain; });
        number("dynamic_range", "dB", "from black to white", [](s one) { return one.dynamic_range; });
        number("noise", "dB", "electronic noise, relative to the echo of a perfect mirror",
               [](s one) { return one.noise; });
        number("needle", none, "1 where there is a needle", [](s one) { return one.needle ? 1.0F : 0.0F; });
        number("needle_side", none, "of the image, from which the needle comes: 0 left, 1 right",
               [](s one) { return one.needle_from == image_side::right ? 1.0F : 0.0F; });
        number("gauge", none, "of the needle", [](s one) { return static_cast<float>(one.gauge); });
        number("needle_angle", "degrees", "of the needle to the face", [](s one) { return one.needle_angle; });
        number("needle_depth", "mm", "depth of the needle's tip", [](s one) { return one.needle_depth; });
        number("needle_lateral", "mm", "place of the needle's tip along the array",
               [](s one) { return one.needle_lateral; });
        options_ = facts_.size();
    }

    template <class Append>
    void add(const std::string& path, const std::string& unit, const char* text, std::vector<hsize_t> shape,
             const Append& append) {
        facts_.push_back({{path, unit, text}, std::move(shape), append});
    }
    template <class Value>
    void add_face(const char* name, const std::string& unit, const char* text, Value face::*of) {
        add(std::string{"insonify/"} + name, unit, text, {},
            [of](const record& one, auto& values) { values.push_back(one.probe.*of); });
    }

    // What options and random numbers made of the anatomy and of the probe.
    void add_records(const anatomies& all) {
        add("metadata/probe_pose/translation", "m", "of the probe, to the anatomy", {3},
            [](const record& one, auto& values) {
                const vec3 t = one.at.translation;
                values.insert(values.end(), {t.x, t.y, t.z});
            });
        add("metadata/probe_pose/rotation", no_unit,
            "of the probe, to the anatomy: quaternion w, x, y, z; the probe has x lateral, y elevation, z depth", {4},
            [](const record& one, auto& values) {
                for (const float part : quaternion(one.at.rotation)) values.push_back(part);
            });
        add("insonify/pitch", "m", "width and height of a pixel", {2}, [](const record& one, auto& values) {
            values.insert(values.end(), {one.pitch.x, one.pitch.y});
        });
        add("insonify/on_surface", no_unit, "0 where the probe is beside the anatomy", {},
            [](const record& one, auto& values) { values.push_back(one.on_surface ? 1.0F : 0.0F); });
        const auto waves = [&](const char* name, const char* unit, const char* text, auto of) {
            add(std::string{"insonify/bend_"} + name, unit, text, {3, 3}, [of](const record& one, auto& values) {
                for (const vec3& v : one.bend.*of) values.insert(values.end(), {v.x, v.y, v.z});
            });
        };
        waves("direction", no_unit.c_str(),
              "of the three waves of bend(q) = amplitude times the sum of direction sin(wave q + phase): a point p of "
              "the "
              "anatomy's file, in metres, is at q + bend(q), q = scale p",
              &bending::direction);
        waves("wave", "rad/m", "wave vectors of the bend", &bending::wave);
        add("insonify/bend_phase", "rad", "phases of the bend", {3}, [](const record& one, auto& values) {
            values.insert(values.end(), std::begin(one.bend.phase), std::end(one.bend.phase));
        });
        add("insonify/bend_amplitude", "m", "of each wave of the bend", {},
            [](const record& one, auto& values) { values.push_back(one.bend.amplitude); });
        add("insonify/media", no_unit, "factors of attenuation and backscatter, for each label but the needle",
            {all.labels().needle(), 2}, [](const record& one, auto& values) {
                for (const vec2 factor : one.factors) values.insert(values.end(), {factor.x, factor.y});
            });
        if (!all.parameters().empty())
            add("insonify/parameters", "SI", "of the region, in the order of `parameter_names`; NaN where it has none",
                {all.parameters().size()}, [&all](const record& one, auto& values) {
                    for (const anatomy::parameter& each : all.parameters()) {
                        const auto found = one.parameters.find(each.name);
                        values.push_back(found == one.parameters.end() ? nan : found->second);
                    }
                });
        add("insonify/side", no_unit, "of the body: 0 left, 1 right; NaN where the anatomy has no side", {},
            [](const record& one, auto& values) {
                const auto found = one.parameters.find("side");
                values.push_back(found == one.parameters.end() ? nan : found->second);
            });
        add_contact();
        const auto option = [&](const char* name, const char* text, std::uint32_t value) {
            add(std::string{"insonify/"} + name, no_unit, text, {},
                [value](const record&, auto& values) { values.push_back(static_cast<float>(value)); });
        };
        option("lines", "scan lines of the probe", d_.lines);
        option("planes", "elevation planes", d_.planes);
        option("looks", "looks over 20 degrees that are averaged", d_.looks);
        add("insonify/probe", no_unit, "0 linear, 1 convex, 2 phased", {},
            [](const record& one, auto& values) { values.push_back(static_cast<float>(one.probe.shape)); });
        add_face("face_width", "m", "of the active aperture at most; along the arc where the face is curved",
                 &face::width);
        add_face("face_radius", "m", "0 where the face is flat", &face::radius);
        add_face("field_of_view", "rad", "of a sector; 0 where lines are parallel", &face::field_of_view);
        add_face("fnumber", no_unit, "depth over active aperture", &face::fnumber);
        add_face("elevation_height", "m", "height of the face", &face::elevation_height);
        add_face("elevation_focus", "m", "depth where the slice is thinnest", &face::elevation_focus);
        add_face("bandwidth", no_unit, "of echoes at -6 dB, as a fraction of the frequency", &face::bandwidth);
        if (d_.iq)
            add("insonify/sampling_frequency", "Hz", "of the samples along a line", {},
                [count = samples_](const record& one, auto& values) {
                    values.push_back(display_speed / 2 * static_cast<float>(count) / (one.numbers.depth * 1_mm));
                });
    }

    // How the probe deforms the body: `pressed_face` of the library.
    void add_contact() {
        const auto one_number = [&](const char* name, const char* unit, const char* text, float (*of)(const contact&)) {
            add(std::string{"insonify/contact_"} + name, unit, text, {},
                [of](const record& one, auto& values) { values.push_back(of(one.touch)); });
        };
        one_number("depth", "m", "largest depth of the face below the skin at rest; 0: not pressed",
                   [](const contact& c) { return c.depth; });
        one_number("force", "N", "of the face on the skin", [](const contact& c) { return c.force; });
        one_number("left", "m", "lateral edge of the face", [](const contact& c) { return c.deformation.left; });
        one_number("right", "m", "the other one", [](const contact& c) { return c.deformation.right; });
        one_number("elevation", "m", "height of the face", [](const contact& c) { return c.deformation.elevation; });
        one_number("decay", "m", "depth at which the displacement is 1/e",
                   [](const contact& c) { return c.deformation.decay; });
        one_number("recovery", "m", "distance beside the face at which it is",
                   [](const contact& c) { return c.deformation.recovery; });
        constexpr std::size_t beside = pressed_face::margin;
        add("insonify/contact_profile", "m",
            "depth of the face below the skin at rest, along z: rows from edge to edge in elevation, columns along the "
            "face",
            {pressed_face::rows - 2 * beside, pressed_face::columns - 2 * beside}, [](const record& one, auto& values) {
                const pressed_face::values& depth = one.touch.deformation.depth;
                for (std::size_t row = beside; row < pressed_face::rows - beside; ++row)
                    values.insert(values.end(), depth[row].begin() + beside, depth[row].end() - beside);
            });
    }

    void add_map(const std::string& name, const std::string& unit, const std::string& text, number_type numbers,
                 std::vector<hsize_t> shape, bool split, float missing,
                 std::function<std::vector<packed_chunk>(const record&)> pack, std::vector<std::string> labels = {}) {
        arrays_.push_back({{"tracks/track_0/data/" + name + "/values", unit, text},
                           numbers,
                           std::move(shape),
                           split,
                           missing,
                           std::move(pack)});
        maps_.push_back({{"tracks/track_0/data/" + name, unit, text}, std::move(labels)});
    }
    void share_coordinates(const std::string& map, const std::string& of) {
        const std::string data = "tracks/track_0/data/";
        links_.push_back({data + map + "/coordinates", data + of + "/coordinates"});
    }
    template <class Point>
    void add_coordinates(const std::string& map, std::vector<hsize_t> shape, const Point& point) {
        const hsize_t rows = shape[0], columns = shape[1];
        shape.push_back(3);
        arrays_.push_back({{"tracks/track_0/data/" + map + "/coordinates", "m",
                            "x lateral, y elevation, z depth, in the frame of the probe"},
                           number_type::real,
                           std::move(shape),
                           true,
                           nan,
                           [=](const record& one) {
                               return pack_points(rows, columns,
                                                  [&](hsize_t row, hsize_t column) { return point(one, row, column); });
                           }});
    }

    void add_maps(const anatomies& all) {
        const hsize_t size = d_.size, lines = d_.lines, samples = samples_, labels = all.labels().names.size();
        const auto one_chunk = [](const auto& values) { return std::vector<packed_chunk>{dataset::pack(values)}; };
        const auto pixel = [size](const record& one, hsize_t row, hsize_t column) -> vec3 {
            const float middle = 0.5F * static_cast<float>(size) - 0.5F;
            return {one.centre.x + one.pitch.x * (static_cast<float>(column) - middle), 0,
                    one.centre.y + one.pitch.y * (static_cast<float>(row) - middle)};
        };
        add_map("image", no_unit, "B-mode image: 0 black to 255 white; rows from the face down, columns along it",
                number_type::byte, {size, size}, false, 255, [=](const record& one) { return one_chunk(one.image); });
        add_coordinates("image", {size, size}, pixel);
        add_map(
            "segmentation", no_unit,
            "a mask for each of `labels`: where a pixel shows it; none outside the field of view", number_type::boolean,
            {size, size, 1, labels}, true, 0,
            [labels](const record& one) {
                std::vector<packed_chunk> masks;
                std::vector<std::uint8_t> mask(one.label.size());
                std::array<bool, 256> seen{};
                for (const std::uint8_t label : one.label) seen[label] = true;
                for (hsize_t label = 0; label < labels; ++label) {
                    masks.emplace_back(); // empty: all false
                    if (!seen[label]) continue;
                    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = one.label[i] == label ? 1 : 0;
                    masks.back() = dataset::pack(mask);
                }
                return masks;
            },
            all.labels().names);
        add_coordinates("segmentation", {size, size, 1}, pixel);
        arrays_.push_back(
            {{label_path, no_unit, "the masks as one image: index of the label, 255 outside the field of view"},
             number_type::byte,
             {size, size},
             false,
             255,
             [=](const record& one) { return one_chunk(one.label); }});
        const auto truth = [&](const char* name, const std::string& unit, const char* text,
                               std::vector<float> record::*of) {
            add_map(name, unit, text, number_type::real, {size, size}, false, nan,
                    [=](const record& one) { return one_chunk(one.*of); });
            share_coordinates(name, "image");
        };
        if (!d_.no_truth) {
            truth("incidence", "rad", "angle between the beam and the normal of the surface in a pixel; 0: none",
                  &record::incidence);
            truth("transmitted", no_unit, "amplitude that arrives in a pixel and returns, 0 to 1",
                  &record::transmitted);
            truth("depth", "m", "of what a pixel shows, along its line", &record::depth);
        }
        if (!d_.iq) return;
        const auto place = [samples](const record& one, hsize_t row, hsize_t column) {
            const float depth = one.iq.depth * (static_cast<float>(row) + 0.5F) / static_cast<float>(samples);
            return one.beams[column].at(depth);
        };
        add_map("envelope_data", no_unit, "amplitude along the lines; 1 is the echo of a perfect mirror",
                number_type::real, {samples, lines}, false, nan, [=](const record& one) {
                    std::vector<float> values;
                    for_each_echo(one.iq, [&](vec2 echo) { values.push_back(length(echo)); });
                    return one_chunk(values);
                });
        add_coordinates("envelope_data", {samples, lines}, place);
        add_map("beamformed_data", no_unit,
                "complex echoes along the lines of the unsteered look, demodulated with the carrier", number_type::real,
                {samples, lines, 2}, false, nan,
                [=](const record& one) {
                    std::vector<float> values;
                    for_each_echo(one.iq, [&](vec2 echo) { values.insert(values.end(), {echo.x, echo.y}); });
                    return one_chunk(values);
                },
                {"I", "Q"});
        share_coordinates("beamformed_data", "envelope_data");
    }
    void add_channels() {
        const channel_data& like = recorded_->like();
        arrays_.push_back({{"tracks/track_0/data/raw_data", no_unit,
                            "RF of each element; 1 is the echo of a perfect mirror. The envelope of an echo peaks at "
                            "its travel time"},
                           number_type::real,
                           {like.transmits, like.samples, like.elements, 1},
                           false,
                           nan,
                           [](const record& one) { return std::vector<packed_chunk>{dataset::pack(one.channels)}; }});
    }
    // On one grid, that of the slice of the array.
    void add_tissue() {
        const map_grid grid = recorded_->grid();
        const std::string first = channels::truth_maps().front().name;
        for (const channels::truth_map& map : channels::truth_maps()) {
            add_map(
                map.name, map.unit, map.description, number_type::real, map.shape(grid), !map.labels.empty(), nan,
                [&map, frequency = recorded_->like().frequency](const record& one) {
                    return map.pack(one.tissue, frequency);
                },
                map.labels);
            if (map.name == first)
                add_coordinates(map.name, {grid.size.y, grid.size.x},
                                [grid](const record&, hsize_t row, hsize_t column) {
                                    return grid.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row));
                                });
            else
                share_coordinates(map.name, first);
        }
    }
    // Depth by depth.
    template <class Visit>
    static void for_each_echo(const iq_lines& echoes, const Visit& visit) {
        for (std::uint32_t k = 0; k < echoes.samples; ++k)
            for (std::uint32_t line = 0; line < echoes.count; ++line) visit(echoes(line, k));
    }

    const description& d_;
    std::uint32_t samples_; // of a line of echoes
    std::optional<acquisition> recorded_;
    std::vector<fact> facts_{};
    std::vector<packed_array> arrays_{};
    std::vector<map_name> maps_{};
    std::vector<std::pair<std::string, std::string>> links_{};
    std::size_t options_ = 0;
};

} // namespace dataset
#endif
