#ifndef INSONIFY_TRACING_FIND_CROSSING_LISTS_HPP
#define INSONIFY_TRACING_FIND_CROSSING_LISTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/large_array.hpp>
#include <insonify/core/view.hpp>
#include <insonify/scene/crossings.hpp>
#include <algorithm>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::detail {

/// Lists in one flat array, by a counting sort: what each list is to hold is counted, then added. Keeps its memory.
template <class T>
class counted_lists {
  public:
    /// Begins to count for so many lists.
    void clear(std::size_t lists) {
        ends_.resize(lists + 1);
        std::fill(ends_.begin(), ends_.end(), 0);
    }
    void count(std::size_t list) { ++ends_[list + 1]; }
    /// After the last `count`, before the first `add`.
    void make_room() {
        for (std::size_t list = 1; list < ends_.size(); ++list) ends_[list] += ends_[list - 1];
        items_.resize(ends_[ends_.size() - 1]);
    }
    /// The end of each list's predecessor is where its own items begin; it moves on to its own end as they come in.
    void add(std::size_t list, const T& item) { items_[ends_[list]++] = item; }

    /// One list, after the last `add`.
    view<const T> operator[](std::size_t list) const {
        return {items_.data() + begin(list), ends_[list] - begin(list)};
    }
    /// The same, to be sorted.
    view<T> editable(std::size_t list) { return {items_.data() + begin(list), ends_[list] - begin(list)}; }
    /// Items in all lists.
    std::size_t size() const { return items_.size(); }

  private:
    std::size_t begin(std::size_t list) const { return list == 0 ? 0 : ends_[list - 1]; }

    large_array<std::uint32_t> ends_; // in `items_`
    large_array<T> items_;
};

/// The crossings of many lines with segments of slices, by line. Those behind the origin of their line have negative distances.
using crossing_lists = counted_lists<crossing>;

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
