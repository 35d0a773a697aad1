#include "probe_functions.hpp"

namespace insonify_python {

void bind_phased_array(py::module_& module) { bind_probe_functions<phased_array>(module); }

} // namespace insonify_python
