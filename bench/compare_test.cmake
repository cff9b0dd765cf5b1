# SPDX-License-Identifier: MIT
#
# Beside itself a bench has ratios of 1; beside one twice as slow, of 2. What the bench prints is recorded once, and the
# programs compared print that record, so that no verdict depends on what else the machine does.
file(MAKE_DIRECTORY ${OUT})
set(arguments --benchmark_filter=solver_step/[cr][a-z]*/springs/.*:5/ --benchmark_min_time=0.02)

set(record ${OUT}/record.csv)
execute_process(COMMAND ${BENCH} ${arguments} --benchmark_format=csv OUTPUT_FILE ${record} ERROR_QUIET
                COMMAND_ERROR_IS_FATAL ANY)

# A program that prints the record, its times (real and of the processor) multiplied, if it is called as the bench was.
function(replay name factor)
  set(script ${OUT}/${name}.sh)
  list(JOIN arguments " " expected)
  file(WRITE ${script} "#!/bin/sh\n[ \"$*\" = '${expected} --benchmark_format=csv' ] || exit 1\nawk -F, -v OFS=, '/^\"/ { $3 *= ${factor}; $4 *= ${factor} } { print }' '${record}'\n")
  file(CHMOD ${script} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  set(${name} ${script} PARENT_SCOPE)
endfunction()
replay(as_recorded 1)
replay(twice_as_slow 2)

function(compare expected_code a b output)
  execute_process(COMMAND ${COMPARE} --runs 3 --time cpu_time --fail-above 1.6 ${a} ${b} ${arguments}
                  RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT code EQUAL expected_code)
    message(FATAL_ERROR "compare ${a} ${b}: expected exit code ${expected_code}, got ${code}:\n${text}")
  endif()
  set(${output} "${text}" PARENT_SCOPE)
endfunction()

# Every median of the table is this one.
function(require_medians text median)
  string(REGEX MATCHALL "real_time +[^\n]*" rows "${text}")
  if(NOT rows)
    message(FATAL_ERROR "expected rows of benchmarks in:\n${text}")
  endif()
  foreach(row IN LISTS rows)
    if(NOT row MATCHES "^real_time +[0-9.e+]+ +${median} ")
      message(FATAL_ERROR "expected a median of ${median}: ${row}")
    endif()
  endforeach()
endfunction()

compare(0 ${as_recorded} ${as_recorded} text)
require_medians("${text}" "1\\.000")
compare(3 ${as_recorded} ${twice_as_slow} text)
require_medians("${text}" "2\\.000")

execute_process(COMMAND ${COMPARE} ${BENCH} RESULT_VARIABLE code OUTPUT_QUIET ERROR_VARIABLE text)
if(NOT code EQUAL 1 OR NOT text MATCHES "paths of two builds")
  message(FATAL_ERROR "expected a refusal of one path, got ${code}: ${text}")
endif()
