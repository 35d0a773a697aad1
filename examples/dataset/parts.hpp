#ifndef INSONIFY_DATASET_PARTS_HPP
#define INSONIFY_DATASET_PARTS_HPP

#include "hdf5_part.hpp"
#include "png_part.hpp"
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>

namespace dataset {

struct part_range {
    std::uint32_t first = 0, last = 0; ///< samples, from the first up to, but without, the last
};

/// The samples are stored in parts of equal size. A part is written under another name and then renamed: where it is, it is
/// complete, unless a disk failed. Its content depends on the description and its number alone.
class parts {
  public:
    /// @param identity  what the samples of this dataset have in common, as text
    parts(const description& d, const anatomies& all, const std::string& identity)
        : d_{d}, all_{all}, identity_{identity}, layout_{d, all} {}

    const layout& arrays() const { return layout_; }
    std::uint32_t count() const { return count_of(d_.samples, d_.part); }
    static std::uint32_t count_of(std::uint32_t samples, std::uint32_t each) {
        return samples / each + (samples % each != 0 ? 1 : 0);
    }
    part_range samples_of(std::uint32_t part) const {
        return {part * d_.part,
                static_cast<std::uint32_t>(std::min<std::uint64_t>(d_.samples, (std::uint64_t{part} + 1) * d_.part))};
    }
    std::string name(std::uint32_t part) const {
        char name[32];
        std::snprintf(name, sizeof name, "part-%06u%s", part, is_png() ? "" : ".h5");
        return name;
    }
    bool is_png() const { return d_.format == "png"; }

    /// What is wrong with a part that is there; empty: nothing. One thread at a time.
    std::string fault(std::uint32_t part) const {
        const auto [first, last] = samples_of(part);
        return is_png() ? fault_of_files(path(part), d_, first, last)
                        : fault_of_hdf5(path(part).string(), identity_, last - first);
    }
    /// Calls visit(sample) with the first samples that are stored. One thread at a time.
    /// @param count  of them
    template <class Visit>
    void read(std::uint32_t count, const Visit& visit) const {
        for (std::uint32_t part = 0; part * std::uint64_t{d_.part} < count; ++part) {
            const auto [first, last] = samples_of(part);
            const part_range wanted{first, std::min(last, count)};
            if (is_png())
                read_files(path(part), layout_, wanted.first, wanted.last, visit);
            else
                read_hdf5(path(part).string(), layout_, wanted.last - wanted.first, visit);
        }
    }
    bool exists(std::uint32_t part) const { return std::filesystem::exists(path(part)); }

    /// Makes a sample ready to be written, and smaller. Any thread.
    void pack(record& one) const {
        if (!is_png()) layout_.pack(one);
    }
    /// Writes a part under another name, then renames it. One thread at a time.
    /// @param writer  a number of the process, for that name
    void write(std::uint32_t part, const std::vector<record>& records, int writer) const {
        const std::filesystem::path done = path(part), draft = done.string() + ".draft" + std::to_string(writer);
        try {
            if (is_png())
                write_files(draft, layout_, all_, records, d_.size);
            else
                write_file(draft, hdf5_part(d_, layout_, all_, identity_, records));
            if (is_png()) std::filesystem::remove_all(done); // it was damaged, or had fewer samples
            std::filesystem::rename(draft, done);
        } catch (...) {
            std::error_code ignored;
            std::filesystem::remove_all(draft, ignored);
            throw;
        }
    }
    /// Writes the file that stands for all parts.
    void write_whole() const {
        std::vector<hdf5_file::source> sources;
        for (std::uint32_t part = 0; part < count(); ++part) {
            const auto [first, last] = samples_of(part);
            sources.push_back({name(part), last - first});
        }
        replace_file(std::filesystem::path{d_.output} / "dataset.h5",
                     hdf5_whole(d_, layout_, all_, identity_, sources));
    }
    /// Bytes of a part with these samples.
    std::size_t size_of(std::vector<record> records) const {
        for (record& one : records) layout_.pack(one);
        return hdf5_part(d_, layout_, all_, identity_, records).size();
    }

    /// Removes what a killed process left half written.
    void remove_drafts() const {
        std::vector<std::filesystem::path> drafts;
        for (const auto& entry : std::filesystem::directory_iterator{d_.output})
            if (is_draft(entry.path().filename().string())) drafts.push_back(entry.path());
        for (const auto& draft : drafts) std::filesystem::remove_all(draft);
    }

  private:
    std::filesystem::path path(std::uint32_t part) const { return std::filesystem::path{d_.output} / name(part); }
    // part-000003.h5.draft0, part-000003.draft0, dataset.h5.draft, description.ini.draft: nothing else in the folder is ours.
    static bool is_draft(const std::string& name) {
        if (name == "dataset.h5.draft" || name == "description.ini.draft") return true;
        const std::size_t mark = name.rfind(".draft");
        if (name.compare(0, 5, "part-") != 0 || mark == std::string::npos) return false;
        std::string stem = name.substr(5, mark - 5), writer = name.substr(mark + 6);
        if (stem.size() > 3 && stem.compare(stem.size() - 3, 3, ".h5") == 0) stem.resize(stem.size() - 3);
        const auto is_number = [](const std::string& text) {
            return !text.empty() &&
                   std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
        };
        return is_number(stem) && is_number(writer);
    }

    const description& d_;
    const anatomies& all_;
    std::string identity_;
    layout layout_;
};

} // namespace dataset
#endif
