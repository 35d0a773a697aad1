#ifndef INSONIFY_PYTHON_BINDINGS_HPP
#define INSONIFY_PYTHON_BINDINGS_HPP

#include <insonify/insonify.hpp>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace insonify_python {

namespace py = pybind11;
using namespace insonify;

/// Ctrl-C while the library works: the thread that called it looks for signals, at most every 50 ms.
class interruption {
  public:
    /// @throws py::error_already_set  KeyboardInterrupt, or what another handler of a signal raises
    void look() {
        if (std::this_thread::get_id() != caller_) return;
        const auto now = std::chrono::steady_clock::now();
        if (now - looked_ < std::chrono::milliseconds(50)) return;
        looked_ = now;
        const py::gil_scoped_acquire locked;
        if (PyErr_CheckSignals() == 0) return;
        raised_ = true;
        throw py::error_already_set();
    }
    bool raised() const { return raised_; }

  private:
    std::thread::id caller_ = std::this_thread::get_id();
    std::chrono::steady_clock::time_point looked_ = std::chrono::steady_clock::now();
    std::atomic<bool> raised_ = false;
};

/// A policy by its name, `"seq"`, `"par"`, `"unseq"` or `"par_unseq"`: whether it uses SIMD is part of the type.
template <bool Simd>
struct named_policy {
    bool parallel = false;
    std::uint32_t threads = 0; // 0: chosen
    interruption* signals = nullptr;

    template <class Body>
    friend void for_each_index(const named_policy& policy, std::size_t count, const Body& body) {
        const auto checked = [&](std::size_t i) {
            if (policy.signals->raised()) return; // the frame is abandoned
            policy.signals->look();
            body(i);
        };
        if (!policy.parallel)
            for_each_index(exec::seq, count, checked);
        else if (policy.threads == 0)
            for_each_index(exec::par, count, checked);
        else
            for_each_index(exec::par.threads(policy.threads), count, checked);
    }
    friend std::uint32_t max_threads(const named_policy& policy) {
        return policy.parallel ? exec::max_threads(exec::par.threads(policy.threads)) : 1;
    }
};

} // namespace insonify_python

template <>
inline constexpr bool insonify::exec::is_unsequenced_v<insonify_python::named_policy<true>> = true;

