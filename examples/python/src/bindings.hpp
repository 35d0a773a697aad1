#ifndef INSONIFY_PYTHON_BINDINGS_HPP
#define INSONIFY_PYTHON_BINDINGS_HPP

#include <insonify/insonify.hpp>
#include <initializer_list>
#include <memory>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>
#include <utility>
#include <vector>

namespace insonify_python {

namespace py = pybind11;
using namespace insonify;

/// A policy by its name, `"seq"`, `"par"`, `"unseq"` or `"par_unseq"`: whether it uses SIMD is part of the type.
template <bool Simd>
struct named_policy {
    bool parallel = false;

    template <class Body>
    friend void for_each_index(const named_policy& policy, std::size_t count, const Body& body) {
        if (policy.parallel)
            for_each_index(exec::par, count, body);
        else
            for_each_index(exec::seq, count, body);
    }
};

} // namespace insonify_python

template <>
inline constexpr bool insonify::exec::is_unsequenced_v<insonify_python::named_policy<true>> = true;

namespace insonify_python {

/// Calls `work` with the policy of a name, without Python's lock: other Python threads run meanwhile.
/// @throws usage_error  for another name
template <class Work>
auto run(const std::string& policy, const Work& work) {
    const bool simd = policy == "unseq" || policy == "par_unseq", parallel = policy == "par" || policy == "par_unseq";
    if (!simd && !parallel && policy != "seq")
        throw usage_error{"there is no policy '" + policy + "'; known are seq, par, unseq, par_unseq"};
    const py::gil_scoped_release unlocked;
    return simd ? work(named_policy<true>{parallel}) : work(named_policy<false>{parallel});
}

/// A view of numbers that `owner` owns: no copy, and `owner` lives as long as the array does.
template <class Number>
py::array array_over(Number* numbers, std::vector<py::ssize_t> shape, const py::object& owner) {
    return py::array(py::dtype::of<Number>(), std::move(shape), numbers, owner);
}

using float_array = py::array_t<float, py::array::c_style | py::array::forcecast>;
using index_array = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

/// An array of points or vectors, one a row.
/// @param what  for the message, such as "tetrahedra: the nodes"
/// @throws usage_error  for an array of another shape
std::vector<vec3> rows_of(const float_array& numbers, const char* what);

/// `copy.copy` and `copy.deepcopy` are the copy of C++.
template <class Type, class... Options>
void bind_copies(py::class_<Type, Options...>& type) {
    type.def("__copy__", [](const Type& self) { return Type(self); });
    type.def(
        "__deepcopy__", [](const Type& self, const py::dict&) { return Type(self); }, py::arg("memo"));
}

/// A struct of settings as a Python class: constructed by keywords, printed and compared by its members.
template <class Settings>
class settings_class {
  public:
    settings_class(py::module_& module, const char* name, const char* page)
        : name_{name}, class_{module, name, page}, members_{std::make_shared<std::vector<std::string>>()} {
        class_.def(py::init([name = name_, members = members_](const py::kwargs& given) {
            Settings made{};
            const py::object self = py::cast(&made, py::return_value_policy::reference);
            for (const auto& [key, value] : given) {
                require<py::type_error>(name, *members, py::cast<std::string>(key));
                py::setattr(self, key, value);
            }
            return made;
        }));
        class_.def("__repr__", [name = name_, members = members_](const py::object& self) {
            std::string text = name + "(";
            for (const std::string& member : *members)
                text += (text.back() == '(' ? "" : ", ") + member + "=" +
                        py::cast<std::string>(py::repr(self.attr(member.c_str())));
            return text + ")";
        });
        class_.def("__setattr__", [name = name_, members = members_](const py::object& self, const std::string& member,
                                                                     const py::object& value) {
            require<py::attribute_error>(name, *members, member);
            try {
                py::module_::import("builtins").attr("object").attr("__setattr__")(self, member, value);
            } catch (py::error_already_set& error) {
                if (!error.matches(PyExc_TypeError)) throw;
                throw py::type_error("`" + member + "` of " + name + " cannot be " +
                                     py::cast<std::string>(py::repr(value)) + "; it is of the kind of " +
                                     py::cast<std::string>(py::repr(self.attr(member.c_str()))));
            }
        });
        bind_copies(class_);
        class_.def(py::pickle(
            [members = members_](const py::object& self) {
                py::dict state;
                for (const std::string& member : *members) state[py::str(member)] = self.attr(member.c_str());
                return state;
            },
            [](const py::dict& state) {
                Settings made{};
                const py::object self = py::cast(&made, py::return_value_policy::reference);
                for (const auto& [member, value] : state) py::setattr(self, member, value);
                return made;
            }));
        if constexpr (std::equality_comparable<Settings>)
            class_.def("__eq__", [](const Settings& one, const Settings& other) { return one == other; });
    }

