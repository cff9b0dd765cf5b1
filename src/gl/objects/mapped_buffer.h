// SPDX-License-Identifier: MIT
//
// What the device wrote to a buffer, for the processor to read.
#pragma once

#include "gl/context/gl_api.h"

#include <cstddef>
#include <vector>

namespace phymul::gl {

/// Calls use(const void*) with the first `bytes` of the buffer bound to `target`. Waits for the device. False, and not
/// called, where the driver gives none.
template <class Use>
bool read_buffer(GLenum target, GLsizeiptr bytes, Use&& use) {
#ifdef __EMSCRIPTEN__
  // WebGL maps no buffers.
  std::vector<std::byte> copy(static_cast<std::size_t>(bytes));
  glGetBufferSubData(target, 0, bytes, copy.data());
  use(copy.data());
  return true;
#else
  const void* const from = glMapBufferRange(target, 0, bytes, GL_MAP_READ_BIT);
  if (!from) return false;
  use(from);
  glUnmapBuffer(target);
  return true;
#endif
}

}  // namespace phymul::gl
