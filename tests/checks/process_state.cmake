# SPDX-License-Identifier: MIT
#
# cmake -DNM=... "-DFILES=libphymul.a;..." -P process_state.cmake: the library prints nothing, and what it keeps for the
# whole process is what is listed here and in docs/guide/hosting.md.
cmake_minimum_required(VERSION 3.25)

# Names of variables. Made once and constant from then on: tables, names of files, functions of EGL.
set(constant hexahedron pyramid quad wedge  # topology/cell_quadrature.cpp
             known                          # io/labels/read_nrrd.cpp: names of units
             one all empty                  # interaction/contact_points.cpp, model/model.cpp; bindings/c/errors.cpp
             common files report_files      # gl: names of shader files
             query get place)               # gl: functions of EGL and GLX; where PHYMUL_GLSL has shaders
# That change; each is safe for threads.
set(changing loaded mutex   # solver/gl_module.cpp, gl/context/gl_functions.cpp: the GL module and GLEW, loaded once
             serial         # base/files.cpp: numbers of temporary files
             one_at_a_time  # io/labels/read_nrrd.cpp: teem's errors are one list
             current_       # gl/objects/pass.h: of a thread, while it draws
             text)          # bindings/c/errors.cpp: phymul_last_error, of a thread

set(faults "")
foreach(file IN LISTS FILES)
  execute_process(COMMAND ${NM} --demangle ${file} OUTPUT_VARIABLE symbols ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE ";" "," symbols "${symbols}")
  string(REPLACE "[abi:cxx11]" "" symbols "${symbols}")  # of clang's names
  string(REGEX MATCHALL "[^\n]+" symbols "${symbols}")
  list(LENGTH symbols count)
  if(count LESS 3)
    message(FATAL_ERROR "${NM} shows no symbols of ${file}: nothing was checked")
  endif()
  foreach(symbol IN LISTS symbols)
    # b, d: memory of this file that may change; B, D, u: of all.
    if(symbol MATCHES " [bBu] (.*phymul.*)$" AND NOT symbol MATCHES " (u phymul::(none|energy_kinds|input_kind)|. guard variable for )")
      string(REGEX REPLACE "^.*::" "" name "${symbol}")
      if(NOT name IN_LIST constant AND NOT name IN_LIST changing)
        string(APPEND faults "  ${file}: ${symbol}: a variable of the whole process that is not listed\n")
      endif()
    elseif(symbol MATCHES " U (_?_?v?f?printf(_chk)?|puts|putchar|putc|fputs|fputc|fwrite|perror|stdout|stderr|std::(cout|cerr|clog))(@.*)?$")
      string(APPEND faults "  ${file}: ${symbol}: prints; SimulationOptions::log and Error are for people\n")
    endif()
  endforeach()
endforeach()
if(faults)
  message(FATAL_ERROR "\n${faults}")
endif()
