# SPDX-License-Identifier: MIT
#
# Public headers know Eigen and the standard library only: who uses phymul needs no other package's headers.
include(${CMAKE_CURRENT_LIST_DIR}/faults.cmake)

file(GLOB_RECURSE headers ${ROOT}/include/*.h)
if(NOT headers)
  message(FATAL_ERROR "no header under ${ROOT}/include")
endif()
foreach(header IN LISTS headers)
  read_includes("${header}" includes)
  foreach(include IN LISTS includes)
    # The standard library's headers have neither a folder nor an extension.
    if(NOT include MATCHES "^<(phymul/[a-z_]+\\.h|Eigen/[A-Za-z]+|[a-z_0-9]+)>$")
      fault("${header}" "includes ${include}; public headers include <phymul/...>, <Eigen/...> and the standard library")
    endif()
  endforeach()

  # Without comments, which may well speak of them.
  file(READ "${header}" text)
  string(REGEX REPLACE "//[^\n]*" "" text "${text}")
  string(REGEX MATCH "pugi::|#[ \t]*pragma[ \t]+omp|[^A-Za-z_](GL(u?int|enum|sizei)|EGL[A-Z][A-Za-z]+|glew[A-Z]|z_stream|gzFile)[^A-Za-z_]"
               foreign "${text}")
  if(foreign)
    string(STRIP "${foreign}" foreign)
    fault("${header}" "mentions ${foreign}, which belongs to another library")
  endif()
endforeach()
report_faults()
