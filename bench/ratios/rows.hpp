#ifndef INSONIFY_BENCH_RATIOS_ROWS_HPP
#define INSONIFY_BENCH_RATIOS_ROWS_HPP

#include "../support/table.hpp"

/// Each file beside this one measures some rows of the table.
namespace bench {

void add_ray_rows(table& into);
void add_tree_rows(table& into);
void add_frame_rows(table& into);
void add_chain_rows(table& into);

} // namespace bench
#endif
