# Who includes whom:
#     cmake -P tests/floors.cmake
#
# A folder includes itself and lower floors, never a sibling. The roots stand above all; `fwd.hpp` alone may be included
# from anywhere, and includes core/config.hpp alone. Own includes stand outside of every #if but the guard, and every
# header is included by another, up to the umbrella.
cmake_minimum_required(VERSION 3.25)

set(core 1)
set(geometry 2)
set(execution 2)
set(bvh 3)
set(acoustics 3)
set(probe 3)
set(scene 4)
set(signal 4)
set(tracing 5)
set(image 5)
set(io 6)
set(roots 7)

# Slow to compile: in no header but those that INSONIFY_IMPLEMENTATION alone compiles. Where the standard library has no
# lighter header with the policies' types, execution/policy.hpp falls back on <execution>.
set(slow "#[ ]*include <(complex|condition_variable|functional|ranges|random|iostream|sstream|filesystem|regex|execution)>")
set(slow_legal "^io/implementation|^execution/policy.hpp")

cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH project)
set(root ${project}/include/insonify)
file(GLOB_RECURSE headers RELATIVE ${root} ${root}/*.hpp)

function(fault what)
    message(SEND_ERROR "${header} ${what}")
endfunction()

# A header's folder by name and by number of its floor.
function(locate header folder floor)
    cmake_path(GET header PARENT_PATH name)
    if(name STREQUAL "")
        set(name roots)
    elseif(NOT DEFINED ${name})
        message(FATAL_ERROR "${header} lies in a folder without a floor")
    endif()
    set(${folder} ${name} PARENT_SCOPE)
    set(${floor} ${${name}} PARENT_SCOPE)
endfunction()

foreach(header IN LISTS headers)
    locate(${header} folder floor)
    file(READ ${root}/${header} text)
    string(REGEX REPLACE "//[^\n]*" "" text "${text}")

    string(MAKE_C_IDENTIFIER INSONIFY_${header} guard)
    string(TOUPPER ${guard} guard)
    if(NOT text MATCHES "^#ifndef ${guard}\n#define ${guard}\n" AND NOT header STREQUAL io/implementation.hpp)
        fault("does not begin with its guard ${guard}")
    endif()
    if(text MATCHES "glm(::|/)" AND NOT header STREQUAL core/math.hpp)
        fault("names GLM, which core/math.hpp alone does")
    endif()
    if(NOT header MATCHES "${slow_legal}" AND text MATCHES "${slow}")
        fault("includes <${CMAKE_MATCH_1}>, which is slow to compile")
    endif()

    string(REGEX MATCHALL "#[ ]*(if|endif|include[ ]*[<\"]insonify/[^>\"]+)" lines "${text}")
    set(depth 0)
    foreach(line IN LISTS lines)
        if(line MATCHES "#[ ]*if")
            math(EXPR depth "${depth} + 1")
            continue()
        elseif(line MATCHES "#[ ]*endif")
            math(EXPR depth "${depth} - 1")
            continue()
        endif()

        string(REGEX REPLACE ".*insonify/" "" included ${line})
        list(APPEND reached ${included})
        locate(${included} included_folder included_floor)
        if(depth GREATER 1)
            fault("includes ${included} under a condition")
        endif()
        if(header STREQUAL fwd.hpp AND NOT included STREQUAL core/config.hpp)
            fault("includes ${included}: it may include core/config.hpp alone")
        elseif(NOT included STREQUAL fwd.hpp AND NOT included_folder STREQUAL folder AND NOT included_floor LESS floor)
            fault("includes ${included}, which is not on a lower floor")
        endif()
    endforeach()
endforeach()

foreach(header IN LISTS headers)
    if(NOT header STREQUAL insonify.hpp AND NOT header IN_LIST reached)
        fault("is included by no other header")
    endif()
endforeach()
