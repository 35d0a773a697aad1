#ifndef INSONIFY_TESTS_IO_OBJ_ERRORS_HPP
#define INSONIFY_TESTS_IO_OBJ_ERRORS_HPP

#include <insonify/core/error.hpp>
#include <insonify/io/obj.hpp>
#include "temporary_folder.hpp"
#include <doctest/doctest.h>
#include <string>

/// OBJ files of the tests, and the errors that they cause.
namespace obj_test {

using namespace insonify;

/// A tetrahedron of volume 1/6, its faces outward.
inline const std::string tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

inline const std::string its_faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

template <class Error, class Call>
std::string sentence(const Call& call) {
    try {
        call();
    } catch (const Error& e) {
        return e.what();
    }
    return "no such error";
}

/// What load_obj says about a file, after its path.
inline std::string complaint(const std::string& text) {
    const temporary_folder folder;
    const std::string path = folder.write("a.obj", text);
    const std::string said = sentence<io_error>([&] { load_obj(path, {.unit = 1_m}); });
    return said.starts_with(path) ? said.substr(path.size()) : said;
}

/// What load_obj_scene says about a file beside a library a.mtl, with the folder left out.
inline std::string complaint(const std::string& text, const std::string& library) {
    const temporary_folder folder;
    const std::string path = folder.write("a.obj", text);
    if (!library.empty()) folder.write("a.mtl", library);
    std::string said = sentence<io_error>([&] { load_obj_scene(path, {.unit = 1_m}); });
    const std::string place = folder.path("");
    for (std::size_t i = said.find(place); i != std::string::npos; i = said.find(place)) said.erase(i, place.size());
    return said;
}

inline bool has(const std::string& text, const std::string& part) {
    INFO(text << " <- " << part);
    CHECK(text.find(part) != std::string::npos);
    return text.find(part) != std::string::npos;
}

} // namespace obj_test

#endif
