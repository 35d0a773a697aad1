# What including insonify costs a compiler, as a markdown table: seconds of user time (medians, what is compared taken in
# turns), and the size of each example's object.
#
#     cmake -P bench/compile_time.cmake
#     cmake -D CXX=clang++ -D ROUNDS=9 -P bench/compile_time.cmake
cmake_minimum_required(VERSION 3.25)

if(NOT DEFINED CXX)
    set(CXX c++)
endif()
if(NOT DEFINED ROUNDS)
    set(ROUNDS 5)
endif()
if(NOT DEFINED EXAMPLE_ROUNDS)
    set(EXAMPLE_ROUNDS 3)
endif()

cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH project)
string(RANDOM LENGTH 12 name)
set(out ${project}/build/compile_time_${name})
file(MAKE_DIRECTORY ${out})
function(give_up what)
    file(REMOVE_RECURSE ${out})
    message(FATAL_ERROR "${what}")
endfunction()

# Compiles once; appends the milliseconds to the list `times_<label>` of the caller.
function(compile label source)
    execute_process(
        COMMAND sh -c "\"$@\" && times" sh
            ${CXX} -std=c++20 ${ARGN} -I ${project}/include -c ${source} -o ${out}/${label}.o
        OUTPUT_VARIABLE times ERROR_VARIABLE fault RESULT_VARIABLE failed)
    if(failed)
        give_up("${label} was not compiled:\n${fault}")
    endif()
    # The shell's own user and system time, then those of its children: 0m2.340000s
    string(REGEX MATCH "\n([0-9]+)m([0-9]+)[.,]([0-9]+)s" _ "${times}")
    string(SUBSTRING "${CMAKE_MATCH_3}000" 0 3 thousandths)
    math(EXPR time "(${CMAKE_MATCH_1} * 60 + ${CMAKE_MATCH_2}) * 1000 + 1${thousandths} - 1000")
    set(times_${label} ${times_${label}} ${time} PARENT_SCOPE)
endfunction()

function(median_of times result)
    list(SORT times COMPARE NATURAL)
    list(LENGTH times count)
    math(EXPR middle "${count} / 2")
    list(GET times ${middle} median)
    set(${result} ${median} PARENT_SCOPE)
endfunction()

# Thousandths as a number with two digits behind the point.
function(decimal thousandths result)
    math(EXPR hundredths "(${thousandths} + 5) / 10 + 100000")
    string(REGEX REPLACE "^1(...)(..)$" "\\1.\\2" number ${hundredths})
    string(REGEX REPLACE "^00?" "" number ${number})
    set(${result} ${number} PARENT_SCOPE)
endfunction()

execute_process(COMMAND ${CXX} --version OUTPUT_VARIABLE compiler RESULT_VARIABLE failed)
if(failed)
    give_up("${CXX} does not run")
endif()
string(REGEX REPLACE "\n.*" "" compiler "${compiler}")
execute_process(COMMAND git -C ${project} rev-parse --short HEAD
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
cmake_host_system_information(RESULT machine QUERY PROCESSOR_DESCRIPTION)
string(TIMESTAMP date "%Y-%m-%d" UTC)
message("${compiler}; ${machine}; ${date}; commit ${commit}; medians of ${ROUNDS}, of the examples of ${EXAMPLE_ROUNDS}\n")

# The umbrella against what it cannot do without.
set(needed "#include <glm/glm.hpp>\n#include <thread>\n#include <vector>\n")
file(WRITE ${out}/base_simd.cpp "${needed}#include <experimental/simd>\n")
file(WRITE ${out}/base_scalar.cpp "${needed}")
file(WRITE ${out}/umbrella.cpp "#include <insonify/insonify.hpp>\n")
foreach(round RANGE 1 ${ROUNDS})
    compile(base_simd ${out}/base_simd.cpp)
    compile(umbrella_simd ${out}/umbrella.cpp)
    compile(base_scalar ${out}/base_scalar.cpp)
    compile(umbrella_scalar ${out}/umbrella.cpp -D INSONIFY_NO_SIMD)
endforeach()

message("| including | seconds | ratio | at most |\n|---|---|---|---|")
function(compare kind must base umbrella)
    median_of("${times_base_${kind}}" before)
    median_of("${times_umbrella_${kind}}" after)
    math(EXPR ratio "1000 * ${after} / ${before}")
    decimal(${before} before)
    decimal(${after} after)
    decimal(${ratio} ratio)
    message("| ${base} | ${before} | 1 | |\n| ${umbrella} | ${after} | **${ratio}** | ${must} |")
endfunction()
compare(simd 1.3 "glm, thread, vector, experimental/simd" "insonify")
compare(scalar 1.5 "glm, thread, vector" "insonify, INSONIFY_NO_SIMD")

message("\n| example, -O3 | seconds | object, KiB |\n|---|---|---|")
file(GLOB examples ${project}/examples/*.cpp)
foreach(round RANGE 1 ${EXAMPLE_ROUNDS})
    foreach(source IN LISTS examples)
        cmake_path(GET source STEM name)
        compile(${name} ${source} -O3 -D NDEBUG)
    endforeach()
endforeach()
foreach(source IN LISTS examples)
    cmake_path(GET source STEM name)
    median_of("${times_${name}}" time)
    decimal(${time} time)
    file(SIZE ${out}/${name}.o size)
    math(EXPR size "(${size} + 512) / 1024")
    message("| ${name} | ${time} | ${size} |")
endforeach()
file(REMOVE_RECURSE ${out})
