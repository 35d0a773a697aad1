#ifndef INSONIFY_DATASET_ANATOMY_HPP
#define INSONIFY_DATASET_ANATOMY_HPP

#include "file_subject.hpp"
#include "region_subject.hpp"
#include <filesystem>
#include <limits>
#include <memory>
#include <numeric>

namespace dataset {

/// What one sample is of.
struct spot {
    std::uint32_t number = 0;    ///< of the sample
    std::uint32_t cycle = 0;     ///< in which each view of each anatomy occurs once
    std::uint32_t anatomy = 0;   ///< index into `anatomies`
    std::uint32_t view = 0;      ///< index into the views of the anatomy
    std::uint32_t body_seed = 0; ///< of the parameters of the body
    std::uint64_t body = 0;      ///< seed of all else that is random in the body
};

/// The anatomies that samples are drawn from.
///
/// Samples come in cycles. In each, every anatomy has one body, and every view of it one sample; these follow each other, so
/// that the body is made once. The order of the anatomies and of the views is random. Two bodies of a region in consecutive
/// cycles are of different sides.
class anatomies {
  public:
    /// @throws io_error, usage_error, geometry_error  for an anatomy, a view or a parameter that cannot be used
    explicit anatomies(const description& d) : d_{d} {
        if (d.anatomy.empty())
            for (const anatomy::region& one : anatomy::regions()) add(one);
        for (const std::string& word : d.anatomy) add(word);
        check_names();
        if (!has_file_) refuse_options_of_files(d);
        std::vector<std::string> structures;
        for (const auto& one : all_)
            for (const auto& [name, inside] : one->structures()) structures.push_back(name);
        labels_ = label_names{std::move(structures)};
        for (std::size_t i = 0; i < all_.size(); ++i)
            for (const anatomy::view& one : all_[i]->views()) {
                if (first_views_.size() == i) first_views_.push_back(view_names_.size());
                view_names_.push_back(one.name);
            }
    }

    const label_names& labels() const { return labels_; }
    std::size_t size() const { return all_.size(); }
    const subject& operator[](std::size_t anatomy) const { return *all_[anatomy]; }
    /// The names of the regions and files.
    std::vector<std::string> names() const {
        std::vector<std::string> names;
        for (const auto& one : all_) names.push_back(one->name());
        return names;
    }
    /// The names of the views of all anatomies; those of files are empty.
    const std::vector<std::string>& view_names() const { return view_names_; }
    /// Index into `view_names`.
    std::size_t view_of(const spot& at) const { return first_views_[at.anatomy] + at.view; }
    /// The parameters of all regions, each name once.
    const std::vector<anatomy::parameter>& parameters() const { return parameters_; }
    /// Samples in a cycle.
    std::uint32_t cycle() const { return static_cast<std::uint32_t>(view_names_.size()); }

    /// What a sample is of.
    spot place_of(std::uint32_t number) const {
        spot at{.number = number, .cycle = number / cycle()};
        const std::uint64_t seed = hash_bits(~d_.seed, at.cycle);
        std::size_t rest = number % cycle();
        for (const std::uint32_t anatomy : shuffled(all_.size(), seed)) {
            const std::size_t views = all_[anatomy]->views().size();
            if (rest >= views) {
                rest -= views;
                continue;
            }
            at.anatomy = anatomy;
            at.body = hash_bits(seed, anatomy);
            at.view = shuffled(views, at.body)[rest];
            at.body_seed = seed_of_body(at);
            break;
        }
        return at;
    }
    /// Whether two samples have the same body.
    static bool share_body(const spot& one, const spot& other) {
        return one.cycle == other.cycle && one.anatomy == other.anatomy;
    }
    /// The view of the usual body.
    const anatomy::view& usual_view(const spot& at) const { return all_[at.anatomy]->views()[at.view]; }

  private:
    // Options that would do nothing.
    static void refuse_options_of_files(const description& d) {
        const description usual;
        const auto refuse = [](const char* option, const char* instead) {
            throw usage_error{std::string{option} + " is for OBJ files" + instead};
        };
        constexpr const char* placed = "; in a region the probe is placed by --view";
        if (d.around != usual.around) refuse("--around", placed);
        if (d.from != usual.from) refuse("--from", placed);
        if (d.lateral != usual.lateral) refuse("--lateral", placed);
        if (d.unit != usual.unit) refuse("--unit", "; regions are in metres");
        if (d.skin != usual.skin) refuse("--skin", "; regions have skin");
        if (d.repair) refuse("--repair", "; the meshes of regions are closed");
        if (d.pennation != 0) refuse("--pennation", "; the muscles of regions have their fibres");
        if (d.background != usual.background) refuse("--background", "; regions have their own");
    }

