// SPDX-License-Identifier: MIT
//
// Handle: the name of one GL object, which is deleted with it. Lives and dies in a current context.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "gl/context/gl_api.h"

namespace phymul::gl {

/// Kind::remove(name) deletes.
template <class Kind>
class Handle {
 public:
  Handle() = default;
  explicit Handle(GLuint name) : name_(name) {}
  Handle(Handle&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~Handle() {
    if (name_ != 0) Kind::remove(name_);
  }

  GLuint operator*() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  GLuint name_ = 0;
};

/// The one name that `make`, a function like glGenBuffers, gives.
template <class Make>
GLuint one_name(Make make) {
  GLuint name = 0;
  make(1, &name);
  return name;
}

struct BufferKind {
  static void remove(GLuint name) { glDeleteBuffers(1, &name); }
};
struct FramebufferKind {
  static void remove(GLuint name) { glDeleteFramebuffers(1, &name); }
};
struct ProgramKind {
  static void remove(GLuint name) { glDeleteProgram(name); }
};
struct ShaderKind {
  static void remove(GLuint name) { glDeleteShader(name); }
};
struct TextureKind {
  static void remove(GLuint name) { glDeleteTextures(1, &name); }
};
struct VertexArrayKind {
  static void remove(GLuint name) { glDeleteVertexArrays(1, &name); }
};

// What the device wrote to a buffer, for the processor to read.

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
