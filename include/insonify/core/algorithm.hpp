#ifndef INSONIFY_CORE_ALGORITHM_HPP
#define INSONIFY_CORE_ALGORITHM_HPP

/// std::sort and the like. libstdc++ has them in a header of their own; in its <algorithm> the ranges cost ten times more
/// time to compile.
#if __has_include(<bits/stl_algo.h>)
#include <bits/stl_algo.h>
#else
#include <algorithm>
#endif

#endif
