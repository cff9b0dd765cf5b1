// SPDX-License-Identifier: MIT
//
// ReportCopy: the two rows of a report on their way to the host.
#pragma once

#include "gl/gl_api.h"

#include "gl/device.h"

namespace phymul::gl {

class ReportCopy {
 public:
  ReportCopy() = default;
  ReportCopy(const ReportCopy&) = delete;
  ReportCopy& operator=(const ReportCopy&) = delete;
  ~ReportCopy() { glDeleteBuffers(1, &buffer_); }

  /// `fill` gives the commands that write events and largest, 16 bytes each, to the buffer bound to
  /// GL_PIXEL_PACK_BUFFER. Does not wait.
  template <class Fill>
  void request(Fill&& fill) {
    bind();
    fill();
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glFlush();
  }

  /// Waits for what was requested last.
  BatchReport take();

 private:
  void bind();

  GLuint buffer_ = 0;
};

}  // namespace phymul::gl
