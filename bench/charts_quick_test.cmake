# SPDX-License-Identifier: MIT
#
# The chart programs end to end on the smallest bodies, and the drawing where matplotlib is installed.
file(REMOVE_RECURSE ${OUT})
file(MAKE_DIRECTORY ${OUT})

function(run_program)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN} failed (${result}):\n${output}")
  endif()
endfunction()

function(require_rows file least)
  file(STRINGS ${OUT}/${file} rows REGEX "^[^#]")
  list(LENGTH rows count)
  if(count LESS least)
    message(FATAL_ERROR "${file}: expected at least ${least} rows, got ${count}")
  endif()
endfunction()

run_program(${WORK_PRECISION} --cases ${CASES}/cube_bonded.case,${CASES}/closed_stretch.case --most-resolutions 2
            --most-particles 130 --steps 0.5 --wall-cap 20 --backends reference
            --out ${OUT}/work_precision.csv --samples ${OUT}/samples.csv)
require_rows(work_precision.csv 61)
file(STRINGS ${OUT}/work_precision.csv direct REGEX "^cube_bonded,.*,particle_averaged,.*,solve_static,.*,ok,")
if(NOT direct)
  message(FATAL_ERROR "work_precision.csv: expected a row of cube_bonded by solve_static, at rest")
endif()
# The calibrated body in uniform strain is exact whatever the machine: error below 1e-3, at rest.
file(STRINGS ${OUT}/work_precision.csv exact REGEX "closed_stretch.*,nu0.30,particle_averaged,.*,ok,")
if(NOT exact)
  message(FATAL_ERROR "work_precision.csv: expected a row of closed_stretch by the material, at rest")
endif()
foreach(row IN LISTS exact)
  if(NOT row MATCHES ",(steps,.*,ok,[0-9]+,[^,]+,[^,]+,[^,]+|solve_static,.*,ok,[0-9]+,,[^,]+,),[0-9.]+e-0[4-9],")
    message(FATAL_ERROR "expected an error below 1e-3 in: ${row}")
  endif()
endforeach()

run_program(${PEER_CUBE} --side 4 --reference-steps 400 --slow-steps 200 --steps 100,200 --bullet-steps 10 --repeats 1
            --backends reference --out ${OUT}/soft_cube.csv)
require_rows(soft_cube.csv 6)
run_program(${WORK_PRECISION} --cases ${CASES}/peers/sofa_cantilever.case --methods particle_averaged --backends cpu --rest steps
            --threads 1 --steps 0.9,0.5 --most-particles 450 --out ${OUT}/peers_1.csv)
file(STRINGS ${OUT}/peers_1.csv timed REGEX ",ok,.*,[0-9.e-]+$")
list(LENGTH timed count)
if(NOT count EQUAL 2)
  message(FATAL_ERROR "peers_1.csv: expected two rows at rest that end in a processor time, got ${count}")
endif()
run_program(${TRAJECTORY_ERROR} --finest 16 --most-steps 16 --methods springs_18 --backends reference
            --order ${OUT}/order_in_time.csv --equivalence ${OUT}/equivalence.csv)
require_rows(order_in_time.csv 4)

run_program(${STABILITY_ATLAS} --cells 2 --steps 300 --most-particles 16 --factors 1 --ratios 100
            --valences 18 --limits ${OUT}/stability_limits.csv
            --recovery ${OUT}/stability_recovery.csv --rates ${OUT}/stability_rates.csv)
require_rows(stability_limits.csv 38)
require_rows(stability_recovery.csv 150)
require_rows(stability_rates.csv 6)

foreach(python python3 /usr/bin/python3)
  execute_process(COMMAND ${python} -c "import matplotlib" RESULT_VARIABLE missing OUTPUT_QUIET ERROR_QUIET)
  if(missing EQUAL 0)
    run_program(${python} ${CHARTS}/draw.py ${OUT})
    run_program(${python} ${CHARTS}/draw_stability.py ${OUT})
    run_program(${python} ${CHARTS}/draw_peers.py ${OUT})
    foreach(chart work_precision_cube_bonded convergence_spacing convergence_time equivalence soft_cube_measured
                  stability_limit_mass stability_recovery beside_sofa)
      if(NOT EXISTS ${OUT}/${chart}.svg OR NOT EXISTS ${OUT}/${chart}.png)
        message(FATAL_ERROR "draw.py wrote no ${chart}")
      endif()
    endforeach()
    foreach(file work_precision_cube_bonded.svg convergence_spacing.svg stability_recovery.svg tables.md)
      file(READ ${OUT}/${file} text)
      if(NOT text MATCHES "Poisson's ratio 0.30" OR text MATCHES "nu ?0[.]3|cube_bonded|cube bonded")
        message(FATAL_ERROR "${file}: expected words for cases and methods, as of chart_names.py, and no codes")
      endif()
    endforeach()
    return()
  endif()
endforeach()
message(STATUS "DRAWING NOT CHECKED: no Python with matplotlib (Debian: python3-matplotlib)")
