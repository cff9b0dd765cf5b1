# SPDX-License-Identifier: MIT
#
# The program in README.md is examples/hello.cpp, which is built and run: what the README shows works.
include(${CMAKE_CURRENT_LIST_DIR}/faults.cmake)

file(READ "${ROOT}/README.md" readme)
file(READ "${ROOT}/examples/hello.cpp" program)
string(REPLACE "// SPDX-License-Identifier: MIT\n" "" program "${program}")
string(FIND "${readme}" "```cpp\n${program}```\n" place)
if(place EQUAL -1)
  fault("${ROOT}/README.md" "shows another program than examples/hello.cpp")
endif()

# Links to files of this project lead somewhere.
# (A square bracket would glue the elements of a CMake list together.)
string(REPLACE "](" "<(" readme "${readme}")
string(REGEX MATCHALL "<\\([^):]+\\)" links "${readme}")
foreach(link IN LISTS links)
  string(REGEX REPLACE "^<\\(|#.*|\\)$" "" target "${link}")
  if(NOT EXISTS "${ROOT}/${target}")
    fault("${ROOT}/README.md" "links to ${target}, which is not there")
  endif()
endforeach()
report_faults()
