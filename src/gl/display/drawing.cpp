// SPDX-License-Identifier: MIT
#include "drawing.h"

#include <algorithm>

namespace phymul::gl {

void Drawing::use() {
  glUseProgram(program_.id());
  units_ = 0;
}

void Drawing::input(const std::string& name, const TextureView& texture) {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + units_));
  glBindTexture(GL_TEXTURE_2D, texture.id);
  set(name.c_str(), units_++);
  set((name + "_log2").c_str(), texture.log2_width);
}

void Drawing::draw(std::size_t count) {
  // gl_VertexID is an int, and so is a count: beyond that many, another call would have to say where it starts.
  constexpr std::size_t most = 357'913'941;
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * std::min(count, most)));
}

}  // namespace phymul::gl
