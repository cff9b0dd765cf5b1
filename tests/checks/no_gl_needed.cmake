# SPDX-License-Identifier: MIT
#
# cmake -DREADELF=... -DFILES=... -P no_gl_needed.cmake: none of the files (a list) needs a library of GL or of a window
# system to be loaded. With -DONLY_SYMBOL=... each shows that one symbol of ours and no other.
cmake_minimum_required(VERSION 3.25)

foreach(file IN LISTS FILES)
  execute_process(COMMAND ${READELF} --wide --dynamic ${file} OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "Shared library: .lib(GL|EGL|OpenGL|X11|xcb|wayland)[^\n]*" needed "${dynamic}")
  if(NOT dynamic MATCHES "Shared library: .libc")
    message(FATAL_ERROR "${file}: ${READELF} shows no needed libraries at all:\n${dynamic}")
  elseif(needed AND NOT ONLY_SYMBOL)
    message(FATAL_ERROR "${file} cannot be loaded on a machine without GL:\n${needed}")
  endif()
  if(ONLY_SYMBOL)
    execute_process(COMMAND ${READELF} --wide --dyn-syms ${file} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL "(GLOBAL|WEAK|UNIQUE) +(DEFAULT|PROTECTED) +[0-9]+ [^\n]*" shown "${symbols}")
    list(TRANSFORM shown REPLACE "^.* " "")
    list(FILTER shown INCLUDE REGEX phymul)
    if(NOT shown STREQUAL ONLY_SYMBOL)
      message(FATAL_ERROR "${file} shows other symbols than ${ONLY_SYMBOL}:\n${shown}")
    endif()
  endif()
endforeach()
