#ifndef INSONIFY_BENCH_RATIOS_ROWS_HPP
#define INSONIFY_BENCH_RATIOS_ROWS_HPP

#include "../support/table.hpp"
#include <map>

/// Each file beside this one measures some rows of the table, and says so by a `rows` of its own: what needs a peer that
/// is not installed is not compiled, and nobody misses it.
namespace bench {

struct rows {
    rows(int place, void (*measure)(table&)) { all().emplace(place, measure); }

    /// In the order of the table.
    static std::map<int, void (*)(table&)>& all() {
        static std::map<int, void (*)(table&)> found;
        return found;
    }
};

} // namespace bench
#endif
