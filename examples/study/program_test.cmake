# SPDX-License-Identifier: MIT
#
# Runs phymul-study (STUDY) on small studies of MESH, in one thread, in two, and by MPIRUN in two processes, and compares
# what they write into OUT.
file(REMOVE_RECURSE ${OUT})
file(MAKE_DIRECTORY ${OUT})

# In `said`: what it printed.
function(study expected_code expected_text)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${OUT} RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(NOT code EQUAL expected_code OR NOT "${out}${err}" MATCHES "${expected_text}")
    message(FATAL_ERROR "${ARGN}\nexpected exit code ${expected_code} and \"${expected_text}\", got ${code} and:\n"
                        "${out}${err}")
  endif()
  set(said "${out}${err}" PARENT_SCOPE)
endfunction()

function(expect_same a b)
  execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${OUT}/${a} ${OUT}/${b} RESULT_VARIABLE different)
  if(different)
    message(FATAL_ERROR "${a} and ${b} differ")
  endif()
endfunction()

# The value of an unknown is within four standard deviations of the true one, and these are small. Whole numbers.
function(expect_found file name truth most_percent)
  file(READ ${OUT}/${file} text)
  if(NOT text MATCHES "\n${name},([0-9]+)[^,]*,([0-9]+)")
    message(FATAL_ERROR "${file} has no ${name}:\n${text}")
  endif()
  math(EXPR off "(${CMAKE_MATCH_1} - ${truth}) * (${CMAKE_MATCH_1} - ${truth})")
  math(EXPR most "16 * (${CMAKE_MATCH_2} + 1) * (${CMAKE_MATCH_2} + 1)")
  math(EXPR share "100 * ${CMAKE_MATCH_2} / ${truth}")
  if(off GREATER most OR share GREATER_EQUAL most_percent)
    message(FATAL_ERROR "${file}: expected ${truth}, to ${most_percent} %, got\n${text}")
  endif()
endfunction()

set(body "run ${MESH} --unit 0.01 --fix \"fixed side\"\n")
set(spread "parameter young lognormal 8000 1.3\nparameter push uniform 0.01 0.05\ntarget tip group tip\n"
           "target inside point 0.012 0.005 0.009\n")
string(REPEAT "n" 400 long)
file(WRITE ${OUT}/sampled.study "${body}run --young {young} --poisson {nu} --force tip=0,0,{-push}\n"
     "parameter nu list 0.3 0.45\nsamples 12 seed 3\n" ${spread} "target ${long} group tip\n")
file(WRITE ${OUT}/killed.study "${body}run --young {young} --force tip=0,0,{-push}\nsamples 600\n" ${spread})

study(0 "nu = 0.45, inside: 12 scenes, 0 failed.*, n+: 12 scenes[^\n]*deviation" ${STUDY} sampled.study --threads 1 --out one)
study(0 "" ${STUDY} sampled.study --threads 3 --out three --quiet)
expect_same(one/scenes.csv three/scenes.csv)
expect_same(one/targets.csv three/targets.csv)
file(STRINGS ${OUT}/one/scenes.csv rows)
list(LENGTH rows count)
if(NOT count EQUAL 25)
  message(FATAL_ERROR "expected 24 scenes and a head, got ${count} lines")
endif()
# Nothing is done twice, and another study does not take these results.
study(0 "24 of 24 scenes were done before" ${STUDY} sampled.study --out one)
study(1 "one/results.txt:1: these are results of another study" ${STUDY} killed.study --out one)
study(1 "^phymul-study: .*results.txt: expected a file that can be written" ${STUDY} sampled.study --out /proc)

# A scene is a command of phymul-run, which rests at the same place: to 0.1 mm here.
study(0 "^cd [^\n]* && phymul-run [^\n]*--young [0-9.]+ --poisson 0.45 --force tip=0,0,-0.0[0-9]+\n$"
      ${STUDY} sampled.study --show 13)
string(REPLACE "phymul-run" "'${RUN}'" command "${said}")
string(STRIP "${command}" command)
execute_process(COMMAND sh -c "${command} --out ${OUT}/shown --frame-interval 0 --no-pictures --damping 60" OUTPUT_QUIET
                ERROR_QUIET RESULT_VARIABLE code)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "${command}\nended with ${code}")
