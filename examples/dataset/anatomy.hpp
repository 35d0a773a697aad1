#ifndef INSONIFY_DATASET_ANATOMY_HPP
#define INSONIFY_DATASET_ANATOMY_HPP

#include "../anatomy_check.hpp"
#include "../nerve_block_phantom.hpp"
#include "sample.hpp"
#include <algorithm>
#include <cmath>
#include <optional>

namespace dataset {

/// The names that labels stand for: 0 is the background, then the objects of all anatomies in alphabetical order, the
/// needle last. Objects of one name have one label.
struct label_names {
    static constexpr std::uint8_t outside = 255; ///< outside the field of view
    std::vector<std::string> names{};

    std::uint8_t of(const std::string& name) const {
        const auto found = std::find(names.begin(), names.end(), name);
        return static_cast<std::uint8_t>(found - names.begin());
    }
};

/// The phantom of a nerve block without its needle, as each sample has its own or none. What is further than 20 mm from the
/// middle, across or along the limb, is stretched, and the lower side is 6 mm deeper: a linear array at the ends of the
/// default ranges, or pressed in by 4 mm, shows neither the sides nor what is below. The layers, which reach there, get more
/// vertices for `bend` and `pressure`.
inline scene wide_phantom() {
    const scene narrow = nerve_block_phantom();
    scene body{narrow.background()};
    const auto stretched = [](float x) {
        const float beyond = std::fabs(x) - 20_mm;
        return beyond > 0 ? std::copysign(20_mm + 3.5F * beyond, x) : x;
    };
    for (const object& one : narrow.objects()) {
        if (one.name == "needle") continue;
        mesh surface = one.surface;
        if (std::any_of(surface.positions.begin(), surface.positions.end(), [](vec3 p) { return p.x > 20_mm; }))
            surface = subdivide(surface);
        for (vec3& p : surface.positions) p = {stretched(p.x), stretched(p.y), p.z > 46_mm ? p.z + 6_mm : p.z};
        body.add(std::move(surface), one.inside, one);
    }
    return body;
}

/// A smooth displacement: waves along three directions.
struct bending {
    vec3 direction[3]{};
    vec3 wave[3]{};      ///< radians per metre
    float phase[3]{};    ///< radians
    float amplitude = 0; ///< of each wave, metres

    bending() = default;
    bending(const description& d, const sample& s) {
        amplitude = s.bend * 1_mm * std::sqrt(2.0F / 3);
        for (std::uint64_t i = 0; i < 3; ++i) {
            const auto random = [&](std::uint64_t k) { return hash_normal(s.seed, 2000 + 10 * i + k); };
            const vec2 a = random(0), b = random(1), c = random(2);
            direction[i] = normalize(vec3{a.x, a.y, b.x});
            wave[i] = normalize(vec3{b.y, c.x, c.y}) * (2 * pi / (d.bend_length * 1_mm));
            phase[i] = 2 * pi * hash_uniform(s.seed, 2000 + 10 * i + 9);
        }
    }
    vec3 operator()(vec3 p) const {
        vec3 sum{0, 0, 0};
        for (int i = 0; i < 3; ++i) sum += amplitude * std::sin(dot(wave[i], p) + phase[i]) * direction[i];
        return sum;
    }
};

/// What was done to the anatomy of a sample.
struct specimen {
    pose at{};                   ///< of the probe
    bool on_surface = true;      ///< false: the probe's place is beside the anatomy
    bending bend{};              ///< of the scaled anatomy
    std::vector<vec2> factors{}; ///< of attenuation and backscatter: the background, then the objects
    contact touch{};             ///< of the probe, where it is pressed
};

/// The anatomies as they were loaded.
class anatomies {
  public:
    /// @throws io_error, usage_error, geometry_error  for a file that cannot be used, or without the object of `around`
    explicit anatomies(const description& d) {
        if (d.anatomy.empty()) {
            originals_.push_back(wide_phantom());
            files_.emplace_back("nerve block phantom");
            find_around(d, files_.back());
        }
        for (const std::string& file : d.anatomy) {
            const float unit = d.unit * 1_mm;
            std::vector<std::string> notes;
            originals_.push_back(
                load_obj_scene(file, {.unit = unit, .background = *tissue::find(d.background)}, notes));
            files_.push_back(as_utf8(std::filesystem::path{file}.filename().string()));
            check_anatomy(originals_.back(), file, unit);
            descriptions_.push_back(describe_anatomy(file, originals_.back(), unit, notes));
            find_around(d, file);
        }
        name_objects();
    }

