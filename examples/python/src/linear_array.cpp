#include "probe_functions.hpp"

namespace insonify_python {

void bind_linear_array(py::module_& module) { bind_probe_functions<linear_array>(module); }

} // namespace insonify_python
