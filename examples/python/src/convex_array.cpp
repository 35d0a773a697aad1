#include "probe_functions.hpp"

namespace insonify_python {

void bind_convex_array(py::module_& module) { bind_probe_functions<convex_array>(module); }

} // namespace insonify_python
