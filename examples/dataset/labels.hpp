#ifndef INSONIFY_DATASET_LABELS_HPP
#define INSONIFY_DATASET_LABELS_HPP

#include <insonify/core/error.hpp>
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace dataset {

/// The names that labels stand for: 0 is the background, then structures in alphabetical order, the needle last.
/// Structures of one name have one label.
struct label_names {
    static constexpr std::uint8_t outside = 255; ///< outside the field of view
    std::vector<std::string> names{};

    label_names() = default;
    /// @param structures  of all anatomies
    /// @throws usage_error  for more than labels of 8 bits can tell apart
    explicit label_names(std::vector<std::string> structures) : names{std::move(structures)} {
        std::sort(names.begin(), names.end());
        names.erase(std::unique(names.begin(), names.end()), names.end());
        std::erase(names, "background");
        names.insert(names.begin(), "background");
        names.emplace_back("needle");
        if (names.size() > outside)
            throw insonify::usage_error{"--anatomy: more than 253 names of objects; labels are 8-bit"};
    }

    std::uint8_t of(const std::string& name) const {
        const auto found = std::find(names.begin(), names.end(), name);
        return static_cast<std::uint8_t>(found - names.begin());
    }
    std::uint8_t needle() const { return static_cast<std::uint8_t>(names.size() - 1); }
};

namespace detail {

/// Structures that the views of a region show rarely or never, and what they are, together with others that are seen often
/// enough to be learnt.
struct kind_of_structure {
    std::string_view structure, kind;
};
inline constexpr kind_of_structure rare_structures[] = {
    {"common carotid artery", "carotid artery"},
    {"external carotid artery", "carotid artery"},
    {"cricoid cartilage", "cartilage of the airway"},
    {"thyroid cartilage", "cartilage of the airway"},
    {"tracheal cartilages", "cartilage of the airway"},
    {"laryngeal muscles", "other muscles of the neck"},
    {"levator scapulae", "other muscles of the neck"},
    {"paraspinal muscles", "other muscles of the neck"},
    {"thyrohyoid", "other muscles of the neck"},
    {"deep femoral artery", "femoral artery"},
    {"accessory saphenous vein", "saphenous vein"},
    {"great saphenous vein", "saphenous vein"},
    {"small saphenous vein", "saphenous vein"},
    {"adductor longus", "other muscles of the thigh"},
    {"adductor magnus", "other muscles of the thigh"},
    {"central tendon of rectus femoris", "other muscles of the thigh"},
    {"gluteus maximus and hamstrings", "other muscles of the thigh"},
    {"gluteus medius", "other muscles of the thigh"},
    {"gracilis", "other muscles of the thigh"},
    {"rectus femoris", "other muscles of the thigh"},
    {"tensor fasciae latae", "other muscles of the thigh"},
    {"vastus medialis", "other muscles of the thigh"},
    {"anterior muscles of the lower leg", "other muscles of the lower leg"},
    {"fibulares", "other muscles of the lower leg"},
    {"flexor digitorum longus", "other muscles of the lower leg"},
    {"flexor hallucis longus", "other muscles of the lower leg"},
    {"tibialis posterior", "other muscles of the lower leg"},
    {"fibula", "bone"},
    {"tibia", "bone"},
};

} // namespace detail

/// What a learner can tell from an image: the name of a region's object without its side, its level and its number, of rare
/// structures their kind. "left common carotid artery: intima" is "carotid artery: intima", "fifth cervical root: fascicle 2"
/// is "cervical root: fascicle".
inline std::string structure_of(std::string_view object) {
    constexpr std::string_view first_words[] = {"left",  "right",   "first",  "second", "third", "fourth",   "fifth",
                                                "sixth", "seventh", "eighth", "ninth",  "tenth", "eleventh", "twelfth"};
    for (bool found = true; found;) {
        found = false;
        for (const std::string_view word : first_words)
            if (object.size() > word.size() + 1 && object.substr(0, word.size()) == word &&
                object[word.size()] == ' ') {
                object.remove_prefix(word.size() + 1);
                found = true;
            }
    }
    const std::size_t end = object.find_last_not_of("0123456789");
    if (end != std::string_view::npos && end + 1 < object.size() && object[end] == ' ') object = object.substr(0, end);
    const std::string_view whole = object.substr(0, object.find(':')), part = object.substr(whole.size());
    for (const auto& [structure, kind] : detail::rare_structures)
        if (structure == whole) return std::string{kind}.append(part);
    return std::string{object};
}

} // namespace dataset
#endif
