# Makes one program of all C++ in the pages of the guide and in the README, and writes the files that they show:
#     cmake -D OUT=folder -P tests/guide/cut_blocks.cmake
#
# - A block ```cpp is a function of its own, with `using namespace insonify` before it; it begins anew, knowing no name of
#   the block before. One that declares types, templates or functions stands at file scope instead, and is known to all
#   that follow. One that has a `main` is called with the name of the first OBJ file.
# - A block ```text that follows upon one of ```cpp is what that prints.
# - A block ```obj is written under the name of its object, one ```mtl under the name that the OBJ before calls it by.
#
# Text is only searched, cut and appended, never treated as a list, so that brackets and semicolons stay as they are.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/pages.cmake)

set(declares "(^|\n)(namespace|template|struct|class|enum|void|#include) ?")
set(code "// Cut out of the pages by tests/guide/cut_blocks.cmake.
#include <insonify/insonify.hpp>
#include <cstdio>
#include \"run_blocks.hpp\"
using namespace insonify;\n")
file(MAKE_DIRECTORY ${OUT})

# Of what was cut last: a block whose printed text may follow.
function(close_row prints)
    get_property(row GLOBAL PROPERTY row)
    if(NOT row STREQUAL "")
        set_property(GLOBAL APPEND_STRING PROPERTY table "    {${row}, ${prints}},\n")
        set_property(GLOBAL PROPERTY row "")
    endif()
endfunction()

# Takes over one block of a page.
function(take_block page line language text)
    get_property(number GLOBAL PROPERTY number)
    if(language STREQUAL "text")
        close_row("R\"guide(${text})guide\"")
        return()
    endif()
    close_row(nullptr)
    if(language STREQUAL "obj")
        string(REGEX MATCH "(^|\n)o ([^\n]+)" name "${text}")
        file(WRITE ${OUT}/${CMAKE_MATCH_2}.obj "${text}")
        string(REGEX MATCH "(^|\n)mtllib ([^\n]+)" name "${text}")
        set_property(GLOBAL PROPERTY library ${CMAKE_MATCH_2})
    elseif(language STREQUAL "mtl")
        get_property(library GLOBAL PROPERTY library)
        file(WRITE ${OUT}/${library} "${text}")
    elseif(language STREQUAL "cpp")
        math(EXPR number "${number} + 1")
        set_property(GLOBAL PROPERTY number ${number})
        set(place "#line ${line} \"${project}/${page}\"\n")
        set(call "static void call_${number}(int, char**)")
        if(text MATCHES "int main\\(\\)|int main\\(int, char\\*\\* [a-z]+\\)")
            string(REGEX REPLACE "int main\\(\\)" "void program_${number}(int, char**)" text "${text}")
            string(REGEX REPLACE "int main\\(int" "void program_${number}(int" text "${text}")
            set(call "${place}${text}static constexpr auto call_${number} = program_${number};\n")
        elseif(text MATCHES "${declares}")
            set_property(GLOBAL APPEND_STRING PROPERTY code "\n${place}${text}")
            return()
        else()
            set(call "static void call_${number}(int, char**) {\n${place}${text}}\n")
        endif()
        set_property(GLOBAL APPEND_STRING PROPERTY code "\n${call}")
        set_property(GLOBAL PROPERTY row "\"${page}:${line}\", call_${number}")
    endif()
endfunction()

set_property(GLOBAL PROPERTY code "${code}")
set_property(GLOBAL PROPERTY table "")
set_property(GLOBAL PROPERTY row "")
set_property(GLOBAL PROPERTY number 0)
foreach(page IN LISTS pages)
    file(READ ${project}/${page} rest)
    set(line 1)
    while(TRUE)
        string(FIND "${rest}" "\n```" begin)
        if(begin EQUAL -1)
            break()
        endif()
        string(SUBSTRING "${rest}" 0 ${begin} before)
        math(EXPR begin "${begin} + 4")
        string(SUBSTRING "${rest}" ${begin} -1 rest)
        string(FIND "${rest}" "\n" end)
        string(SUBSTRING "${rest}" 0 ${end} language)
        math(EXPR end "${end} + 1")
        string(SUBSTRING "${rest}" ${end} -1 rest)
        string(FIND "${rest}" "```" end)
        if(end EQUAL -1)
            message(FATAL_ERROR "${page}: a block is not closed")
        endif()
        string(SUBSTRING "${rest}" 0 ${end} text)
        math(EXPR end "${end} + 3")
        string(SUBSTRING "${rest}" ${end} -1 rest)

        string(REGEX REPLACE "[^\n]" "" before "${before}")
        string(REGEX REPLACE "[^\n]" "" inside "${text}")
        string(LENGTH "${before}" lines)
        math(EXPR line "${line} + ${lines} + 2")
        take_block("${page}" ${line} "${language}" "${text}")
        string(LENGTH "${inside}" lines)
        math(EXPR line "${line} + ${lines}")
    endwhile()
    close_row(nullptr)
endforeach()

get_property(code GLOBAL PROPERTY code)
get_property(table GLOBAL PROPERTY table)
file(WRITE ${OUT}/guide.cpp "${code}
static constexpr guide_block blocks[] = {
${table}};

int main(int arguments, char** argument) { return run_blocks(blocks, arguments, argument); }
")
