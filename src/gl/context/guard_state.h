// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <utility>
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
  static constexpr int texture_units = 16;   ///< of 2D and 2D array textures, and samplers
  static constexpr int uniform_buffers = 4;  ///< indexed bindings
  static constexpr int storage_buffers = 5;  ///< indexed bindings, where there are any

  explicit StateGuard(const ContextInfo& info);
  ~StateGuard();
  StateGuard(const StateGuard&) = delete;
  StateGuard& operator=(const StateGuard&) = delete;

 private:
  struct Unit {
    GLint texture_2d = 0, texture_2d_array = 0, sampler = 0;
  };
  struct IndexedBuffer {
    GLint name = 0;
    GLint64 start = 0, size = 0;
  };
  struct DrawBuffer {
    std::array<GLboolean, 4> mask{};
    GLboolean blend = GL_FALSE;
  };

  void save_objects();
  void save_units();
  void save_indexed_buffers();
  void save_draw_buffers();
  void save_switches();
  void save_pixels();
  void set_defaults();
  void restore_objects() const;
  void restore_units() const;
  void restore_indexed_buffers() const;
  void restore_draw_buffers() const;
  void restore_pixels() const;
  bool has_indexed_switches() const;

  const ContextInfo& info_;
  GLint program_ = 0, vertex_array_ = 0, draw_framebuffer_ = 0, read_framebuffer_ = 0, renderbuffer_ = 0;
  GLint active_unit_ = 0;
  std::array<GLint, 4> viewport_{}, scissor_{};
  std::array<GLfloat, 4> clear_color_{};
  GLboolean depth_mask_ = GL_TRUE;
  GLint depth_function_ = GL_LESS;
  GLfloat clear_depth_ = 1.0f;
  std::array<GLfloat, 2> depth_range_{0.0f, 1.0f};
  GLint clip_origin_ = 0, clip_depth_ = 0;  ///< where the context has a choice
  std::array<GLint, 2> polygon_mode_{GL_FILL, GL_FILL};
  GLint clamp_read_ = 0, clamp_fragment_ = 0;
  std::vector<std::pair<GLenum, GLint>> buffers_;  ///< target, name
  std::vector<Unit> units_;
  std::vector<IndexedBuffer> uniform_buffers_, storage_buffers_;
  std::vector<DrawBuffer> draw_buffers_;
  std::vector<std::pair<GLenum, GLboolean>> switches_;  ///< glEnable's
  std::vector<std::pair<GLenum, GLint>> pixels_;        ///< glPixelStore's
};

}  // namespace phymul::gl
