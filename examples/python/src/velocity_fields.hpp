#ifndef INSONIFY_PYTHON_VELOCITY_FIELDS_HPP
#define INSONIFY_PYTHON_VELOCITY_FIELDS_HPP

#include "tube_lines.hpp"
#include <variant>

namespace insonify_python {

/// Velocity fields of Python as one: their sum, as each is 0 in the objects of the others.
class velocity_fields {
  public:
    vec3 operator()(object_id object, vec3 point, float time) const {
        vec3 sum{0, 0, 0};
        for (const field& one : fields_)
            sum += std::visit([&](const auto* own) { return (*own)(object, point, time); }, one);
        return sum;
    }
    void check() const {
        for (const field& one : fields_) std::visit([](const auto* own) { own->check(); }, one);
    }
    /// @return  whether it is a velocity field
    bool add(py::handle one) {
        if (py::isinstance<poiseuille>(one))
            fields_.emplace_back(py::cast<const poiseuille*>(one));
        else if (py::isinstance<velocity_samples>(one))
            fields_.emplace_back(py::cast<const velocity_samples*>(one));
        else if (py::isinstance<line_flow>(one))
            fields_.emplace_back(static_cast<const tube_flow*>(py::cast<const line_flow*>(one)));
        else
            return false;
        return true;
    }

  private:
    using field = std::variant<const poiseuille*, const velocity_samples*, const tube_flow*>;
    std::vector<field> fields_{};
};

} // namespace insonify_python

namespace pybind11::detail {

/// A field, or a sequence of fields; they live as long as the call.
template <>
struct type_caster<insonify_python::velocity_fields> {
    PYBIND11_TYPE_CASTER(insonify_python::velocity_fields, const_name("velocity_field"));

    bool load(handle from, bool) {
        owners_ = isinstance<sequence>(from) ? tuple(reinterpret_borrow<sequence>(from)) : make_tuple(from);
        for (const handle one : owners_)
            if (!value.add(one)) return false;
        return true;
    }

  private:
    tuple owners_{};
};

} // namespace pybind11::detail
#endif
