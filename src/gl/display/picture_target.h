// SPDX-License-Identifier: MIT
//
// PictureTarget: a framebuffer for one picture, several pixels a pixel, whose mean smooths every kind of edge: those of
// triangles, of balls that a shader cuts out, of dashes.
#pragma once

#include <phymul/display.h>

#include "gl/context/gl_api.h"

namespace phymul::gl {

class PictureTarget {
 public:
  /// Throws Error where the driver has no room for it.
  PictureTarget(int width, int height);
  PictureTarget(const PictureTarget&) = delete;
  PictureTarget& operator=(const PictureTarget&) = delete;
  ~PictureTarget();

  GLuint framebuffer() const { return framebuffer_; }
  int factor() const { return factor_; }  ///< pixels of the target along a side of a pixel of the picture

  /// Waits for the device.
  Image read() const;

 private:
  void release() noexcept;

  int width_, height_, factor_;
  GLuint framebuffer_ = 0;
  GLuint buffers_[2] = {0, 0};  // colour, depth
};

}  // namespace phymul::gl
