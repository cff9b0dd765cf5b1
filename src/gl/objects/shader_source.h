// SPDX-License-Identifier: MIT
//
// The text of shaders: files of glsl/ joined under a head for the dialect, each line traceable to its file.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

}  // namespace phymul::gl
