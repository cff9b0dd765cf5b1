// SPDX-License-Identifier: MIT
//
// Program: a vertex and a fragment shader, or a compute shader, compiled and linked.
#pragma once

#include "gl/context/gl_api.h"

#include <initializer_list>
#include <string>
#include <vector>

#include "handle.h"
#include "shader_source.h"

namespace phymul::gl {

class Program {
 public:
  Program() = default;
  /// Throws Error with the stage, file, line and the driver's log.
  Program(const ShaderLibrary& library, const ShaderRequest& vertex, const ShaderRequest& fragment);
  /// A fragment shader over the rectangle of its target.
  Program(const ShaderLibrary& library, const ShaderRequest& fragment)
      : Program(library, {.files = {"dialect/cover_target.glsl"}, .defines = {}}, fragment) {}
  /// A compute shader.
  static Program computing(const ShaderLibrary& library, const ShaderRequest& request);

  GLuint id() const { return *id_; }
  /// -1 where the shader has no such uniform or does not use it.
  GLint uniform(const char* name) const { return glGetUniformLocation(*id_, name); }
  /// The same, remembered, for those that are set again and again. Makes the program current.
  GLint use_uniform(const char* name);

 private:
  struct Uniform {
    std::string name;
    GLint location;
  };
  void link(std::initializer_list<GLuint> shaders, const ShaderRequest& named);

  Handle<ProgramKind> id_;
  std::vector<Uniform> uniforms_;
};

}  // namespace phymul::gl
