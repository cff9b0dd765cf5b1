# SPDX-License-Identifier: MIT
#
# What a shared libphymul.so shows: what the public headers declare, under one version, and nothing else. No header has
# a macro for it: every source is compiled with hidden symbols, after a header that declares the public ones visible.
# Their instances of the standard library's templates, which GCC shows whatever it is told, are the linker's to hide.

# Programs need the library; what a compiler needs besides is for developers.
function(phymul_install_library target)
  install(TARGETS ${target} EXPORT phymulTargets RUNTIME COMPONENT runtime
                                                 LIBRARY COMPONENT runtime NAMELINK_COMPONENT dev
                                                 ARCHIVE COMPONENT dev)
endfunction()

# phymul_inside: the same objects as a static library that hides nothing. For the tests of the inside and for the GL
# module, which carries what it needs of the core in both kinds of builds.
function(phymul_hide_symbols)
  get_target_property(type phymul TYPE)
  if(NOT type STREQUAL "SHARED_LIBRARY")
    add_library(phymul_inside ALIAS phymul)
    return()
  endif()
  set_target_properties(phymul PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)

  file(GLOB headers CONFIGURE_DEPENDS include/phymul/*.h)
  set(includes "")
  set(foreign "")
  foreach(header IN LISTS headers)
    cmake_path(GET header FILENAME name)
    string(APPEND includes "#include <phymul/${name}>\n")
    # Before the others: what is declared first hidden stays hidden.
    file(STRINGS ${header} lines REGEX "^#include <[^/>]+>|^#include <Eigen/")
    list(APPEND foreign ${lines})
  endforeach()
  list(REMOVE_DUPLICATES foreign)
  list(JOIN foreign "\n" foreign)
  set(shown ${PROJECT_BINARY_DIR}/headers/shown.h)
  file(CONFIGURE OUTPUT ${shown} @ONLY CONTENT "// Made by cmake/SharedLibrary.cmake.
#pragma once
#ifndef PHYMUL_KERNELS_OF_ONE_INSTRUCTION_SET
@foreign@
#pragma GCC visibility push(default)
@includes@#pragma GCC visibility pop
#endif
")
  target_precompile_headers(phymul PRIVATE ${shown})
  if(CMAKE_DISABLE_PRECOMPILE_HEADERS)
    target_compile_options(phymul PRIVATE -include ${shown})
  endif()

  set(map ${PROJECT_BINARY_DIR}/headers/phymul.map)
  configure_file(cmake/phymul.map.in ${map} @ONLY)
  target_link_options(phymul PRIVATE LINKER:--version-script=${map} LINKER:--no-undefined)
  set_property(TARGET phymul APPEND PROPERTY LINK_DEPENDS ${map})

  add_library(phymul_inside STATIC $<TARGET_OBJECTS:phymul>)
  set_target_properties(phymul_inside PROPERTIES LINKER_LANGUAGE CXX)
  target_include_directories(phymul_inside INTERFACE $<TARGET_PROPERTY:phymul,INTERFACE_INCLUDE_DIRECTORIES>)
  target_compile_features(phymul_inside PUBLIC cxx_std_20)
  target_link_libraries(phymul_inside PUBLIC $<GENEX_EVAL:$<TARGET_PROPERTY:phymul,LINK_LIBRARIES>>)
endfunction()
