# SPDX-License-Identifier: MIT
#
# The order of includes. A file of a row may include files of its own row and the rows above it; a forward declaration
# does for the rest (topology.h and TopologyTextures). Public headers, and what shares their names, have fixed rows. Any
# other private header is as low as the lowest it includes itself, and any other source of src/ belongs to the core.
include(${CMAKE_CURRENT_LIST_DIR}/faults.cmake)

# Name without extension, or its beginning up to an underscore. The first match counts.
set(rows
    "7 backends"                  # the table of backends; sees them all, nothing sees what it includes
    "3 topology_textures"         # before topology
    "4 state_file recording"      # before state
    "4 gl_module"                 # before gl; the door to src/gl
    "0 version types error gl camera"
    "1 model load scene state surface tool needle virtual distance"
    "2 shapes pml lml mesh check topology monitor writer"
    "2 xml byte gmsh vtk vtu csv"            # formats, behind the readers
    "4 elasticity solver step backend display bodies"
    "8 phymul")                   # the umbrella, for users only
set(core_row 4)
set(cpu_row 5)
set(gl_row 6)

# Row of a file of include/phymul or src; empty: a public header without one.
function(row_of file result)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${ROOT}" OUTPUT_VARIABLE own)
  cmake_path(GET file STEM stem)
  set(row "")
  if(own MATCHES "^src/cpu/")
    set(row ${cpu_row})
  elseif(own MATCHES "^src/gl/")
    set(row ${gl_row})
  elseif(own MATCHES "^src/topology/topology(_[a-z_]+)?\\.")
    set(row 3)  # makes what the public topology.h only declares
  else()
    foreach(known_row IN LISTS rows)
      string(REPLACE " " ";" stems "${known_row}")
      list(POP_FRONT stems number)
      foreach(known IN LISTS stems)
        if(row STREQUAL "" AND stem MATCHES "^${known}(_|$)")
          set(row ${number})
        endif()
      endforeach()
    endforeach()
  endif()
  if(row STREQUAL "" AND own MATCHES "^src/.*\\.cpp$")
    set(row ${core_row})
  elseif(row STREQUAL "" AND own MATCHES "^src/")
    lowest_included("${file}" row)
  endif()
  set(${result} "${row}" PARENT_SCOPE)
endfunction()

# The greatest row among the files a file includes; 0 where it includes none of ours.
function(lowest_included file result)
  set(lowest 0)
  read_includes("${file}" includes)
  foreach(include IN LISTS includes)
    own_file("${include}" "${file}" included)
    if(included)
      row_of("${included}" row)
      if(row GREATER lowest)
        set(lowest ${row})
      endif()
    endif()
  endforeach()
  set(${result} ${lowest} PARENT_SCOPE)
endfunction()

# The file an include means, if it is one of ours; else empty.
function(own_file include includer result)
  cmake_path(GET includer PARENT_PATH folder)
  set(file "")
  if(include MATCHES "^<(phymul/.*)>$")
    set(file "${ROOT}/include/${CMAKE_MATCH_1}")
  elseif(include MATCHES "^\"(.*)\"$")
    set(file "${folder}/${CMAKE_MATCH_1}")
    if(NOT EXISTS "${file}")
      set(file "${ROOT}/src/${CMAKE_MATCH_1}")
    endif()
    cmake_path(NORMAL_PATH file)
  endif()
  set(${result} "${file}" PARENT_SCOPE)
endfunction()

function(check_library_file file)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${ROOT}" OUTPUT_VARIABLE own)
  row_of("${file}" row)
  if(row STREQUAL "")
    fault("${file}" "has no row in the order of includes; give it one in tests/checks/layering.cmake")
    return(PROPAGATE faults)
  endif()
  read_includes("${file}" includes)
  foreach(include IN LISTS includes)
    if(include STREQUAL "<pugixml.hpp>" AND NOT own MATCHES "^src/(xml|pml|lml|vtu)_[a-z_]*\\.(h|cpp)$")
      fault("${file}" "includes pugixml; only src/xml_*, pml_*, lml_* and vtu_* may")
    elseif(include MATCHES "^<(GL|EGL|GLES[23]?)/" AND NOT own MATCHES "^src/gl/")
      fault("${file}" "includes ${include}; only src/gl may")
    endif()
    own_file("${include}" "${file}" included)
    if(NOT included)
      continue()
    endif()
    row_of("${included}" included_row)
    if(included_row STREQUAL "")
      continue()  # a fault of that file
    elseif(included_row GREATER row)
      fault("${file}" "includes ${include}, which stands below it in the order of includes")
    elseif(row EQUAL gl_row AND included_row EQUAL cpu_row)
      fault("${file}" "includes ${include}; src/gl and src/cpu know nothing of each other")
    endif()
  endforeach()
  return(PROPAGATE faults)
endfunction()

# Benches and examples are users: the public headers and their own folder; benches share the tests' bodies, and those
# named for src/cpu look into it.
function(check_user_file file)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${ROOT}" OUTPUT_VARIABLE own)
  cmake_path(GET file PARENT_PATH folder)
  read_includes("${file}" includes)
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "^<.*|\"" "" path "${include}")
    if(path MATCHES "^[a-z_]+\\.h$" AND own MATCHES "^bench/" AND EXISTS "${ROOT}/tests/${path}")
      continue()
    endif()
    if(own MATCHES "^bench/cpu_" AND path MATCHES "^cpu/[a-z_/]+\\.h$" AND EXISTS "${ROOT}/src/${path}")
      continue()
    endif()
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
foreach(file IN LISTS public private)
  check_library_file("${file}")
endforeach()
foreach(file IN LISTS users)
  check_user_file("${file}")
endforeach()
report_faults()
