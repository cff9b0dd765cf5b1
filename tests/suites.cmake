# SPDX-License-Identifier: MIT
#
# ctest shows the suites of a GoogleTest program: one process each, found after the program is linked. One test by itself:
#   build/release/tests/phymul_test --gtest_filter='Suite.Test'
# Run as a script (cmake -DPROGRAM=... -DOUTPUT=... -P suites.cmake) it writes the entries.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  function(phymul_test_suites program)
    set(entries ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.cmake)
    add_custom_command(TARGET ${program} POST_BUILD
      COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${program}> -DNAME=${program} -DOUTPUT=${entries}
              "-DLONG=${phymul_long_tests}" -P ${PROJECT_SOURCE_DIR}/tests/suites.cmake
      BYPRODUCTS ${entries} VERBATIM)
    # A program that was not built is a failure, as ctest does it for a missing command.
    set(include ${CMAKE_CURRENT_BINARY_DIR}/${program}_include.cmake)
    file(WRITE ${include} "if(EXISTS \"${entries}\")\n  include(\"${entries}\")\nelse()\n"
                          "  add_test(${program}_NOT_BUILT ${program}_NOT_BUILT)\nendif()\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${include})
  endfunction()
  return()
endif()

execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "(^|\n)[A-Za-z0-9_/]+\\.[^\n]*" lines "${listed}")
set(suites "")
foreach(line IN LISTS lines)
  string(REGEX MATCH "[A-Za-z0-9_/]+" full "${line}")
  # Instances of one suite ("All/Suite", "Suite/0") run together.
  set(suite ${full})
  if(full MATCHES "^([^/]+)/([0-9]+)$")
    set(suite ${CMAKE_MATCH_1})
  elseif(full MATCHES "^([^/]+)/([^/]+)(/[0-9]+)?$")
    set(suite ${CMAKE_MATCH_2})
  endif()
  if(NOT suite IN_LIST suites)
    list(APPEND suites ${suite})
    set(filter_${suite} "")
  endif()
  string(APPEND filter_${suite} ":${full}.*")
endforeach()
list(LENGTH suites count)
if(count EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} has no tests")
endif()
set(text "# Made by tests/suites.cmake.\n")
foreach(suite IN LISTS suites)
  string(SUBSTRING "${filter_${suite}}" 1 -1 filter)
  string(APPEND text "add_test([==[${NAME}.${suite}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${filter}]==] --gtest_brief=1)\n")
endforeach()
file(WRITE ${OUTPUT} "${text}")
