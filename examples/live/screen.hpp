#ifndef INSONIFY_EXAMPLES_LIVE_SCREEN_HPP
#define INSONIFY_EXAMPLES_LIVE_SCREEN_HPP

#include <insonify/insonify.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace live {

using namespace insonify;

/// A hash of numbers, of every bit (FNV-1a).
inline std::uint64_t hash_of(const float* numbers, std::size_t count, std::uint64_t hash = 14695981039346656037U) {
    for (std::size_t i = 0; i < count; ++i) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, numbers + i, sizeof bits);
        for (int byte = 0; byte < 4; ++byte) hash = (hash ^ (bits >> 8 * byte & 0xFFU)) * 1099511628211U;
    }
    return hash;
}
inline std::uint64_t hash_of(const image& picture) { return hash_of(picture.pixels.data(), picture.pixels.size()); }
inline std::uint64_t hash_of(const colour_image& picture) {
    static_assert(sizeof(vec3) == 3 * sizeof(float));
    return picture.pixels.empty() ? hash_of(nullptr, 0) : hash_of(&picture.pixels[0].x, 3 * picture.pixels.size());
}

/// An entry of the legend of labels.
struct legend_entry {
    std::string name{};
    vec3 colour{1};
};

/// The colour of an object in labels and in the 3-D view, as in an atlas: that of what its name says, or of its medium.
inline vec3 colour_of(const object& one) {
    struct entry {
        const char* word;
        vec3 colour;
    };
    static constexpr entry known[] = {
        {"artery wall", {0.8F, 0.1F, 0.1F}}, {"vein wall", {0.15F, 0.25F, 0.85F}}, {"artery", {0.95F, 0.15F, 0.15F}},
        {"vein", {0.2F, 0.35F, 1}},          {"epineurium", {0.9F, 0.6F, 0.1F}},   {"fascicle", {1, 0.95F, 0.45F}},
        {"nerve", {1, 0.8F, 0.2F}},          {"bone", {0.9F, 0.9F, 0.85F}},        {"needle", {0.5F, 1, 1}},
        {"muscle", {0.7F, 0.25F, 0.25F}},    {"fascia", {0.8F, 0.85F, 0.9F}},      {"fat", {0.95F, 0.8F, 0.5F}},
        {"skin", {0.95F, 0.65F, 0.55F}},     {"gel", {0.5F, 0.75F, 0.9F}},         {"cartilage", {0.65F, 0.8F, 0.85F}},
        {"tendon", {0.9F, 0.88F, 0.75F}},    {"thyroid", {0.8F, 0.45F, 0.4F}},     {"liver", {0.55F, 0.25F, 0.2F}},
        {"kidney", {0.65F, 0.35F, 0.25F}},   {"lung", {0.9F, 0.7F, 0.75F}},        {"bile", {0.45F, 0.6F, 0.2F}},
        {"mucosa", {0.9F, 0.5F, 0.5F}},      {"connective", {0.85F, 0.8F, 0.75F}}, {"capsule", {0.8F, 0.75F, 0.65F}}};
    const auto find = [](const std::string& text) {
        return std::find_if(std::begin(known), std::end(known),
                            [&](const entry& each) { return text.find(each.word) != std::string::npos; });
    };
    if (const entry* const named = find(one.name); named != std::end(known)) return named->colour;
    std::uint32_t hash = 2166136261U;
    for (const char letter : one.name) hash = (hash ^ static_cast<unsigned char>(letter)) * 16777619U;
    const auto part = [&](std::uint32_t shift) { return static_cast<float>(hash >> shift & 255U) / 255; };
    const vec3 own{part(0), part(8), part(16)};
    for (const tissue::named_medium& medium : tissue::all)
        if (medium.value == one.inside)
            if (const entry* const of = find(medium.name); of != std::end(known))
                return 0.8F * of->colour + 0.2F * own; // objects of one tissue can be told apart
    return 0.35F + 0.64F * own;
}

/// Gray in all three channels.
inline void copy_gray(const image& gray, colour_image& screen) {
    screen.size = gray.size;
    screen.pixels.resize(gray.pixels.size());
    for (std::size_t i = 0; i < gray.pixels.size(); ++i)
        screen.pixels[i] = vec3{std::clamp(gray.pixels[i], 0.0F, 1.0F)};
}

/// Tints each object by its colour and outlines it; the legend has the names of those that are seen, from above.
inline void draw_labels(colour_image& screen, const label_image& labels, const scene& body,
                        std::vector<legend_entry>& legend) {
    legend.clear();
    std::vector<std::pair<label_id, vec3>> colours;
    const auto colour_of_label = [&](label_id label) {
        for (const auto& [known, colour] : colours)
            if (known == label) return colour;
        std::string name = "outside";
        vec3 colour{0};
        for (const object& one : body.objects())
            if (static_cast<label_id>(one.id) == label) {
                name = one.name.empty() ? "object" : one.name;
                colour = colour_of(one);
            }
        colours.emplace_back(label, colour);
        const bool listed =
            std::any_of(legend.begin(), legend.end(), [&](const legend_entry& entry) { return entry.name == name; });
        if (label != background_label && !listed) legend.push_back({name, colour});
        return colour;
    };
    const uvec2 size = labels.size;
    if (size != screen.size) return;
    for (std::uint32_t y = 0; y < size.y; ++y)
        for (std::uint32_t x = 0; x < size.x; ++x) {
            const label_id label = labels(x, y);
            if (label == background_label) continue;
            const bool edge =
                (x + 1 < size.x && labels(x + 1, y) != label) || (y + 1 < size.y && labels(x, y + 1) != label);
            const vec3 colour = colour_of_label(label);
            screen(x, y) = edge ? 0.9F * colour : 0.75F * screen(x, y) + 0.25F * colour * (0.4F + screen(x, y));
        }
}

/// Draws a line between two points in pixel coordinates.
inline void draw_line(colour_image& screen, vec2 from, vec2 to, vec3 colour) {
    const float steps = std::ceil(std::max(length(to - from), 1.0F));
    for (float i = 0; i <= steps; ++i) {
        const vec2 at = from + i / steps * (to - from);
        if (at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(screen.size.x) &&
            at.y < static_cast<float>(screen.size.y))
            screen(static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y)) = colour;
    }
}

} // namespace live

#endif
