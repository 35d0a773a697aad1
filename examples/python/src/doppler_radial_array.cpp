#include "doppler_functions.hpp"

namespace insonify_python {

template struct scanner_doppler<radial_array, straight_lines>;
template struct scanner_doppler<radial_array, paths>;

void bind_doppler_radial_array(py::module_& module) { bind_doppler_functions<radial_array>(module); }

} // namespace insonify_python
