// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "context_info.h"
#include "gl_api.h"

namespace phymul::gl {

/// Of the current context, all that the passes and the drawing of phymul touch or depend on. The constructor notes the
/// host's values and sets those of a fresh context; the destructor sets the host's again. What belongs to an object
/// (draw buffers to a framebuffer, parameters to a texture) needs no saving: phymul has objects of its own.
/// A host calls outside of its own active queries, conditional rendering and transform feedback.
class StateGuard {
 public:
  /// Of 2D and 2D array textures, and samplers. OpenGL 3.3 and OpenGL ES 3.0 promise as many to a shader.
  static constexpr int texture_units = 16;
  static constexpr int uniform_buffers = 4;  ///< indexed bindings
  static constexpr int storage_buffers = 4;  ///< indexed bindings, where there are any

  explicit StateGuard(const ContextInfo& info);
  ~StateGuard();
  StateGuard(const StateGuard&) = delete;
  StateGuard& operator=(const StateGuard&) = delete;

 private:
  /// To be done by the destructor, the last first.
  template <class Restore>
  void later(Restore restore) {
    restore_.emplace_back(restore);
  }
  /// Notes an integer, and gives it to set() in the end.
  template <class Set>
  void keep(GLenum name, Set set);

  void keep_bindings();
  void keep_units();
  void keep_indexed_buffers(GLenum target, GLenum binding, GLenum start, GLenum size, GLint count);
  void keep_numbers();
  void keep_clip_control();
  void keep_desktop_numbers();
  void keep_draw_buffers();
  void keep_switches();
  void keep_pixel_stores();

  const ContextInfo& info_;
  std::vector<std::function<void()>> restore_;
};

}  // namespace phymul::gl
