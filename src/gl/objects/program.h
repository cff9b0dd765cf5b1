// SPDX-License-Identifier: MIT
//
// Program: a vertex and a fragment shader, or a compute shader, compiled and linked. The text of shaders: files of
// glsl/ joined under a head for the dialect, each line traceable to its file.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gl/context/gl_api.h"
#include "handle.h"

namespace phymul::gl {

struct EmbeddedShader {
  const char* name;  ///< file name in glsl/
  const char* text;
};

/// Every file of glsl/ as it was when the library was built; made by cmake/embed_shaders.cmake. Ends with a null name.
extern const EmbeddedShader embedded_shaders[];

/// What is asked of a shader: files in order, and what they find defined.
struct ShaderRequest {
  std::vector<std::string> files;
  std::vector<std::pair<std::string, int>> defines;

  std::string name() const;  ///< of its last file, without the ending: the others are parts of it
};

enum class Stage { drawing, compute };

class ShaderLibrary {
 public:
  /// `folder`: files are read from there; empty: from PHYMUL_GLSL, or those built in. `es`: OpenGL ES, else desktop GL.
  /// What is drawn is of GL 3.3 or ES 3.0; what is computed of GL 4.3 or, where it `has_precise`, ES 3.2, else 3.1.
  ShaderLibrary(std::string folder, bool es, bool has_precise = true);

  /// Throws Error when a file does not exist.
  std::string text(const ShaderRequest& request, Stage stage = Stage::drawing) const;

  /// A driver's log of a text() of this request, with "file:line" for its lines.
  static std::string readable(std::string_view log, const ShaderRequest& request);

 private:
  std::string file(const std::string& name) const;
  std::string folder_;
  bool es_, has_precise_;
};

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
