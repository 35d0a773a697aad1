#ifndef INSONIFY_DATASET_SUMMARY_HPP
#define INSONIFY_DATASET_SUMMARY_HPP

#include "parts.hpp"
#include "statistics.hpp"
#include <algorithm>
#include <array>
#include <filesystem>
#include <iomanip>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace dataset {

namespace detail {

/// A percentage with one decimal.
inline std::string percent(double fraction) {
    std::ostringstream text;
    text << std::fixed << std::setprecision(1) << 100 * fraction << " %";
    return text.str();
}

/// Mean brightness of the part of a square image that is a pixel of a smaller one.
/// @param size   columns and rows
/// @param small  those of the smaller one
inline float mean_of(const std::vector<std::uint8_t>& pixels, std::uint32_t size, std::uint32_t small, std::uint32_t x,
                     std::uint32_t y) {
    const auto begin = [=](std::uint32_t at) { return at * size / small; };
    const auto end = [=](std::uint32_t at) { return std::max(begin(at) + 1, begin(at + 1)); };
    float sum = 0, count = 0;
    for (std::uint32_t row = begin(y); row < end(y); ++row)
        for (std::uint32_t column = begin(x); column < end(x); ++column, ++count)
            sum += static_cast<float>(pixels[std::size_t{row} * size + column]);
    return sum / (255 * count);
}

/// How many samples have each of some names.
/// @param of  index of the name of each sample; NaN or beyond the names: none
inline void write_fractions(std::ostream& page, const char* title, const std::vector<std::string>& names,
                            const std::vector<float>& of) {
    std::vector<std::size_t> counts(names.size());
    std::size_t all = 0;
    for (const float index : of)
        if (index >= 0 && index < static_cast<float>(names.size())) {
            ++counts[static_cast<std::size_t>(index)];
            ++all;
        }
    if (all == 0) return;
    page << "<table><tr><th>" << title << "<th>samples<th>share\n";
    for (std::size_t i = 0; i < names.size(); ++i)
        page << "<tr><td>" << html(names[i]) << "<td>" << counts[i] << "<td>"
             << percent(static_cast<double>(counts[i]) / static_cast<double>(all)) << "\n";
    page << "</table>\n";
}

/// A histogram of what varies; nothing where it does not.
inline void write_histogram(std::ostream& page, const fact& name, std::vector<float> values) {
    std::erase_if(values, [](float value) { return !is_finite(value); });
    if (values.empty()) return;
    const auto [smallest, largest] = std::minmax_element(values.begin(), values.end());
    if (*smallest == *largest) return;
    constexpr std::size_t bars = 20;
    std::array<std::size_t, bars> counts{};
    for (const float value : values)
        ++counts[std::min(bars - 1, static_cast<std::size_t>((value - *smallest) / (*largest - *smallest) * bars))];
    const auto highest = static_cast<float>(*std::max_element(counts.begin(), counts.end()));
    page << "<svg width=240 height=100><text x=0 y=12 font-size=12>" << name.short_name() << ", " << name.name.unit
         << ": " << *smallest << " to " << *largest << "</text>";
    for (std::size_t i = 0; i < bars; ++i) {
        const float height = 75 * static_cast<float>(counts[i]) / highest;
        page << "<rect x=" << 11 * i << " y=" << 95 - height << " width=10 height=" << height << " fill=#467 />";
    }
    page << "</svg>\n";
}

} // namespace detail

