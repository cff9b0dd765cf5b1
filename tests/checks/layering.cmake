# SPDX-License-Identifier: MIT
#
# The order of includes is the order of rooms: a file may include files of its own room and of the rooms above it. The
# room of a private file is its folder below src/; that of a public header is in the table. Also: who may see which
# library, how many entries src/ has and how many files a folder.
include(${CMAKE_CURRENT_LIST_DIR}/faults.cmake)
cmake_policy(SET CMP0140 NEW)  # return(PROPAGATE)

# Each row: a room, then the public headers it defines.
set(rooms
    "base types error version task_runner"
    "model model body_cut shapes check surface skin state state_transfer monitor distance_grid tool needle blade tearing joint thread fluid"
    "body body labels surface_patch wall"
    "scene scene load load_frame bodies"
    "io pml lml mesh surface_file label_file writer"
    "topology topology topology_textures"
    "elastic elasticity material_fit step_limit"
    "interaction virtual_coupling jaws"
    "solver gl solver solver_options step_report backend"
    "statics statics"
    "session recording state_file simulation plan"
    "device"
    "view camera display"
    "cpu"
    "gl"
    "users phymul")
set(sees_all_rooms src/solver/backends.cpp)  # the table of backends
set(most_entries 15)                         # of src/
set(most_files 45)                           # of a folder

# Place of a file in the order; empty: a public header that the table does not know.
function(place_of file result)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${ROOT}" OUTPUT_VARIABLE own)
  cmake_path(GET file STEM stem)
  set(found "")
  set(place 0)
  foreach(row IN LISTS rooms)
    string(REPLACE " " ";" headers "${row}")
    list(POP_FRONT headers room)
    if(own MATCHES "^src/${room}/" OR (own MATCHES "^include/" AND stem IN_LIST headers))
      set(found ${place})
    endif()
    math(EXPR place "${place} + 1")
  endforeach()
  set(${result} "${found}" PARENT_SCOPE)
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
  place_of("${file}" place)
  if(place STREQUAL "")
    fault("${file}" "is in no room; rooms are listed in tests/checks/layering.cmake")
    return(PROPAGATE faults)
  endif()
  read_includes("${file}" includes)
  foreach(include IN LISTS includes)
    if(include STREQUAL "<pugixml.hpp>" AND NOT own MATCHES "^src/io/")
      fault("${file}" "includes pugixml; only src/io may")
    elseif(include MATCHES "^<(assimp|nifti|teem)/" AND NOT own MATCHES "^src/io/")
      fault("${file}" "includes ${include}; only src/io may")
    elseif(include MATCHES "^<(GL|EGL|GLES[23]?)/" AND NOT own MATCHES "^src/gl/")
      fault("${file}" "includes ${include}; only src/gl may")
    endif()
    own_file("${include}" "${file}" included)
    if(NOT included)
      continue()
    endif()
    cmake_path(RELATIVE_PATH included BASE_DIRECTORY "${ROOT}" OUTPUT_VARIABLE included_own)
    place_of("${included}" included_place)
    if(included_place STREQUAL "" OR own STREQUAL sees_all_rooms)
      continue()
    elseif(included_place GREATER place)
      fault("${file}" "includes ${include}, of a room below its own")
    elseif(own MATCHES "^src/gl/" AND included_own MATCHES "^src/cpu/")
      fault("${file}" "includes ${include}; src/gl and src/cpu know nothing of each other")
    endif()
  endforeach()
  return(PROPAGATE faults)
endfunction()

# Benches, examples and bindings are users: the public headers and their own folder; benches share the tests' bodies,
# those named for src/cpu look into it, and studies share the benches' expressions. The page and studies share
# what other examples make.
function(check_user_file file)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${ROOT}" OUTPUT_VARIABLE own)
  cmake_path(GET file PARENT_PATH folder)
  read_includes("${file}" includes)
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "^<.*|\"" "" path "${include}")
    if(own MATCHES "^bench/" AND path MATCHES "^(support|stability)/[a-z_]+\\.h$" AND EXISTS "${ROOT}/tests/${path}")
      continue()
    endif()
    if(own MATCHES "^bench/cpu_" AND path MATCHES "^cpu/[a-z_/]+\\.h$" AND EXISTS "${ROOT}/src/${path}")
      continue()
    endif()
    if(own MATCHES "^examples/study/" AND path STREQUAL "expression.h" AND EXISTS "${ROOT}/bench/${path}")
      continue()
    endif()
    if(own MATCHES "^examples/(browser|study)/" AND path MATCHES "^[a-z_]+\\.h$" AND EXISTS "${ROOT}/examples/${path}")
      continue()
    endif()
    if(path MATCHES "\\.\\./" OR NOT EXISTS "${folder}/${path}")
      fault("${file}" "includes ${include}; users of the library include <phymul/...> and files of their own folder")
    endif()
  endforeach()
  return(PROPAGATE faults)
endfunction()

file(GLOB_RECURSE public ${ROOT}/include/phymul/*.h)
file(GLOB_RECURSE private ${ROOT}/src/*.h ${ROOT}/src/*.cpp)
file(GLOB_RECURSE users ${ROOT}/bench/*.h ${ROOT}/bench/*.cpp ${ROOT}/examples/*.h ${ROOT}/examples/*.cpp
     ${ROOT}/bindings/*.h ${ROOT}/bindings/*.cpp)
if(NOT public OR NOT private OR NOT users)
  message(FATAL_ERROR "no sources under ${ROOT}: nothing was checked")
endif()
foreach(file IN LISTS public private)
  check_library_file("${file}")
endforeach()
foreach(file IN LISTS users)
  check_user_file("${file}")
endforeach()

file(GLOB entries ${ROOT}/src/*)
list(LENGTH entries count)
if(count GREATER most_entries)
  fault("${ROOT}/src" "has ${count} entries, more than ${most_entries}")
endif()
file(GLOB_RECURSE all LIST_DIRECTORIES true ${ROOT}/src/* ${ROOT}/glsl/* ${ROOT}/tests/*)
foreach(folder IN LISTS all)
  if(IS_DIRECTORY "${folder}")
    file(GLOB here LIST_DIRECTORIES false "${folder}/*")
    list(LENGTH here count)
    if(count GREATER most_files)
      fault("${folder}" "has ${count} files, more than ${most_files}")
    endif()
  endif()
endforeach()
report_faults()
