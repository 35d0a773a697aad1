#include "doppler_functions.hpp"

namespace insonify_python {

template struct scanner_doppler<convex_array, straight_lines>;
template struct scanner_doppler<convex_array, paths>;

void bind_doppler_convex_array(py::module_& module) { bind_doppler_functions<convex_array>(module); }

} // namespace insonify_python