namespace insonify_python {

/// Calls `work` with the policy of a name, such as "par_unseq" or "par.threads(2)", without Python's lock: other Python
/// threads run meanwhile. Ctrl-C ends it.
/// @throws usage_error  for another name
template <class Work>
auto run(const std::string& policy, const Work& work) {
    std::string name = policy;
    std::uint32_t threads = 0;
    if (const std::size_t at = policy.find(".threads("); at != std::string::npos && policy.back() == ')') {
        const std::string digits = policy.substr(at + 9, policy.size() - at - 10);
        const bool whole =
            !digits.empty() && digits.size() < 5 && digits.find_first_not_of("0123456789") == std::string::npos;
        name = whole ? policy.substr(0, at) : "";
        threads = whole ? static_cast<std::uint32_t>(std::stoul(digits)) : 0;
        if (threads == 0 || (name != "par" && name != "par_unseq"))
            throw usage_error{"policy '" + policy +
                              "': threads are given as 'par.threads(2)' or 'par_unseq.threads(2)', "
                              "1 to 9999"};
    }
    const bool simd = name == "unseq" || name == "par_unseq", parallel = name == "par" || name == "par_unseq";
    if (!simd && !parallel && name != "seq")
        throw usage_error{"there is no policy '" + policy +
                          "'; known are seq, par, unseq, par_unseq, and "
                          "par.threads(2)"};
    interruption signals;
    const py::gil_scoped_release unlocked;
    return simd ? work(named_policy<true>{parallel, threads, &signals})
                : work(named_policy<false>{parallel, threads, &signals});
}

/// A view of numbers that `owner` owns: no copy, and `owner` lives as long as the array does.
template <class Number>
py::array array_over(Number* numbers, std::vector<py::ssize_t> shape, const py::object& owner) {
    return py::array(py::dtype::of<Number>(), std::move(shape), numbers, owner);
}

using float_array = py::array_t<float, py::array::c_style | py::array::forcecast>;
using index_array = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

/// Addresses and sizes of what `constant` made.
inline std::vector<std::pair<std::uintptr_t, std::size_t>>& constants() {
    static std::vector<std::pair<std::uintptr_t, std::size_t>> all;
    return all;
}
inline bool is_constant(const void* place) {
    const auto address = reinterpret_cast<std::uintptr_t>(place);
    for (const auto& [begin, size] : constants())
        if (address >= begin && address < begin + size) return true;
    return false;
}

/// Whether a member is a sequence, which Python sees as a tuple: a list would be a copy, whose changes are lost.
template <class Member>
inline constexpr bool is_sequence_v = false;
template <class Value>
inline constexpr bool is_sequence_v<std::vector<Value>> = true;
template <class Value, std::size_t Count>
inline constexpr bool is_sequence_v<std::array<Value, Count>> = true;

/// An array of points or vectors, one a row.
/// @param what  for the message, such as "tetrahedra: the nodes"
/// @throws usage_error  for an array of another shape
std::vector<vec3> rows_of(const float_array& numbers, const char* what);
/// The other way: copies, which refuse changes, as they would be lost.
float_array array_of_rows(const std::vector<vec3>& rows);

/// An argument of a function, for the sentence about a call that does not fit.
struct argument {
    const char* name;
    std::string kind; ///< what it must be, such as "a scene"
    bool (*fits)(py::handle given);
    bool is_optional = false;
};
/// Whether it is one of these types, or becomes one. @throws usage_error  where its array has a sentence of its own
template <class... Types>
bool fits(py::handle given) {
    return (py::detail::make_caster<Types>{}.load(given, true) || ...);
}
/// The last overload of a function: a sentence about the first wrong argument, instead of the signatures of all overloads.
/// @param positional  how many of them may be given without a name
void refuse_others(py::module_& module, const char* function, std::size_t positional, std::vector<argument> arguments);

/// A constant of the library as a Python object, not a copy: it and all that it contains refuse changes.
template <class Type>
py::object constant(const Type& value) {
    if (!is_constant(&value)) constants().push_back({reinterpret_cast<std::uintptr_t>(&value), sizeof value});
    return py::cast(&value, py::return_value_policy::reference);
}

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
        : name_{name}, class_{module, name, page}, members_{std::make_shared<member_list>()},
          frozen_{std::make_shared<bool>(false)} {
        class_.def(py::init([name = name_, members = members_](const py::kwargs& given) {
            Settings made{};
            const py::object self = py::cast(&made, py::return_value_policy::reference);
            for (const auto& [key, value] : given) {
                const auto member = py::cast<std::string>(key);
                require<py::type_error>(name, *members, member);
                assign(name, self, member, py::reinterpret_borrow<py::object>(value));
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
        class_.def("__setattr__", [name = name_, members = members_, frozen = frozen_](
                                      const py::object& self, const std::string& member, const py::object& value) {
            require<py::attribute_error>(name, *members, member);
            if (*frozen)
                throw py::attribute_error("a " + name + " cannot be changed; make another one, such as " + name + "(" +
                                          member + "=" + py::cast<std::string>(py::repr(value)) + ")");
            if (is_constant(py::cast<const Settings*>(self)))
                throw py::attribute_error("`" + member +
                                          "`: tissues and presets are constants; change a copy, such as "
                                          "mine = copy.copy(tissue.muscle)");
            assign(name, self, member, value);
        });
        bind_copies(class_);
        class_.def(py::pickle(
            [members = members_](const py::object& self) {
                py::dict state;
                for (const std::string& member : *members) state[py::str(member)] = self.attr(member.c_str());
                return state;
            },
            [name = name_](const py::dict& state) {
                Settings made{};
                const py::object self = py::cast(&made, py::return_value_policy::reference);
                for (const auto& [member, value] : state)
                    assign(name, self, py::cast<std::string>(member), py::reinterpret_borrow<py::object>(value));
                return made;
            }));
        if constexpr (std::equality_comparable<Settings>)
            class_.def("__eq__", [](const Settings& one, const Settings& other) { return one == other; });
    }

    /// A member that can be read and written. `Member` may be that of a base.
    template <class Member, class Base>
    settings_class& member(const char* name, Member Base::*place, const char* doc) {
        members_->emplace_back(name);
        if constexpr (is_sequence_v<Member>)
            class_.def_property(
                name, [place](const Settings& self) { return py::tuple(py::cast(self.*place)); },
                [place](Settings& self, const Member& given) { self.*place = given; }, doc);
        else
            class_.def_readwrite(name, place, doc);
        return *this;
    }
    /// A member that functions read and write.
    template <class Get, class Set>
    settings_class& property(const char* name, const Get& get, const Set& set, const char* doc) {
        members_->emplace_back(name);
        class_.def_property(name, get, set, doc);
        return *this;
    }
    /// Its members are given once, when it is made: for what stands in a sequence, of which Python has a copy.
    settings_class& frozen() {
        *frozen_ = true;
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
    using member_list = std::vector<std::string>;

    static void assign(const std::string& name, const py::object& self, const std::string& member,
                       const py::object& value) {
        try {
            py::module_::import("builtins").attr("object").attr("__setattr__")(self, member, value);
        } catch (py::error_already_set& error) {
            if (!error.matches(PyExc_TypeError)) throw;
            throw py::type_error("`" + member + "` of " + name + " cannot be " +
                                 py::cast<std::string>(py::repr(value)) + "; it is of the kind of " +
                                 py::cast<std::string>(py::repr(self.attr(member.c_str()))));
        }
    }

    template <class Error>
    static void require(const std::string& name, const member_list& members, const std::string& wanted) {
        std::string known;
        for (const std::string& member : members) {
            if (member == wanted) return;
            known += (known.empty() ? "" : ", ") + member;
        }
        throw Error(name + " has no setting '" + wanted + "'; it has " + known);
    }

    std::string name_;
    py::class_<Settings> class_;
    std::shared_ptr<member_list> members_;
    std::shared_ptr<bool> frozen_;
};

// The parts of the module, in the order in which they are bound.
void bind_errors(py::module_& module);
void bind_media(py::module_& module);
void bind_grids(py::module_& module);
void bind_scene(py::module_& module);
void bind_tubes(py::module_& module);
void bind_queries(py::module_& module);
void bind_obj(py::module_& module);
void bind_motion(py::module_& module);
void bind_flow(py::module_& module);
void bind_probes(py::module_& module);
void bind_settings(py::module_& module);
void bind_tracers(py::module_& module);
void bind_layers(py::module_& module);
void bind_stages(py::module_& module);
void bind_scanner(py::module_& module);
void bind_linear_array(py::module_& module);
void bind_convex_array(py::module_& module);
void bind_phased_array(py::module_& module);
void bind_radial_array(py::module_& module);
void bind_doppler_linear_array(py::module_& module);
void bind_doppler_convex_array(py::module_& module);
void bind_doppler_phased_array(py::module_& module);
void bind_doppler_radial_array(py::module_& module);
void bind_anatomy(py::module_& module);
void bind_arrays(py::module_& module);
void bind_channels(py::module_& module);
void bind_beamform(py::module_& module);

} // namespace insonify_python

namespace pybind11::detail {

/// Whole numbers. pybind11's own casters cut those of numpy that are not, such as np.float32(2.5).
template <class Number>
struct whole_number_caster {
    PYBIND11_TYPE_CASTER(Number, const_name("int"));

    bool load(handle from, bool) {
        if (!from || PyIndex_Check(from.ptr()) == 0) return false;
        const auto number = reinterpret_steal<object>(PyNumber_Index(from.ptr()));
        const auto read = [&](auto whole) {
            value = static_cast<Number>(whole);
            return PyErr_Occurred() == nullptr && std::in_range<Number>(whole);
        };
        const bool read_all = number && (std::is_signed_v<Number> ? read(PyLong_AsLongLong(number.ptr()))
                                                                  : read(PyLong_AsUnsignedLongLong(number.ptr())));
        PyErr_Clear();
        return read_all;
    }
    static handle cast(Number from, return_value_policy, handle) {
        return std::is_signed_v<Number> ? PyLong_FromLongLong(static_cast<long long>(from))
                                        : PyLong_FromUnsignedLongLong(static_cast<unsigned long long>(from));
    }
};
template <>
struct type_caster<int> : whole_number_caster<int> {};
template <>
struct type_caster<unsigned> : whole_number_caster<unsigned> {};
template <>
struct type_caster<long> : whole_number_caster<long> {};
template <>
struct type_caster<unsigned long> : whole_number_caster<unsigned long> {};
template <>
struct type_caster<long long> : whole_number_caster<long long> {};
template <>
struct type_caster<unsigned long long> : whole_number_caster<unsigned long long> {};

/// Whether it is a complex number of numpy; Python's own do not pass for real ones.
inline bool is_complex_number(handle from) {
    if (PyFloat_Check(from.ptr()) || PyLong_Check(from.ptr())) return false;
    const object type = getattr(from, "dtype", none());
    return !type.is_none() && getattr(type, "kind", none()).equal(str("c"));
}
/// Real numbers. pybind11's own casters drop the imaginary part of numpy's complex ones.
template <class Number>
struct real_number_caster {
    PYBIND11_TYPE_CASTER(Number, const_name("float"));

    bool load(handle from, bool) {
        if (!from || is_complex_number(from)) return false;
        const double number = PyFloat_AsDouble(from.ptr());
        const bool read = PyErr_Occurred() == nullptr;
        PyErr_Clear();
        value = static_cast<Number>(number);
        return read;
    }
    static handle cast(Number from, return_value_policy, handle) {
        return PyFloat_FromDouble(static_cast<double>(from));
    }
};
template <>
struct type_caster<float> : real_number_caster<float> {};
template <>
struct type_caster<double> : real_number_caster<double> {};

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
            const object number = numbers[int_(i)];
            if (!one.load(number, true)) return false;
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

/// Arrays of real numbers: complex ones would lose their imaginary part.
template <>
struct type_caster<insonify_python::float_array> {
    PYBIND11_TYPE_CASTER(insonify_python::float_array, const_name("numpy.ndarray"));

    /// @throws usage_error  for complex numbers
    bool load(handle from, bool) {
        const array given = array::ensure(from);
        if (!given) return false;
        const char kind = given.dtype().kind();
        if (kind == 'c') throw insonify::usage_error{"an array must be of real numbers, not of complex ones"};
        if (kind != 'f' && kind != 'i' && kind != 'u') return false;
        value = insonify_python::float_array(given);
        return true;
    }
    static handle cast(const insonify_python::float_array& from, return_value_policy, handle) { return from.inc_ref(); }
};
/// Arrays of whole numbers; those of floating point must be whole, or would be cut.
template <>
struct type_caster<insonify_python::index_array> {
    PYBIND11_TYPE_CASTER(insonify_python::index_array, const_name("numpy.ndarray"));

    /// @throws usage_error  for numbers that are not whole
    bool load(handle from, bool) {
        const array given = array::ensure(from);
        if (!given) return false;
        const char kind = given.dtype().kind();
        if (kind != 'f' && kind != 'i' && kind != 'u') return false;
        const auto numpy = module_::import("numpy");
        if (kind == 'f' && !pybind11::cast<bool>(numpy.attr("array_equal")(given, numpy.attr("rint")(given))))
            throw insonify::usage_error{"an array of indices must be of whole numbers, not of numbers such as 2.5"};
        value = insonify_python::index_array(given);
        return true;
    }
    static handle cast(const insonify_python::index_array& from, return_value_policy, handle) { return from.inc_ref(); }
};

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
