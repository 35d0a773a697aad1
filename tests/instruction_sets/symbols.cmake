# No symbol of the library is defined in both of two objects of different instruction sets: the linker would keep one.
#     cmake -D NM=nm -D PLAIN=plain.o -D NATIVE=native.o -P symbols.cmake
cmake_minimum_required(VERSION 3.25)

foreach(object IN ITEMS PLAIN NATIVE)
    execute_process(COMMAND ${NM} --defined-only --extern-only ${${object}}
        OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL "[^ \n]*8insonify[0-9]+v0_[^ \n]*" symbols_${object} "${text}")
    if(NOT symbols_${object})
        message(FATAL_ERROR "${${object}} defines no symbol of the library")
    endif()
endforeach()

foreach(symbol IN LISTS symbols_PLAIN)
    if(symbol IN_LIST symbols_NATIVE)
        list(APPEND shared ${symbol})
    endif()
endforeach()
if(shared)
    list(JOIN shared "\n" shared)
    message(FATAL_ERROR "in both objects:\n${shared}")
endif()
