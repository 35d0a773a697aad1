# The pages that a reader meets: `pages`, relative to `project`, in the order of reading.
cmake_path(SET project NORMALIZE ${CMAKE_CURRENT_LIST_DIR}/../../include/..)
string(REGEX REPLACE "/$" "" project ${project})
set(pages README.md include/insonify/README.md)
foreach(folder IN ITEMS core geometry execution bvh tissue acoustics probe scene tracing signal image channels doppler motion paper io)
    list(APPEND pages include/insonify/${folder}/README.md)
endforeach()
list(APPEND pages
    include/insonify/scanner.md
    include/insonify/extending.md include/insonify/acoustics/extending.md
    include/insonify/errors.md examples/README.md bench/README.md CONTRIBUTING.md)
