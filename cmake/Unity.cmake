# SPDX-License-Identifier: MIT
#
# Several files compiled as one (PHYMUL_UNITY): their headers and the templates that they share are compiled once.

# Call it when the target has all its files. They are grouped by folder, with paths from the source folder: which files
# share their names then depends neither on the machine nor on the order of lists.
function(phymul_compile_together target)
  if(NOT PHYMUL_UNITY)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  set(folders "")
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source NORMALIZE)
    cmake_path(IS_PREFIX PROJECT_BINARY_DIR ${source} generated)
    if(NOT generated)
      cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE folder)
      cmake_path(GET folder PARENT_PATH folder)
      string(MAKE_C_IDENTIFIER "${folder}" folder)
      list(APPEND folders ${folder})
      list(APPEND of_${folder} ${source})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder IN LISTS folders)
    # Units of one size, so that two processors end together.
    list(LENGTH of_${folder} files)
    math(EXPR units "(${files} + 13) / 14")
    set(index 0)
    foreach(source IN LISTS of_${folder})
      math(EXPR unit "${index} * ${units} / ${files}")
      math(EXPR index "${index} + 1")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${folder}_${unit})
    endforeach()
  endforeach()
endfunction()
