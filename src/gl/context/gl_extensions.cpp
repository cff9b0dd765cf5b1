// SPDX-License-Identifier: MIT
#include <algorithm>

#include "gl_api.h"
#include "gl_functions.h"

namespace phymul::gl {

std::vector<std::string> gl_extensions() {
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  std::vector<std::string> names;
  for (GLint i = 0; i < count; ++i) {
    if (const GLubyte* name = glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))) {
      names.emplace_back(reinterpret_cast<const char*>(name));
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool contains(const std::vector<std::string>& sorted, std::string_view name) {
  return std::binary_search(sorted.begin(), sorted.end(), name);
}

}  // namespace phymul::gl
