# INSONIFY_ABI differs wherever flags select different instructions:
#     cmake -D CXX=g++ -P tests/instruction_sets/names.cmake
cmake_minimum_required(VERSION 3.25)

foreach(simd IN ITEMS "" -DINSONIFY_NO_SIMD)
    foreach(flags IN ITEMS "" -msse4.1 -mavx "-mavx -mfma" -mavx2 "-mavx2 -mfma" -mavx512f "-mavx512f -mfma"
            "-mavx512f -mavx512vl" "-mavx512f -mavx512vl -mfma")
        separate_arguments(command UNIX_COMMAND "-std=c++20 -march=x86-64 ${flags} ${simd} -E -x c++")
        execute_process(COMMAND ${CXX} ${command} -dM /dev/null
            OUTPUT_VARIABLE macros COMMAND_ERROR_IS_FATAL ANY) # equal where one flag implies the other
        execute_process(COMMAND ${CXX} ${command} -P -I ${CMAKE_CURRENT_LIST_DIR}/../../include
                ${CMAKE_CURRENT_LIST_DIR}/name.hpp
            OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
        string(REGEX REPLACE ".*abi_is ([a-z0-9_]+).*" "\\1" name "${text}")
        message(STATUS "${name}: ${flags} ${simd}")
        if(DEFINED macros_of_${name} AND NOT macros_of_${name} STREQUAL macros)
            message(SEND_ERROR "${name} also names other flags than ${flags} ${simd}")
        endif()
        set(macros_of_${name} "${macros}")
    endforeach()
endforeach()
