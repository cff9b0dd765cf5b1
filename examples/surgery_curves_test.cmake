# SPDX-License-Identifier: MIT
#
# The force curves from the examples' CSV files.
set(charts needle prostate_probe prostate_needles cloth_on_sphere two_organs)
foreach(chart IN LISTS charts)
  file(REMOVE ${OUT}/${chart}_force.png)  # of an earlier run
endforeach()
foreach(python python3 /usr/bin/python3)
  execute_process(COMMAND ${python} -c "import matplotlib" RESULT_VARIABLE missing OUTPUT_QUIET ERROR_QUIET)
  if(missing EQUAL 0)
    execute_process(COMMAND ${python} ${CHARTS}/draw_forces.py ${OUT} RESULT_VARIABLE result OUTPUT_VARIABLE output
                    ERROR_VARIABLE output)
    if(NOT result EQUAL 0)
      message(FATAL_ERROR "draw_forces.py failed (${result}):\n${output}")
    endif()
    foreach(chart IN LISTS charts)
      if(NOT EXISTS ${OUT}/${chart}_force.png)
        message(FATAL_ERROR "draw_forces.py wrote no ${chart}_force.png")
      endif()
    endforeach()
    return()
  endif()
endforeach()
message(STATUS "DRAWING NOT CHECKED: no Python with matplotlib (Debian: python3-matplotlib)")
