# SPDX-License-Identifier: MIT
#
# Collects the faults a check finds; common to all checks.
cmake_minimum_required(VERSION 3.25)

set(faults "")

# One fault of one file.
function(fault file sentence)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${ROOT}" OUTPUT_VARIABLE place)
  set(faults "${faults}${place}: ${sentence}\n" PARENT_SCOPE)
endfunction()

# Fails with all faults; where ROOT/expected.txt lists the faults to be found, fails unless just those were found.
macro(report_faults)
  set(expected "")
  if(EXISTS "${ROOT}/expected.txt")
    file(READ "${ROOT}/expected.txt" expected)
  endif()
  if(NOT faults STREQUAL expected)
    message(FATAL_ERROR "expected faults:\n${expected}\nfound:\n${faults}")
  endif()
endmacro()

# Lines of a file that include something, as a list of "<name>" and "\"name\"".
function(read_includes file result)
  file(STRINGS "${file}" lines REGEX "^[ \t]*#[ \t]*include[ \t]*[<\"]")
  set(includes "")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^[ \t]*#[ \t]*include[ \t]*([<\"][^>\"]*[>\"]).*" "\\1" include "${line}")
    list(APPEND includes "${include}")
  endforeach()
  set(${result} "${includes}" PARENT_SCOPE)
endfunction()
