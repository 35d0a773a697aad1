#ifndef INSONIFY_DATASET_DRAWING_HPP
#define INSONIFY_DATASET_DRAWING_HPP

#include "parts.hpp"
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>

namespace dataset {

/// Draws the samples of parts with several threads. Each takes the next samples when it is free, those of one body at a time,
/// from the next part where this one has none left, and writes a part where its sample was the last of it: no thread waits
/// for a part to be complete.
class drawing {
  public:
    /// @param writer  number of this process
    drawing(const description& d, const anatomies& all, const parts& files, int writer)
        : d_{d}, all_{all}, files_{files}, writer_{writer} {}

    /// Draws until no part is left.
    /// @param next     returns the number of the next part that no process has taken; called by one thread at a time
    /// @param written  written(part, drawn) is called where a part is in its place; `drawn` samples, 0 where it was there
    template <class Next, class Written>
    void run(std::uint32_t threads, const Next& next, const Written& written) {
        for_each_index(exec::par.threads(threads), threads, [&](std::size_t) {
            try {
                renderer draw{d_, all_};
                while (const std::optional<run_of_samples> taken = take(next, written))
                    for (std::uint32_t i = taken->first; i < taken->last; ++i) {
                        record& one = taken->part->records[i];
                        one = draw(taken->part->first + i);
                        files_.pack(one);
                        if (--taken->part->left == 0) write(*taken->part, written);
                    }
            } catch (...) {
                stopped_ = true; // the other threads finish their samples
                throw;
            }
        });
    }

  private:
    struct open_part {
        std::uint32_t number = 0, first = 0, taken = 0;
        std::vector<record> records{};
        std::atomic<std::size_t> left{0}; ///< to be drawn
    };
    struct run_of_samples {
        std::shared_ptr<open_part> part;
        std::uint32_t first = 0, last = 0; ///< indices in the part, from the first up to, but without, the last
    };

    // The next samples that have one body; none at the end.
    template <class Next, class Written>
    std::optional<run_of_samples> take(const Next& next, const Written& written) {
        const std::lock_guard lock{taking_};
        while (!stopped_ && (!current_ || current_->taken == current_->records.size())) {
            const std::uint32_t part = next();
            if (part >= files_.count()) stopped_ = true;
            if (stopped_) break;
            if (files_.exists(part)) { // of a run that was stopped, or had fewer samples
                const std::lock_guard reading{writing_};
                if (files_.fault(part).empty()) {
                    written(part, 0U);
                    continue;
                }
            }
            const auto [first, last] = files_.samples_of(part);
            current_ = std::make_shared<open_part>();
            current_->number = part;
            current_->first = first;
            current_->records.resize(last - first);
            current_->left = last - first;
        }
        if (stopped_) return std::nullopt;
        const std::uint32_t first = current_->taken++;
        const spot body = all_.place_of(current_->first + first);
        while (current_->taken < current_->records.size() &&
               anatomies::share_body(body, all_.place_of(current_->first + current_->taken)))
            ++current_->taken;
        return run_of_samples{current_, first, current_->taken};
    }

    // HDF5 is not for two threads at once.
    template <class Written>
    void write(const open_part& part, const Written& written) {
        const std::lock_guard lock{writing_};
        files_.write(part.number, part.records, writer_);
        written(part.number, static_cast<std::uint32_t>(part.records.size()));
    }

    const description& d_;
    const anatomies& all_;
    const parts& files_;
    int writer_;
    std::shared_ptr<open_part> current_{};
    std::mutex taking_{}, writing_{};
    std::atomic<bool> stopped_{false};
};

} // namespace dataset
#endif
