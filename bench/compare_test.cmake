# SPDX-License-Identifier: MIT
#
# A bench beside itself has ratios around 1; beside one twice as slow, around 2. The slow one is a fake: it doubles what
# the bench itself says.
file(MAKE_DIRECTORY ${OUT})
set(arguments --benchmark_filter=solver_step/[cr][a-z]*/springs/.*:5/ --benchmark_min_time=0.02)

function(compare expected_code a b output)
  execute_process(COMMAND ${COMPARE} --runs 3 --time cpu_time --fail-above 1.6 ${a} ${b} ${arguments}
                  RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT code EQUAL expected_code)
    message(FATAL_ERROR "compare ${a} ${b}: expected exit code ${expected_code}, got ${code}:\n${text}")
  endif()
  set(${output} "${text}" PARENT_SCOPE)
endfunction()

# Every median of the table matches; the machine may be busy.
function(require_medians text pattern)
  string(REGEX MATCHALL "real_time +[^\n]*" rows "${text}")
  if(NOT rows)
    message(FATAL_ERROR "expected rows of benchmarks in:\n${text}")
  endif()
  foreach(row IN LISTS rows)
    if(NOT row MATCHES "^real_time +[0-9.e+]+ +${pattern} ")
      message(FATAL_ERROR "expected a median of ${pattern}: ${row}")
    endif()
  endforeach()
endfunction()

compare(0 ${BENCH} ${BENCH} text)
require_medians("${text}" "(0\\.[6-9]|1\\.[0-5])[0-9]*")

set(slow ${OUT}/twice_as_slow.sh)
file(WRITE ${slow} "#!/bin/sh\n'${BENCH}' \"$@\" | awk -F, -v OFS=, '/^\"/ { $3 *= 2; $4 *= 2 } { print }'\n")
file(CHMOD ${slow} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
compare(3 ${BENCH} ${slow} text)
require_medians("${text}" "(1\\.[3-9]|2\\.[0-9]|3\\.[01])[0-9]*")

execute_process(COMMAND ${COMPARE} ${BENCH} RESULT_VARIABLE code OUTPUT_QUIET ERROR_VARIABLE text)
if(NOT code EQUAL 1 OR NOT text MATCHES "paths of two builds")
  message(FATAL_ERROR "expected a refusal of one path, got ${code}: ${text}")
endif()