    const label_names& labels() const { return labels_; }
    const std::vector<std::string>& files() const { return files_; }
    /// What was read from each file, and what the anatomy has otherwise.
    const std::vector<std::string>& descriptions() const { return descriptions_; }
    const scene& original(std::size_t anatomy) const { return originals_[anatomy]; }
    /// Of the objects of an anatomy, in its order.
    const std::vector<std::string>& names(std::size_t anatomy) const { return names_[anatomy]; }
    std::size_t most_objects() const {
        std::size_t most = 0;
        for (const auto& each : names_) most = std::max(most, each.size());
        return most;
    }

    /// The anatomy of a sample: scaled, bent, pressed, with its own media; and the pose of the probe on it.
    template <transducer Probe>
    std::pair<scene, specimen> make(const Probe& probe, const description& d, const sample& s) const {
        const scene& original = originals_[s.anatomy];
        std::uint64_t next = 1000; // beyond those of draw_sample
        std::vector<vec2> factors;
        const auto varied = [&](medium one) {
            const auto factor = [&] {
                return d.media.from + (d.media.to - d.media.from) * hash_uniform(s.seed, next++);
            };
            factors.push_back({factor(), 0});
            factors.back().y = factor();
            one.attenuation *= factors.back().x;
            one.backscatter *= factors.back().y;
            return one;
        };
        specimen made{.bend{d, s}};
        scene body{varied(original.background())};
        aabb box;
        std::vector<object_id> ids;
        for (const object& one : original.objects()) {
            mesh surface = one.surface;
            for (vec3& p : surface.positions) {
                const vec3 scaled = s.scale * one.at.point(p);
                p = scaled + made.bend(scaled);
                box = merged(box, p);
            }
            ids.push_back(body.add(
                std::move(surface), varied(one.inside),
                {.priority = one.priority, .fibres = fibres_of(one, s.scale), .crease_angle = one.crease_angle}));
        }
        std::optional<object_id> needle; // built with the others, and placed where the probe turns out to be
        if (s.needle)
            needle = body.add(make_needle(needle_diameter(s.gauge), 100_mm), tissue::steel, {.priority = 100});
        body.build(exec::seq);
        const std::optional<std::size_t> around = around_[s.anatomy];
        const probe_place place =
            place_probe(body, box, around ? std::optional{ids[*around]} : std::nullopt, needle, d, s);
        const pose &skin = place.skin, &at = place.at;
        body.set_background_fibres(skin.direction({1, 0, 0}), skin.direction({0, 0, 1}));
        if (needle) {
            body.place(*needle, needle_pose(s, at));
            body.update(exec::seq);
        }
        if (s.pressure > 0) made.touch = yield(body, probe, at, place.outside, needle);
        made.at = at;
        made.on_surface = place.on_surface;
        made.factors = std::move(factors);
        return {std::move(body), std::move(made)};
    }

  private:
    // The object that the probe is placed on, in the anatomy that was loaded last.
    void find_around(const description& d, const std::string& file) {
        const auto& objects = originals_.back().objects();
        std::string known;
        around_.push_back(d.around.empty() ? std::optional<std::size_t>{} : objects.size());
        for (std::size_t i = 0; i < objects.size(); ++i) {
            if (around_.back() == objects.size() && objects[i].name == d.around) around_.back() = i;
            known += (known.empty() ? "" : ", ") + name_of(objects[i]);
        }
        if (around_.back() == objects.size())
            throw usage_error{"--around: " + file + " has no object '" + d.around + "'; it has " + known};
    }
    // Objects without a name get one, and those that are named like the background or the needle another one.
    void name_objects() {
        std::vector<std::string> found;
        for (const scene& original : originals_) {
            names_.emplace_back();
            for (const object& one : original.objects()) {
                std::string name = as_utf8(name_of(one));
                while (name == "background" || name == "needle") name += " (object)";
                names_.back().push_back(name);
                found.push_back(std::move(name));
            }
        }
        std::sort(found.begin(), found.end());
        found.erase(std::unique(found.begin(), found.end()), found.end());
        labels_.names = std::move(found);
        labels_.names.insert(labels_.names.begin(), "background");
        labels_.names.emplace_back("needle");
        if (labels_.names.size() > label_names::outside)
            throw usage_error{"--anatomy: more than 253 names of objects; labels are 8-bit"};
    }
    static std::string name_of(const object& one) {
        return one.name.empty() ? "object " + std::to_string(static_cast<std::uint32_t>(one.id)) : one.name;
    }

