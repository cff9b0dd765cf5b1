// SPDX-License-Identifier: MIT
//
// Program: a vertex and a fragment shader, compiled and linked.
#pragma once

#include "gl/gl_api.h"

#include "shader_source.h"

namespace phymul::gl {

class Program {
 public:
  Program() = default;
  /// Throws Error with the stage, file, line and the driver's log.
  Program(const ShaderLibrary& library, const ShaderRequest& vertex, const ShaderRequest& fragment);
  /// A fragment shader over the rectangle of its target.
  Program(const ShaderLibrary& library, const ShaderRequest& fragment)
      : Program(library, {.files = {"cover_target.glsl"}, .defines = {}}, fragment) {}
  Program(Program&& other) noexcept;
  Program& operator=(Program&& other) noexcept;
  ~Program();

  GLuint id() const { return id_; }
  /// -1 where the shader has no such uniform or does not use it.
  GLint uniform(const char* name) const { return glGetUniformLocation(id_, name); }

 private:
  GLuint id_ = 0;
};

}  // namespace phymul::gl
