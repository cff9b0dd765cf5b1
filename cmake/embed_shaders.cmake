# SPDX-License-Identifier: MIT
#
# cmake -DOUTPUT=shaders.cpp -DROOT=glsl "-DFILES=glsl/step/a.glsl;glsl/step/b.glsl" -P embed_shaders.cmake
# Writes phymul::gl::embedded_shaders (src/gl/objects/program.h): the shaders' text, so that the library needs no files.
set(rows "")
foreach(file IN LISTS FILES)
  file(READ ${file} text)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${ROOT} OUTPUT_VARIABLE name)
  string(LENGTH "${text}" length)
  if(length GREATER 16000)
    message(FATAL_ERROR "${file} has ${length} characters; compilers need to accept string literals of 16 kB only")
  endif()
  string(APPEND rows "    {\"${name}\", R\"glsl(${text})glsl\"},\n")
endforeach()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
// Made by cmake/embed_shaders.cmake.
#include "gl/objects/program.h"

namespace phymul::gl {

extern const EmbeddedShader embedded_shaders[] = {
@rows@    {nullptr, nullptr},
};

}  // namespace phymul::gl
]])