    // A region that has one of the views.
    void add(const anatomy::region& region) {
        auto made = std::make_unique<region_subject>(d_, region);
        for (const std::string& one : made->all_views()) known_views_ += (known_views_.empty() ? "" : ", ") + one;
        if (made->views().empty()) return;
        all_.push_back(std::move(made));
        for (const anatomy::parameter& one : region.parameters)
            if (!has_parameter(one.name)) parameters_.push_back(one);
    }
    void add(const std::string& word) {
        const std::size_t before = all_.size();
        if (const anatomy::region* region = anatomy::region_named(word)) {
            add(*region);
        } else if (std::filesystem::is_regular_file(word)) {
            all_.push_back(std::make_unique<file_subject>(d_, word));
            has_file_ = true;
        } else {
            throw io_error{"--anatomy: there is no region and no file '" + word + "'; regions are " +
                           anatomy::names_of_regions() + ", and paths are relative to the current folder"};
        }
        if (all_.size() == before)
            throw usage_error{"--view: " + word + " has none of these views; known are " + known_views_};
    }
    bool has_parameter(const std::string& name) const {
        return std::any_of(parameters_.begin(), parameters_.end(), [&](const auto& one) { return name == one.name; });
    }
    // Each view and each parameter is that of a region.
    void check_names() const {
        if (known_views_.empty() && !(d_.views.empty() && d_.parameters.empty()))
            throw usage_error{std::string{d_.views.empty() ? "--parameter" : "--view"} +
                              " is for regions; an OBJ file has one view, by --from, and no parameters"};
        for (const std::string& name : d_.views)
            if (std::none_of(all_.begin(), all_.end(), [&](const auto& one) { return one->has_view(name); }))
                throw usage_error{"--view: there is no view '" + name + "'; known are " + known_views_};
        std::vector<std::string> names;
        for (const std::string& text : d_.parameters) {
            const named_range given{text};
            if (std::find(names.begin(), names.end(), given.name) != names.end())
                throw usage_error{"--parameter: `" + given.name + "` is given twice; a range holds for all bodies"};
            names.push_back(given.name);
            if (has_parameter(given.name)) continue;
            std::string known;
            for (const anatomy::parameter& one : parameters_)
                known += std::string{known.empty() ? "" : ", "} + one.name;
            throw usage_error{"--parameter: there is no parameter '" + given.name + "'; " +
                              (known.empty() ? "the regions that were chosen have none" : "known are " + known)};
        }
    }

    static std::vector<std::uint32_t> shuffled(std::size_t count, std::uint64_t seed) {
        std::vector<std::uint32_t> order(count);
        std::iota(order.begin(), order.end(), 0U);
        std::sort(order.begin(), order.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return hash_bits(seed, a) < hash_bits(seed, b); });
        return order;
    }

    // One whose parameter `side` is that of the cycle: `anatomy name seed=...` makes the same body.
    std::uint32_t seed_of_body(const spot& at) const {
        constexpr std::uint32_t seeds = 1'000'000'000;
        const std::uint64_t pair = hash_bits(hash_bits(~d_.seed, ~std::uint64_t{at.cycle / 2}), at.anatomy);
        const auto side = static_cast<float>((pair ^ at.cycle) & 1U);
        std::uint32_t seed = 0;
        for (std::uint64_t attempt = 0; attempt < 64; ++attempt) { // a range may leave one side
            seed = static_cast<std::uint32_t>(hash_bits(at.body, attempt) % seeds);
            const anatomy::values values = all_[at.anatomy]->drawn(seed);
            const auto found = values.find("side");
            if (found == values.end() || found->second == side) break;
        }
        return seed;
    }

    const description& d_;
    std::vector<std::unique_ptr<subject>> all_{};
    std::vector<anatomy::parameter> parameters_{};
    std::vector<std::string> view_names_{};
    std::vector<std::size_t> first_views_{};
    std::string known_views_{};
    bool has_file_ = false;
    label_names labels_{};
};

} // namespace dataset
#endif
