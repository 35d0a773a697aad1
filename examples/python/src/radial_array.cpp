#include "probe_functions.hpp"

namespace insonify_python {

void bind_radial_array(py::module_& module) { bind_probe_functions<radial_array>(module); }

} // namespace insonify_python
