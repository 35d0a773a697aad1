#ifndef INSONIFY_DATASET_FILE_SUBJECT_HPP
#define INSONIFY_DATASET_FILE_SUBJECT_HPP

#include "../anatomy_check.hpp"
#include "subject.hpp"
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dataset {

/// An OBJ file: one body, with one view, that of `from`.
class file_subject : public subject {
  public:
    /// @throws io_error, usage_error, geometry_error  for a file that cannot be used, or without the object of `around`
    file_subject(const description& d, const std::string& file)
        : name_{as_utf8(std::filesystem::path{file}.filename().string())} {
        d.check_directions();
        const float unit = d.unit * 1_mm;
        std::vector<std::string> notes;
        scene& body = body_.anatomy;
        body = load_obj_scene(file, reading_of(unit, *tissue::find(d.background), d.repair, d.pennation), notes);
        check_anatomy(body, file, unit, "--unit 1", d.repair ? "" : "--repair");
        note_ = describe_anatomy(file, body, unit, notes);

        const aabb box = box_around(d, file);
        place_.on = d.around;
        if (d.skin > 0) cover(d.skin * 1_mm);
        structures_.emplace_back("background", body.background());
        for (const object& one : body.objects()) structures_.emplace_back(structure(one), one.inside);

        const vec3 from = normalize(vec3{d.from[0], d.from[1], d.from[2]});
        place_.straight = look_at(box.centre() + from, box.centre(), {d.lateral[0], d.lateral[1], d.lateral[2]});
        place_.centre = box.centre();
        place_.away = length(box.size());
        place_.faces_skin = true;
        anatomy::view seen{.at = place_.straight, .pressed = 0};
        constexpr float focus = 20_mm;
        const auto use = [&](auto array) {
            array.frequency = 7.5_MHz;
            array.focus = focus;
            seen.settings = presets::settings_for(array);
            seen.probe = array;
        };
        if (d.probe == "convex")
            use(convex_array{});
        else if (d.probe == "phased")
            use(phased_array{});
        else
            use(linear_array{});
        seen.settings.depth = 40_mm;
        body_.views = {seen};
    }

    std::string name() const override { return name_; }
    std::string note() const override { return note_; }
    const std::vector<std::pair<std::string, medium>>& structures() const override { return structures_; }
    /// An object without a name gets one, and one that is named like the background or the needle another one.
    std::string structure(const object& one) const override {
        std::string name = as_utf8(name_of(one));
        while (name == "background" || name == "needle") name += " (object)";
        return name;
    }
    const std::vector<anatomy::parameter>& parameters() const override { return none_; }
    anatomy::values drawn(std::uint64_t) const override { return {}; }
    anatomy::body make(const anatomy::values&) const override { return body_; }
    const std::vector<anatomy::view>& views() const override { return body_.views; }
    float deepest(std::size_t view) const override { return body_.views[view].settings.depth; }
    standpoint standpoint_of(const anatomy::view&) const override { return place_; }

  private:
    static std::string name_of(const object& one) {
        return one.name.empty() ? "object " + std::to_string(static_cast<std::uint32_t>(one.id)) : one.name;
    }
    // The surface of an object that encloses all others becomes that of its skin, and so does the probe's place on it.
    void cover(float thickness) {
        scene& body = body_.anatomy;
        const std::optional<object_id> named = body.find(place_.on);
        if (add_skin(body, {.thickness = thickness}) == skin_place::none || body.find(place_.on) == named) return;
        for (const object& one : body.objects())
            if (one.inside == tissue::skin) place_.on = one.name;
    }
    aabb box_around(const description& d, const std::string& file) const {
        aabb whole, around;
        std::string known;
        for (const object& one : body_.anatomy.objects()) {
            aabb box;
            for (const vec3 p : one.surface.positions) box = merged(box, one.at.point(p));
            whole = merged(whole, box);
            if (one.name == d.around) around = box;
            known += (known.empty() ? "" : ", ") + name_of(one);
        }
        if (d.around.empty()) return whole;
        if (!body_.anatomy.find(d.around))
            throw usage_error{"--around: " + file + " has no object '" + d.around + "'; it has " + known};
        return around;
    }

    std::string name_, note_;
    anatomy::body body_{};
    std::vector<std::pair<std::string, medium>> structures_{};
    std::vector<anatomy::parameter> none_{};
    standpoint place_{};
};

} // namespace dataset
#endif
