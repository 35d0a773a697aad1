#ifndef INSONIFY_CORE_ALGORITHM_HPP
#define INSONIFY_CORE_ALGORITHM_HPP

#if __has_include(<bits/stl_algo.h>)
#include <bits/stl_algo.h> // libstdc++: std::sort and its like alone; three quarters of <algorithm> are its ranges
#else
#include <algorithm>
#endif

#endif
