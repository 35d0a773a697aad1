#ifndef INSONIFY_DATASET_REGION_SUBJECT_HPP
#define INSONIFY_DATASET_REGION_SUBJECT_HPP

#include "../anatomy/regions.hpp"
#include "../region_values.hpp"
#include "subject.hpp"
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace dataset {

/// The phantom of a nerve block for a probe that moves. What is further than 20 mm from the middle, across or along the limb,
/// is stretched, and the lower side is 14 mm deeper: a linear array at the ends of the default ranges, or pressed in by 4 mm,
/// shows neither the sides nor what is below. The layers, which reach there, get more vertices for `bend` and `pressure`.
inline scene widened(const scene& phantom) {
    scene body{phantom.background()};
    const auto stretched = [](float x) {
        const float beyond = std::fabs(x) - 20_mm;
        return beyond > 0 ? std::copysign(20_mm + 3.5F * beyond, x) : x;
    };
    for (const object& one : phantom.objects()) {
        mesh surface = one.surface;
        if (std::any_of(surface.positions.begin(), surface.positions.end(), [](vec3 p) { return p.x > 20_mm; }))
            surface = subdivide(surface);
        for (vec3& p : surface.positions) p = {stretched(p.x), stretched(p.y), p.z > 46_mm ? p.z + 14_mm : p.z};
        body.add(std::move(surface), one.inside, one);
    }
    return body;
}

/// A region of the body by code: its standard views of bodies that are drawn at random.
class region_subject : public subject {
  public:
    /// @throws usage_error  for a range of a parameter beyond that of the region
    region_subject(const description& d, const anatomy::region& region) : region_{region}, chosen_{d.views} {
        // Bodies that have all structures: choices and sizes at both ends.
        for (const auto end :
             {&anatomy::parameter::usual, &anatomy::parameter::smallest, &anatomy::parameter::largest}) {
            anatomy::values values;
            for (const anatomy::parameter& one : region.parameters)
                values[one.name] = is_resolution(one) ? one.smallest : one.*end;
            anatomy::body one = make_whole(values);
            if (structures_.empty()) structures_.emplace_back("background", one.anatomy.background());
            for (const object& each : one.anatomy.objects()) structures_.emplace_back(structure(each), each.inside);
            if (all_views_.empty())
                for (const anatomy::view& each : one.views) all_views_.push_back(each.name);
            choose_views(one);
            if (views_.empty()) views_ = one.views;
            deepest_.resize(views_.size());
            for (std::size_t i = 0; i < deepest_.size(); ++i)
                deepest_[i] = max(deepest_[i], one.views[i].settings.depth);
        }
        if (!views_.empty())
            for (const std::string& text : d.parameters) add_range(named_range{text});
    }

    std::string name() const override { return region_.name; }
    std::string note() const override { return ""; }
    const std::vector<std::pair<std::string, medium>>& structures() const override { return structures_; }
    std::string structure(const object& one) const override { return structure_of(one.name); }
    const std::vector<anatomy::parameter>& parameters() const override { return region_.parameters; }

    /// As `region::drawn`, but for the parameters that have a range of their own.
    anatomy::values drawn(std::uint64_t seed) const override {
        constexpr std::uint64_t beyond_those_of_the_region = 1000;
        anatomy::values all = region_.drawn(seed);
        for (std::size_t i = 0; i < region_.parameters.size(); ++i) {
            const anatomy::parameter& one = region_.parameters[i];
            const auto found = ranges_.find(one.name);
            if (found == ranges_.end()) continue;
            const auto [from, to] = found->second;
            const float part = hash_uniform(seed, beyond_those_of_the_region + i);
            all[one.name] =
                one.is_choice ? min(from + std::floor(part * (to - from + 1)), to) : from + part * (to - from);
        }
        return region_.completed(all);
    }
    anatomy::body make(const anatomy::values& values) const override {
        anatomy::body made = make_whole(values);
        choose_views(made);
        return made;
    }
    /// The names of all views, also of those that no sample is of.
    const std::vector<std::string>& all_views() const { return all_views_; }
    const std::vector<anatomy::view>& views() const override { return views_; }
    float deepest(std::size_t view) const override { return deepest_[view]; }

    /// The probe keeps the angle to the skin that it has in the view, and turns about the middle of the image.
    standpoint standpoint_of(const anatomy::view& seen) const override {
        const float half = 0.5F * seen.settings.depth;
        constexpr float outside = 60_mm; // of the skin, where it is curved and the probe has moved
        return {.straight = seen.at,
                .centre = seen.at.point({0, 0, half}),
                .away = half + outside,
                .faces_skin = false,
                .on = "skin"};
    }

  private:
    anatomy::body make_whole(const anatomy::values& values) const {
        anatomy::body made = region_.make(values);
        if (region_.name == std::string{"nerve_block"}) made.anatomy = widened(made.anatomy);
        return made;
    }
    void choose_views(anatomy::body& made) const {
        if (chosen_.empty()) return;
        std::erase_if(made.views, [&](const anatomy::view& one) {
            return std::find(chosen_.begin(), chosen_.end(), one.name) == chosen_.end();
        });
    }
    static bool is_resolution(const anatomy::parameter& one) { return std::string{one.name} == "resolution"; }

    // Without a unit, the first number has that of the second one.
    void add_range(const named_range& given) {
        for (const anatomy::parameter& one : region_.parameters) {
            if (one.name != given.name) continue;
            const auto unit_of = [](const std::string& end) { return end.substr(end.find_last_of("0123456789.") + 1); };
            const bool borrows = !given.from.empty() && unit_of(given.from).empty();
            const std::string from = given.from + (borrows ? unit_of(given.to) : "");
            const range written{anatomy::written_value(one, from), anatomy::written_value(one, given.to)};
            const std::string fault = "--parameter: " + given.name;
            const anatomy::parameter_unit in = one.written_unit();
            if (!is_finite(written.from) || !is_finite(written.to))
                throw usage_error{fault + ": " + range::complaint(given.text) +
                                  (*in.name ? std::string{"; without a unit it is in "} + in.name : "")};
            if (!(written.from <= written.to))
                throw usage_error{fault + "=" + given.text + " runs backwards; write the smaller number first"};
            try {
                ranges_[one.name] = {region_.checked(one, written.from * in.size, in),
                                     region_.checked(one, written.to * in.size, in)};
            } catch (const usage_error& beyond) {
                throw usage_error{fault + "=" + given.text + ": " + beyond.what()};
            }
        }
    }

    const anatomy::region& region_;
    std::vector<std::string> chosen_{}, all_views_{};
    std::vector<std::pair<std::string, medium>> structures_{};
    std::map<std::string, range> ranges_{};
    std::vector<anatomy::view> views_{};
    std::vector<float> deepest_{};
};

} // namespace dataset
#endif
