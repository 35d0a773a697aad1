# For cross compilers, whose own headers /usr/include would hide: the packages' headers in a folder of their own.
#     cmake -D CMAKE_PROJECT_INCLUDE=.ci/headers.cmake ...
set(headers ${PROJECT_BINARY_DIR}/headers)
file(MAKE_DIRECTORY ${headers})
foreach(name IN ITEMS glm doctest stb tiny_obj_loader.h CLI)
    file(CREATE_LINK /usr/include/${name} ${headers}/${name} SYMBOLIC)
endforeach()
foreach(target IN ITEMS glm::glm doctest::doctest)
    add_library(${target} INTERFACE IMPORTED GLOBAL)
    target_include_directories(${target} INTERFACE ${headers})
endforeach()
set(INSONIFY_TINYOBJLOADER_DIR ${headers})
set(INSONIFY_STB_DIR ${headers})
set(INSONIFY_CLI11_DIR ${headers})
