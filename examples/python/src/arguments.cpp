// What is wrong with the arguments of a call.
#include "bindings.hpp"
#include <algorithm>

namespace insonify_python {

namespace {

std::string names_of(const std::vector<argument>& arguments) {
    std::string all;
    for (const argument& one : arguments) all += (all.empty() ? "" : ", ") + std::string{one.name};
    return all;
}

std::string fault_of(const argument& one, py::handle given) {
    return "`" + std::string{one.name} + "` is of the type " +
           py::cast<std::string>(py::type::handle_of(given).attr("__name__")) + "; it must be " + one.kind;
}

std::string fault_of(std::size_t positional, const std::vector<argument>& arguments, const py::args& given,
                     const py::kwargs& named) {
    if (given.size() > positional)
        return "it takes " + std::to_string(positional) + " arguments without a name, but " +
               std::to_string(given.size()) + " were given; they are " + names_of(arguments);
    for (const auto& [key, value] : named) {
        const auto name = py::cast<std::string>(key);
        const auto found =
            std::find_if(arguments.begin(), arguments.end(), [&](const argument& one) { return one.name == name; });
        if (found == arguments.end()) return "there is no argument `" + name + "`; they are " + names_of(arguments);
        if (static_cast<std::size_t>(found - arguments.begin()) < given.size()) return "`" + name + "` is given twice";
    }
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const argument& one = arguments[i];
        const bool is_named = named.contains(one.name);
        if (i >= given.size() && !is_named) {
            if (one.is_optional) continue;
            return "`" + std::string{one.name} + "` is missing; it must be " + one.kind;
        }
        const py::object value = is_named ? py::object{named[one.name]} : py::object{given[i]};
        if (value.is_none() || !one.fits(value)) return fault_of(one, value);
    }
    return "these arguments do not go together";
}

} // namespace

void refuse_others(py::module_& module, const char* function, std::size_t positional, std::vector<argument> arguments) {
    module.def(
        function,
        [name = std::string{function}, positional,
         arguments = std::move(arguments)](const py::args& given, const py::kwargs& named) -> py::object {
            throw py::type_error(name + ": " + fault_of(positional, arguments, given, named));
        },
        "Says which argument does not fit.");
}

} // namespace insonify_python
