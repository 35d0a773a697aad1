# A build without a build type is a Release build where insonify is the top-level project, and is left alone where it is a
# subproject. A build type that is given stays.
#     cmake -D INSONIFY=<its source tree> -D OUT=<folder> -D GENERATOR=<single-configuration generator> -P build_type.cmake
cmake_minimum_required(VERSION 3.25)
unset(ENV{CMAKE_BUILD_TYPE})

function(check_build_type what expected source)
    set(build ${OUT}/${what})
    file(REMOVE_RECURSE ${build})
    execute_process(
        COMMAND ${CMAKE_COMMAND} -G ${GENERATOR} -S ${source} -B ${build}
            -D INSONIFY_TESTS=OFF -D INSONIFY_EXAMPLES=OFF ${ARGN}
        OUTPUT_VARIABLE printed ERROR_VARIABLE printed RESULT_VARIABLE failed)
    if(failed)
        message(FATAL_ERROR "${what} was not configured:\n${printed}")
    endif()
    load_cache(${build} READ_WITH_PREFIX built_ CMAKE_BUILD_TYPE)
    if(NOT "${built_CMAKE_BUILD_TYPE}" STREQUAL "${expected}")
        message(SEND_ERROR "${what}: the build type is '${built_CMAKE_BUILD_TYPE}', not '${expected}'")
    endif()
    string(FIND "${printed}" "building Release" told)
    if(what STREQUAL "top_level" AND told EQUAL -1)
        message(SEND_ERROR "${what}: nothing says that the build type was chosen:\n${printed}")
    elseif(NOT what STREQUAL "top_level" AND NOT told EQUAL -1)
        message(SEND_ERROR "${what}: a build type was chosen:\n${printed}")
    endif()
endfunction()

check_build_type(top_level Release ${INSONIFY})
check_build_type(chosen Debug ${INSONIFY} -D CMAKE_BUILD_TYPE=Debug)
check_build_type(subproject "" ${CMAKE_CURRENT_LIST_DIR} -D WAY=add_subdirectory -D INSONIFY=${INSONIFY})