endif()

# Stiffnesses from a measurement that a known body would have given.
file(WRITE ${OUT}/points.csv "x,y,z\n0.005,0.005,0.008\n0.009,0.005,0.008\n0.012,0.005,0.005\n0.014,0.005,0.002\n"
                             "0.009,0.002,0.014\n0.012,0.005,0.013\n0.006,0.008,0.012\n0.014,0.005,0.016\n")
file(WRITE ${OUT}/fit.study "${body}run --young {tissue} --poisson 0.4 --material top={top},0.4 --force tip=0,0,-0.03\n"
                            "unknown tissue guess 5000\nunknown top guess 5000\nmeasured points.csv deviation 2e-5\n")
study(0 "^$" ${STUDY} fit.study --synthesise tissue=9000 top=3000 --noise-seed 2)
study(0 "tissue = .*top = .*correlation of tissue and top: .*misfit [01]\\." ${STUDY} fit.study --threads 1 --out fit_one)
study(0 "" ${STUDY} fit.study --threads 2 --out fit_two --quiet)
expect_same(fit_one/fit.csv fit_two/fit.csv)
expect_found(fit_one/fit.csv tissue 9000 10)
expect_found(fit_one/fit.csv top 3000 10)

# Refused, with file and line, or with the scene that has no result.
file(WRITE ${OUT}/group.study "${body}run --force no_such_group=0,0,1\ntarget tip group tip\n")
file(WRITE ${OUT}/option.study "${body}run --young soft\ntarget tip group tip\n")
file(WRITE ${OUT}/ratio.study "${body}run --force tip=0,0,-0.01 --poisson {nu}\nparameter nu list 0.3 0.6\ntarget tip group tip\n")
file(WRITE ${OUT}/loose.study "run ${MESH} --unit 0.01 --gravity 0 0 {g}\nparameter g list 0 -1\ntarget tip group tip\n")
file(WRITE ${OUT}/away.study "${body}target tip point 1 0 0\n")
study(1 "^phymul-study: group.study:2: .*no_such_group" ${STUDY} group.study --out none)
study(1 "^phymul-study: option.study:2: .*--young" ${STUDY} option.study --out none)
study(1 "^phymul-study: away.study:1: " ${STUDY} away.study --out none)
study(1 "^phymul-study: no.study: expected a study file that can be read" ${STUDY} no.study --out none)
study(1 "^phymul-study: none/no.study: expected a study file that can be read" ${STUDY} none/no.study --out none)
study(1 "--show: expected a scene of 1 to 24, got 25" ${STUDY} sampled.study --show 25)
study(1 "--synthesise: expected a value of top" ${STUDY} fit.study --synthesise tissue=1)
study(2 "scene 2 has no result: .*0.6" ${STUDY} ratio.study --out ratio)
study(2 "scene 2 has no result: .*no rest" ${STUDY} loose.study --out loose)
file(READ ${OUT}/loose/scenes.csv text)
if(NOT text MATCHES "\n1,0,ok,[^\n]*\n2,-1,failed,,,,,,,\"[^\n]*no rest[^\n]*\"\n")
  message(FATAL_ERROR "loose/scenes.csv:\n${text}")
endif()
if(EXISTS ${OUT}/none)
  message(FATAL_ERROR "a study that was refused wrote something")
endif()

if(NOT MPIRUN)
  message(STATUS "MPI NOT TESTED: this build has none")
  return()
endif()
study(0 "" ${MPIRUN} ${STUDY} sampled.study --out ranks --quiet)
expect_same(one/scenes.csv ranks/scenes.csv)
expect_same(one/targets.csv ranks/targets.csv)
study(0 "" ${MPIRUN} ${STUDY} fit.study --out fit_ranks --quiet)
expect_same(fit_one/fit.csv fit_ranks/fit.csv)
study(1 "group.study:2: " ${MPIRUN} ${STUDY} group.study --out none)
string(REGEX MATCHALL "group.study:2" times "${said}")
if(NOT times STREQUAL "group.study:2")
  message(FATAL_ERROR "an error was not said once:\n${said}")
endif()
