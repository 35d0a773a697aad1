#include "doppler_functions.hpp"

namespace insonify_python {

template struct scanner_doppler<phased_array, straight_lines>;
template struct scanner_doppler<phased_array, paths>;

void bind_doppler_phased_array(py::module_& module) { bind_doppler_functions<phased_array>(module); }

} // namespace insonify_python
