# SPDX-License-Identifier: MIT
#
# cmake -DNM=... -DLIBRARY=... -DLIST=symbols.txt -P symbols.cmake: the library shows the functions
# of the list alone. What is in the list stays there as long as the library has the same SOVERSION.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${NM} --dynamic --defined-only --format=posix ${LIBRARY} OUTPUT_VARIABLE shown
                COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE " [^\n]*" "" shown "${shown}")
file(READ ${LIST} wanted)
if(NOT shown STREQUAL wanted)
  message(FATAL_ERROR "${LIST} lists:\n${wanted}\n${LIBRARY} shows:\n${shown}")
endif()
