#ifndef INSONIFY_DATASET_ACQUISITION_HPP
#define INSONIFY_DATASET_ACQUISITION_HPP

#include "../channels/arrays.hpp"
#include "../channels/truth_maps.hpp"
#include "sample.hpp"
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace dataset {

/// The kind of probe that `--probe` replaces that of a view by.
inline any_array array_of(const description& d, const anatomy::view& seen) {
    if (d.probe == "linear") return linear_array{};
    if (d.probe == "convex") return convex_array{};
    if (d.probe == "phased") return phased_array{};
    return seen.probe;
}

/// The kinds of probes in a dataset, as zea calls them.
inline std::vector<std::string> probe_types(const description& d, const anatomies& all) {
    std::vector<std::string> found;
    for (std::size_t i = 0; i < all.size(); ++i)
        for (const anatomy::view& seen : all[i].views()) {
            const char* type = channels::array_type(array_of(d, seen));
            if (std::find(found.begin(), found.end(), type) == found.end()) found.emplace_back(type);
        }
    return found;
}

/// What `--channels` records of each sample: an array where the probe is, at its own frequency, as deep as the deepest image.
class acquisition {
  public:
    /// @throws usage_error  for an array of another kind than the probes
    acquisition(const description& d, const anatomies& all) : array_{&channels::find_array(d.channels)} {
        for (const std::string& type : probe_types(d, all))
            if (type != array_->type)
                throw usage_error{"--channels: " + d.channels + " is a " + array_->type + " array, but there are " +
                                  type + " probes; choose --probe, --anatomy or --view"};
        settings_.opening = array_->opening_deg * 1_deg;
        settings_.depth = 0;
        for (std::size_t i = 0; i < all.size(); ++i)
            for (std::size_t k = 0; k < all[i].views().size(); ++k)
                settings_.depth =
                    std::max(settings_.depth, limits_of(d, all[i].views()[k], all[i].deepest(k)).depth * 1_mm);
        std::visit([&](const auto& elements) { sent_ = channels::transmits_named(d.transmits, elements); },
                   array_->elements);
        scene empty;
        like_ = trace(empty.build(exec::seq), pose{}, settings_);
    }

    const channels::named_array& array() const { return *array_; }
    /// Channel data in which everything but the samples is that of all.
    const channel_data& like() const { return like_; }
    /// Of the maps of tissue.
    map_grid grid() const { return channels::slice_grid(*array_, like_, settings_.depth); }

    /// Transmits x samples x elements. @param frame  selects the speckle of flowing media
    std::vector<float> record(const scene& body, const pose& at, std::uint32_t frame) const {
        channel_settings settings = settings_;
        settings.frame = frame;
        const channel_data received = trace(body, at, settings);
        std::vector<float> values;
        values.reserve(received.values.size());
        for (std::uint32_t t = 0; t < received.transmits; ++t)
            for (std::uint32_t k = 0; k < received.samples; ++k)
                for (std::uint32_t e = 0; e < received.elements; ++e) values.push_back(received(t, e, k));
        return values;
    }

  private:
    channel_data trace(const scene& body, const pose& at, const channel_settings& settings) const {
        return std::visit(
            [&](const auto& elements) {
                return trace_channels(exec::unseq, body, elements, at, physical{}, sent_, settings);
            },
            array_->elements);
    }

    const channels::named_array* array_;
    channel_settings settings_{};
    std::vector<transmit> sent_{};
    channel_data like_{};
};

/// None without `--channels`.
inline std::optional<acquisition> acquisition_of(const description& d, const anatomies& all) {
    if (d.channels.empty()) return {};
    return acquisition{d, all};
}

} // namespace dataset
#endif