/// A page with a contact sheet, what varied, and how often each label occurs, of the first samples.
inline void write_summary(const description& d, const anatomies& all, const parts& files) {
    constexpr std::uint32_t columns = 8, thumb = 128, max_shown = 48, max_counted = 10'000;
    const std::uint32_t shown = std::min(d.samples, max_shown), rows = (shown + columns - 1) / columns;
    const std::vector<std::string>& labels = all.labels().names;
    statistics counted{d.size, labels.size()};
    image sheet{uvec2{columns * thumb, rows * thumb}};
    files.read(std::min(d.samples, max_counted), [&](const stored_sample& one) {
        const auto i = static_cast<std::uint32_t>(counted.samples());
        counted.add(one);
        if (i >= shown || one.image.size() != std::size_t{d.size} * d.size) return;
        for (std::uint32_t y = 0; y < thumb; ++y)
            for (std::uint32_t x = 0; x < thumb; ++x)
                sheet(i % columns * thumb + x, i / columns * thumb + y) =
                    detail::mean_of(one.image, d.size, thumb, x, y);
    });
    const std::filesystem::path folder{d.output};
    write_png((folder / "summary.png").string(), sheet);

    const std::vector<const fact*> scalars = files.arrays().scalars();
    const auto values_of = [&](const std::string& name) {
        for (std::size_t i = 0; i < scalars.size(); ++i)
            if (scalars[i]->short_name() == name) return counted.values(i);
        return std::vector<float>{};
    };
    const std::vector<float> needle = values_of("needle");
    const auto with_needle = [&](std::vector<float> values) {
        for (std::size_t i = 0; i < values.size(); ++i)
            if (needle[i] == 0) values[i] = std::numeric_limits<float>::quiet_NaN();
        return values;
    };

    std::ostringstream page;
    page << "<!doctype html><meta charset=utf-8><title>" << d.samples
         << " samples</title>\n<style>body{font:14px sans-serif;"
            "max-width:1024px;margin:2em auto}td,th{padding:0 1em 0 0;text-align:left}svg{margin:0 8px 8px 0}"
            "table{margin:0 0 1em 0}.beside{display:flex;flex-wrap:wrap;gap:0 3em;align-items:flex-start}</style>\n<h1>"
         << d.samples << " samples of " << d.size << " x " << d.size << " pixels</h1>\n<p>The first " << shown
         << ":</p>\n<img src=summary.png width=1024>\n<h2>What they are of</h2>\n";
    if (counted.samples() < d.samples) page << "<p>From here on: the first " << counted.samples() << " samples.</p>\n";
    page << "<div class=beside>\n";
    detail::write_fractions(page, "anatomy", all.names(), values_of("anatomy"));
    if (all.cycle() > all.size()) detail::write_fractions(page, "view", all.view_names(), values_of("view"));
    detail::write_fractions(page, "side of the body", {"left", "right"}, values_of("side"));
    detail::write_fractions(page, "needle", {"none", "present"}, needle);
    detail::write_fractions(page, "needle from the", {"left", "right"}, with_needle(values_of("needle_side")));
    page << "</div>\n<h2>What varies</h2>\n";
    for (std::size_t i = 0; i < scalars.size(); ++i) {
        const std::string name = scalars[i]->short_name();
        if (name == "anatomy" || name == "view" || name == "side" || name == "needle" || name == "needle_side")
            continue;
        const bool is_of_needle = name == "gauge" || name.rfind("needle_", 0) == 0;
        detail::write_histogram(page, *scalars[i], is_of_needle ? with_needle(counted.values(i)) : counted.values(i));
    }
    page << "<h2>Labels</h2>\n<p>A predictor that sees no image, and answers for each place the label that is most "
            "frequent "
            "there, is right for <b>"
         << detail::percent(counted.most_frequent_fraction())
         << "</b> of the pixels in the field of view: a learner must do better.</p>\n";
    std::string never;
    for (std::size_t label = 0; label < labels.size(); ++label)
        if (counted.images_with(label) == 0) never += (never.empty() ? "" : ", ") + html(labels[label]);
    page << "<p>Labels that occur in no sample: " << (never.empty() ? "none" : never) << ".</p>\n"
         << "<table><tr><th>label<th>name<th>share of the pixels<th>images with it\n";
    for (std::size_t label = 0; label < labels.size(); ++label)
        page << "<tr><td>" << label << "<td>" << html(labels[label]) << "<td>" << 100 * counted.fraction_of(label)
             << " %<td>" << counted.images_with(label) << " of " << counted.samples() << "\n";
    page << "</table>\n";
    replace_file(folder / "summary.html", page.str());
}

} // namespace dataset
#endif
