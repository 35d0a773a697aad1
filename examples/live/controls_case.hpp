#ifndef INSONIFY_EXAMPLES_LIVE_CONTROLS_CASE_HPP
#define INSONIFY_EXAMPLES_LIVE_CONTROLS_CASE_HPP

#include "presets.hpp"

namespace live::detail {

/// Events that open another body.
inline std::span<const control> case_controls() {
    static constexpr auto titles = [] {
        std::array<literal, std::size(cases)> all;
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = cases[i].title;
        return all;
    }();
    static constexpr control all[] = {
        {.event = "case",
         .group = "Case",
         .title = "Case",
         .tooltip = "Opens a body with its probe, its settings and a needle",
         .low = 0,
         .high = static_cast<float>(titles.size() - 1),
         .value = [](const session& s) { return s.case_number ? static_cast<float>(*s.case_number) : -1; },
         .choices = titles,
         .run = [](session& s, const float* v, std::uint32_t) { s.open(whole(v[0]), s.patient_number); }},
        {.event = "patient",
         .group = "Case",
         .title = "Patient",
         .tooltip = "Draws another body of that region by number; 0: the usual one",
         .low = 0,
         .high = static_cast<float>(max_patient),
         .value = [](const session& s) { return static_cast<float>(s.patient_number); },
         .run =
             [](session& s, const float* v, std::uint32_t) {
                 if (s.case_number)
                     s.open(*s.case_number, whole(v[0]));
                 else
                     s.patient_number = whole(v[0]); // of the next case
             },
         .grid = 1}};
    return all;
}

} // namespace live::detail

#endif
