# Compile time as a markdown table: user time in seconds for the ten lines of the README, with INSONIFY_IMPLEMENTATION and
# without, and for each example; and the size of the example's object file. All values are medians.
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

# Compiles once and appends the user time in milliseconds to the caller's list `times_<label>`.
function(compile label source)
    execute_process(
        COMMAND sh -c "\"$@\" && times" sh
            ${CXX} -std=c++20 ${ARGN} -I ${project}/include -c ${source} -o ${out}/${label}.o
        OUTPUT_VARIABLE times ERROR_VARIABLE fault RESULT_VARIABLE failed)
    if(failed)
        give_up("${label} was not compiled:\n${fault}")
    endif()
    # `times` prints the user and system time of the shell, and on the second line those of its children.
    string(REGEX MATCH "\n([0-9]+)m([0-9]+)[.,]([0-9]+)s" user "${times}")
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

# Thousandths as a decimal number with two digits after the point.
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

# The first program of the README.
file(READ ${project}/README.md program)
string(REGEX REPLACE "^.*\n```cpp\n(#define INSONIFY_IMPLEMENTATION[^\n]*\n)" "\\1" program "${program}")
string(REGEX REPLACE "\n```\n.*$" "\n" program "${program}")
if(NOT program MATCHES "^#define INSONIFY_IMPLEMENTATION.*int main\\(.*b_mode")
    give_up("README.md has no program that begins with INSONIFY_IMPLEMENTATION")
endif()
file(WRITE ${out}/with.cpp "${program}")
string(FIND "${program}" "\n" line_end)
string(SUBSTRING "${program}" ${line_end} -1 program)
file(WRITE ${out}/without.cpp "${program}")
foreach(round RANGE 1 ${ROUNDS})
    compile(with ${out}/with.cpp -O2)
    compile(without ${out}/without.cpp -O2)
endforeach()

message("| the ten lines of the README, -O2 | user time, s | must be below |\n|---|---|---|")
function(add_row label what must)
    median_of("${times_${label}}" time)
    decimal(${time} time)
    message("| ${what} | ${time} | ${must} |")
endfunction()
add_row(with "with INSONIFY_IMPLEMENTATION" 13)
add_row(without "without" 7)

message("\n| example, -O3 | user time, s | object, KiB |\n|---|---|---|")
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
