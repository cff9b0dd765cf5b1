// SPDX-License-Identifier: MIT
//
// ReportCopy: the two rows of a report on their way to the host, and behind them what tools have felt, which volumes
// were lost, how needles are and how many phases contacts took.
#pragma once

#include "gl/context/gl_api.h"

#include <vector>

#include "device.h"

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

  /// From the next request on `fill` writes so many rows behind the two.
  void carry(std::size_t more_rows);

  /// Waits for what was requested last.
  BatchReport take();
  /// The rows behind, of the report last taken.
  const std::vector<Float4>& more() const { return more_; }

 private:
  void bind();
  GLsizeiptr bytes() const;

  GLuint buffer_ = 0;
  std::vector<Float4> more_;
};

}  // namespace phymul::gl