    /// Deforms the body, but not the needle, where the probe is pressed into it.
    /// @param outside  a point in front of the surface: gel that contains it makes way
    template <transducer Probe>
    static contact yield(scene& body, const Probe& probe, const pose& at, vec3 outside,
                         std::optional<object_id> needle) {
        const auto contains_outside = [&](object_id id) {
            const ray away{.origin = outside, .direction = {0, 0, 1}};
            const auto hit = first_surface(body, away, [=](object_id other) { return other == id; });
            return hit && dot(hit->normal, away.direction) > 0;
        };
        std::vector<object_id> soft, pressed;
        for (const object& one : body.objects()) {
            if (one.id == needle) continue;
            soft.push_back(one.id);
            if (!contains_outside(one.id)) pressed.push_back(one.id);
        }
        contact touch = press(body, probe, at, {.decay = 1}, [&](object_id id) {
            return std::find(pressed.begin(), pressed.end(), id) != pressed.end();
        });
        touch.deformation.decay = max(20_mm, 2 * touch.depth); // an edge of a tilted probe may be deep
        body.deform(exec::seq, touch.deformation, soft);
        return touch;
    }

    /// The fibres of an object where it has been moved to: as if it were not bent.
    static fibre_directions fibres_of(const object& one, float scale) {
        if (!one.fibres.varies()) return one.at.direction(one.fibres({0, 0, 0}));
        return [fibres = one.fibres, at = one.at, scale](vec3 p) {
            return at.direction(fibres(at.local_point(p / scale)));
        };
    }

    /// Where the probe is, and a point in front of the surface there.
    struct probe_place {
        pose skin{}; ///< x along `lateral`, z inwards: what `at` is a turn of
        pose at{};
        vec3 outside{0, 0, 0};
        bool on_surface = true;
    };

    /// On the surface of the object `around`, or of the first, facing inwards.
    static probe_place place_probe(const scene& body, aabb box, std::optional<object_id> on,
                                   std::optional<object_id> needle, const description& d, const sample& s) {
        if (on) box = body.box(*on);
        const vec3 from = normalize(vec3{d.from[0], d.from[1], d.from[2]}),
                   lateral{d.lateral[0], d.lateral[1], d.lateral[2]};
        const pose straight = look_at(box.centre() + from, box.centre(), lateral); // z inwards
        const float spread = s.spread * 1_deg, azimuth = s.azimuth * 1_deg;
        const vec3 outwards = straight.direction(
            {std::sin(spread) * std::cos(azimuth), std::sin(spread) * std::sin(azimuth), -std::cos(spread)});
        const vec3 shift = straight.direction({s.along * 1_mm, s.across * 1_mm, 0});
        const float far = length(box.size());
        const auto hit = first_surface(body, {.origin = box.centre() + shift + far * outwards, .direction = -outwards},
                                       [=](object_id id) { return on ? id == *on : id != needle; });
        // A ray that misses leaves the probe on the box, looking at its middle.
        const vec3 place = hit ? hit->point : box.centre() + shift + 0.5F * far * outwards;
        const vec3 inwards = hit ? -hit->normal : -outwards;
        const pose on_surface =
            look_at(place + (s.pressure - s.standoff) * 1_mm * inwards, place + inwards,
                    std::fabs(dot(normalize(lateral), inwards)) < 0.99F ? lateral : straight.rotation[1]);
        const auto turned = [](float degrees, int axis) {
            const float c = std::cos(degrees * 1_deg), n = std::sin(degrees * 1_deg);
            const int i = (axis + 1) % 3, j = (axis + 2) % 3;
            mat3 m{1};
            m[i][i] = m[j][j] = c;
            m[i][j] = n;
            m[j][i] = -n;
            return pose{m, {0, 0, 0}};
        };
        return {on_surface, on_surface * turned(s.turn, 2) * turned(s.tilt, 0) * turned(s.rock, 1),
                place - 0.1_mm * inwards, hit.has_value()};
    }

    /// In the plane of the image, from the left, its tip below the middle of the face.
    static pose needle_pose(const sample& s, const pose& probe) {
        const float angle = s.needle_angle * 1_deg;
        const vec3 tip = probe.point({0, 0, s.needle_depth * 1_mm});
        return look_at(tip, tip + probe.direction({std::cos(angle), 0, std::sin(angle)}), probe.direction({0, 1, 0}));
    }

    std::vector<scene> originals_;
    std::vector<std::string> files_; // their names
    std::vector<std::string> descriptions_;
    std::vector<std::vector<std::string>> names_;
    std::vector<std::optional<std::size_t>> around_; // the object that the probe is placed on
    label_names labels_;
};

} // namespace dataset
#endif
