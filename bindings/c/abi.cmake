# SPDX-License-Identifier: MIT
#
# cmake -DCOMPILER=cc -DSCRATCH=folder -P abi.cmake: functions and structs of the headers are those of abi.xml, for a
# program that was compiled before. libabigail (Debian: abigail-tools) compares a library of empty functions with the
# declarations of the headers; that the real ones have these types, the compiler sees to, and symbols.cmake that all are
# there. With -DWRITE=ON it writes abi.xml anew, after additions. Anything else needs another SOVERSION.
cmake_minimum_required(VERSION 3.25)
find_program(abidw abidw)
find_program(abidiff abidiff)
if(NOT abidw OR NOT abidiff)
  message(STATUS "ABI NOT TESTED: abidw and abidiff were not found; on Debian or Ubuntu: apt-get install abigail-tools")
  return()
endif()

set(folder ${CMAKE_CURRENT_LIST_DIR})
file(READ ${folder}/phymul_c.h text)
file(READ ${folder}/phymul_c_interaction.h more)
string(APPEND text "${more}")
string(REGEX REPLACE "//[^\n]*" "" text "${text}")
string(REPLACE ";" "@" text "${text}")
string(REGEX MATCHALL "PHYMUL_API [^@]+\\)@" functions "${text}")
set(empty "#include <phymul_c.h>\n")
foreach(function IN LISTS functions)
  string(REGEX REPLACE "@$" "" function "${function}")
  if(function MATCHES "^PHYMUL_API void phymul_")
    string(APPEND empty "${function} {}\n")
  else()
    string(APPEND empty "${function} { return 0; }\n")
  endif()
endforeach()
file(WRITE ${SCRATCH}/empty.c "${empty}")
set(library ${SCRATCH}/libphymul_c.so.1)
execute_process(COMMAND ${COMPILER} -std=c99 -g -gdwarf-4 -O0 -fPIC -shared -Wl,-soname,libphymul_c.so.1 -I ${folder}
                        -ffile-prefix-map=${SCRATCH}=. -ffile-prefix-map=${folder}=. empty.c -o ${library}
                WORKING_DIRECTORY ${SCRATCH} COMMAND_ERROR_IS_FATAL ANY)

if(WRITE)
  execute_process(COMMAND ${abidw} --no-corpus-path --no-comp-dir-path --no-show-locs --out-file ${folder}/abi.xml
                          ${library} COMMAND_ERROR_IS_FATAL ANY)
  return()
endif()
if(NOT REFERENCE)
  set(REFERENCE ${folder}/abi.xml)
endif()
execute_process(COMMAND ${abidiff} ${REFERENCE} ${library} RESULT_VARIABLE changes)
if(NOT changes EQUAL 0)
  message(FATAL_ERROR "The headers are not what ${REFERENCE} says (abidiff: ${changes}). If something was added at an end: "
                      "cmake -DWRITE=ON -DCOMPILER=${COMPILER} -DSCRATCH=${SCRATCH} -P ${folder}/abi.cmake. If "
                      "something else changed, programs that were compiled before go wrong")
endif()