    /// A member that can be read and written. `Member` may be that of a base.
    template <class Member, class Base>
    settings_class& member(const char* name, Member Base::*place, const char* doc) {
        members_->emplace_back(name);
        class_.def_readwrite(name, place, doc);
        return *this;
    }
    /// A member of an enumeration, as one of a few words.
    template <class Choice, class Base>
    settings_class& choice(const char* name, Choice Base::*place, std::vector<std::pair<std::string, Choice>> words,
                           const char* doc) {
        members_->emplace_back(name);
        class_.def_property(
            name,
            [place, words](const Settings& self) {
                for (const auto& [word, value] : words)
                    if (value == self.*place) return word;
                return std::string{};
            },
            [place, words, name = std::string{name}](Settings& self, const std::string& wanted) {
                std::string known;
                for (const auto& [word, value] : words) {
                    if (word == wanted) {
                        self.*place = value;
                        return;
                    }
                    known += (known.empty() ? "" : ", ") + word;
                }
                throw usage_error{"`" + name + "` cannot be '" + wanted + "'; it is one of " + known};
            },
            doc);
        return *this;
    }

    py::class_<Settings>& type() { return class_; }

  private:
    template <class Error>
    static void require(const std::string& name, const std::vector<std::string>& members, const std::string& wanted) {
        std::string known;
        for (const std::string& member : members) {
            if (member == wanted) return;
            known += (known.empty() ? "" : ", ") + member;
        }
        throw Error(name + " has no setting '" + wanted + "'; it has " + known);
    }

    std::string name_;
    py::class_<Settings> class_;
    std::shared_ptr<std::vector<std::string>> members_;
};

// The parts of the module, in the order in which they are bound.
void bind_errors(py::module_& module);
void bind_media(py::module_& module);
void bind_grids(py::module_& module);
void bind_scene(py::module_& module);
void bind_queries(py::module_& module);
void bind_obj(py::module_& module);
void bind_motion(py::module_& module);
void bind_flow(py::module_& module);
void bind_probes(py::module_& module);
void bind_settings(py::module_& module);
void bind_stages(py::module_& module);
void bind_scanner(py::module_& module);
void bind_linear_array(py::module_& module);
void bind_convex_array(py::module_& module);
void bind_phased_array(py::module_& module);
void bind_doppler_linear_array(py::module_& module);
void bind_doppler_convex_array(py::module_& module);
void bind_doppler_phased_array(py::module_& module);

} // namespace insonify_python

namespace pybind11::detail {

/// GLM's vectors as tuples; taken from any sequence of as many numbers, such as a numpy array.
template <class Vector, class Number, int Length>
struct vector_caster {
    PYBIND11_TYPE_CASTER(Vector, const_name("tuple"));

    bool load(handle from, bool) {
        if (!isinstance<sequence>(from) && !isinstance<array>(from)) return false;
        const auto numbers = reinterpret_borrow<object>(from);
        if (len(numbers) != Length) return false;
        for (int i = 0; i < Length; ++i) {
            make_caster<Number> one;
            if (!one.load(object(numbers[int_(i)]), true)) return false;
            value[i] = cast_op<Number>(one);
        }
        return true;
    }
    static handle cast(const Vector& from, return_value_policy, handle) {
        tuple made(Length);
        for (int i = 0; i < Length; ++i) made[static_cast<std::size_t>(i)] = pybind11::cast(from[i]);
        return made.release();
    }
};
template <>
struct type_caster<glm::vec2> : vector_caster<glm::vec2, float, 2> {};
template <>
struct type_caster<glm::vec3> : vector_caster<glm::vec3, float, 3> {};
template <>
struct type_caster<glm::uvec2> : vector_caster<glm::uvec2, std::uint32_t, 2> {};
template <>
struct type_caster<glm::uvec3> : vector_caster<glm::uvec3, std::uint32_t, 3> {};

/// Ids of objects as whole numbers, which are their labels.
template <>
struct type_caster<insonify::object_id> {
    PYBIND11_TYPE_CASTER(insonify::object_id, const_name("int"));

    bool load(handle from, bool convert) {
        make_caster<std::uint32_t> number;
        if (!number.load(from, convert)) return false;
        value = insonify::object_id{cast_op<std::uint32_t>(number)};
        return true;
    }
    static handle cast(insonify::object_id from, return_value_policy, handle) {
        return pybind11::cast(static_cast<std::uint32_t>(from)).release();
    }
};

} // namespace pybind11::detail
#endif
