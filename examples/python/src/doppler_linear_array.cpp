#include "doppler_functions.hpp"

namespace insonify_python {

template struct scanner_doppler<linear_array, straight_lines>;
template struct scanner_doppler<linear_array, paths>;

void bind_doppler_linear_array(py::module_& module) { bind_doppler_functions<linear_array>(module); }

} // namespace insonify_python
