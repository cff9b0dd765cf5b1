# SPDX-License-Identifier: MIT
#
# The order of includes. A file of a row may include files of its own row and the rows above it; a forward declaration
# does for the rest (topology.h and TopologyTextures). A new file finds its row by its name, or gets one here.
include(${CMAKE_CURRENT_LIST_DIR}/faults.cmake)

# Name without extension, or its beginning up to an underscore. The first match counts.
set(rows
    "7 backends"                  # the table of backends; sees them all, nothing sees what it includes
    "3 topology_textures"         # before topology
    "0 version types error"
    "1 model scene state"
    "2 shapes pml lml mesh check topology monitor writer"
    "2 xml byte gmsh vtk vtu csv"            # formats, behind the readers
    "4 elasticity solver"
    "8 phymul")                   # the umbrella, for users only

# Row of a path below include/phymul or src, as a number; empty: unknown. cpu is 5, gl is 6.
function(row_of path result)
  set(${result} "" PARENT_SCOPE)
  if(path MATCHES "^cpu/")
    set(${result} 5 PARENT_SCOPE)
    return()
  elseif(path MATCHES "^gl/")
    set(${result} 6 PARENT_SCOPE)
    return()
  endif()
  cmake_path(GET path STEM stem)
  foreach(row IN LISTS rows)
    string(REPLACE " " ";" stems "${row}")
    list(POP_FRONT stems number)
    foreach(known IN LISTS stems)
      if(stem MATCHES "^${known}(_|$)")
        set(${result} ${number} PARENT_SCOPE)
        return()
      endif()
    endforeach()
  endforeach()
endfunction()

# The include as a path below include/phymul or src; empty: none of ours.
function(own_path include folder result)
  set(path "")
  if(include MATCHES "^<phymul/(.*)>$")
    set(path "${CMAKE_MATCH_1}")
  elseif(include MATCHES "^\"(.*)\"$")
    set(path "${CMAKE_MATCH_1}")
    if(EXISTS "${folder}/${path}")
      set(absolute "${folder}/${path}")
      cmake_path(NORMAL_PATH absolute)
      cmake_path(RELATIVE_PATH absolute BASE_DIRECTORY "${ROOT}/src" OUTPUT_VARIABLE path)
    endif()
  endif()
  set(${result} "${path}" PARENT_SCOPE)
endfunction()

function(check_library_file file base)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${base}" OUTPUT_VARIABLE own)
  cmake_path(GET file PARENT_PATH folder)
  row_of("${own}" row)
  if(row STREQUAL "")
    fault("${file}" "has no row in the order of includes; give its name one in tests/checks/layering.cmake")
    return(PROPAGATE faults)
  endif()
  read_includes("${file}" includes)
  foreach(include IN LISTS includes)
    if(include STREQUAL "<pugixml.hpp>" AND NOT own MATCHES "^(xml|pml|lml|vtu)_[a-z_]*\\.(h|cpp)$")
      fault("${file}" "includes pugixml; only src/xml_*, pml_*, lml_* and vtu_* may")
    elseif(include MATCHES "^<(GL|EGL|GLES[23]?)/" AND NOT own MATCHES "^gl/")
      fault("${file}" "includes ${include}; only src/gl may")
    endif()
    own_path("${include}" "${folder}" path)
    if(path STREQUAL "")
      continue()
    endif()
    row_of("${path}" included_row)
    if(included_row STREQUAL "")
      fault("${file}" "includes ${include}, which has no row in the order of includes")
    elseif(included_row GREATER row)
      fault("${file}" "includes ${include}, which stands below it in the order of includes")
    elseif(row EQUAL 6 AND included_row EQUAL 5)
      fault("${file}" "includes ${include}; src/gl and src/cpu know nothing of each other")
    endif()
  endforeach()
  return(PROPAGATE faults)
endfunction()

# Benches and examples are users: the public headers and their own folder.
function(check_user_file file)
  cmake_path(GET file PARENT_PATH folder)
  read_includes("${file}" includes)
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "^<.*|\"" "" path "${include}")
    if(path MATCHES "\\.\\./" OR NOT EXISTS "${folder}/${path}")
      fault("${file}" "includes ${include}; benches and examples include <phymul/...> and files of their own folder")
    endif()
  endforeach()
  return(PROPAGATE faults)
endfunction()

cmake_policy(SET CMP0140 NEW)  # return(PROPAGATE)
file(GLOB_RECURSE public ${ROOT}/include/phymul/*.h)
file(GLOB_RECURSE private ${ROOT}/src/*.h ${ROOT}/src/*.cpp)
file(GLOB_RECURSE users ${ROOT}/bench/*.h ${ROOT}/bench/*.cpp ${ROOT}/examples/*.h ${ROOT}/examples/*.cpp)
if(NOT public OR NOT private OR NOT users)
  message(FATAL_ERROR "no sources under ${ROOT}: nothing was checked")
endif()
foreach(file IN LISTS public)
  check_library_file("${file}" "${ROOT}/include/phymul")
endforeach()
foreach(file IN LISTS private)
  check_library_file("${file}" "${ROOT}/src")
endforeach()
foreach(file IN LISTS users)
  check_user_file("${file}")
endforeach()
report_faults()
