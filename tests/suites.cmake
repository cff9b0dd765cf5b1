# SPDX-License-Identifier: MIT
#
# ctest shows the suites of a GoogleTest program: one process each, found once the program is linked. Tests that match
# `phymul_long_tests` are entries of their own, <program>.<suite>.long, with the label "full". One test by itself:
#   build/release/tests/phymul_test --gtest_filter='Suite.Test'
if(NOT CMAKE_SCRIPT_MODE_FILE)
  function(phymul_test_suites program)
    set(entries ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.cmake)
    add_custom_command(TARGET ${program} POST_BUILD
      COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${program}> -DNAME=${program} -DOUTPUT=${entries}
              "-DEMULATOR=${CMAKE_CROSSCOMPILING_EMULATOR}" "-DLONG=${phymul_long_tests}" "-DONLY=${phymul_only_tests}"
              -P ${PROJECT_SOURCE_DIR}/tests/suites.cmake
      BYPRODUCTS ${entries} VERBATIM)
    # A program that was not built is a failure, as ctest does it for a missing command.
    set(include ${CMAKE_CURRENT_BINARY_DIR}/${program}_include.cmake)
    file(WRITE ${include} "if(EXISTS \"${entries}\")\n  include(\"${entries}\")\nelse()\n"
                          "  add_test(${program}_NOT_BUILT ${program}_NOT_BUILT)\nendif()\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${include})
  endfunction()
  return()
endif()

cmake_minimum_required(VERSION 3.25)

# A GoogleTest filter ("A.*:B.*") as a regular expression.
function(as_regex filter result)
  string(REPLACE "." "\\." filter "${filter}")
  string(REPLACE "*" ".*" filter "${filter}")
  string(REPLACE ":" "|" filter "${filter}")
  set(${result} "^(${filter})$" PARENT_SCOPE)
endfunction()
as_regex("${LONG}" is_long)
as_regex("${ONLY}" is_meant)

execute_process(COMMAND ${EMULATOR} ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "(#|\r)[^\n]*" "" listed "${listed}")
string(REGEX MATCHALL "[^\n]+" lines "${listed}")
set(names "")  # of entries: a suite, or a suite with ".long"
foreach(line IN LISTS lines)
  if(line MATCHES "^([A-Za-z0-9_/]+\\.) *$")
    set(suite ${CMAKE_MATCH_1})
    continue()
  elseif(NOT line MATCHES "^  ([A-Za-z0-9_/]+) *$")
    continue()  # what the program itself prints
  endif()
  set(test ${suite}${CMAKE_MATCH_1})
  if(ONLY AND NOT test MATCHES "${is_meant}")
    continue()
  endif()
  # "All/Suite.", "/Suite.", "Suite/0." and "All/Suite/0." are instances of one suite.
  string(REGEX REPLACE "^[^/.]*/([^/.0-9][^/.]*)" "\\1" name "${suite}")
  string(REGEX REPLACE "[/.].*$" "" name "${name}")
  if(LONG AND test MATCHES "${is_long}")
    string(APPEND name ".long")
  endif()
  if(NOT name IN_LIST names)
    list(APPEND names ${name})
    set(filter_${name} "")
  endif()
  string(APPEND filter_${name} ":${test}")
endforeach()
if(NOT names)
  message(FATAL_ERROR "${PROGRAM} has no tests")
endif()

set(emulator "")  # that runs programs for another system
foreach(word IN LISTS EMULATOR)
  string(APPEND emulator " [==[${word}]==]")
endforeach()
set(text "# Made by tests/suites.cmake.\n")
foreach(name IN LISTS names)
  string(SUBSTRING "${filter_${name}}" 1 -1 filter)
  set(test "[==[${NAME}.${name}]==]")
  string(APPEND text "add_test(${test}${emulator} [==[${PROGRAM}]==] [==[--gtest_filter=${filter}]==] "
         "--gtest_brief=1)\n")
  if(name MATCHES "\\.long$")
    string(APPEND text "set_tests_properties(${test} PROPERTIES LABELS full TIMEOUT 3000)\n")
  endif()
endforeach()
file(WRITE ${OUTPUT} "${text}")
