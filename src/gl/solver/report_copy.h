// SPDX-License-Identifier: MIT
//
// ReportCopy: the two rows of a report, and behind them what tools have felt and which volumes were lost, read from the
// device at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "device.h"
#include "gl/objects/handle.h"

namespace phymul::gl {

class ReportCopy {
 public:
  /// `fill` gives the commands that write events, largest and so many rows more, 16 bytes each, to the buffer bound to
  /// GL_PIXEL_PACK_BUFFER. Waits for them.
  template <class Fill>
  BatchReport read(std::int64_t more_rows, Fill&& fill) {
    begin(static_cast<std::size_t>(more_rows));
    fill();
    return end();
  }
  /// The rows behind, of the report last read.
  const std::vector<Float4>& more() const { return more_; }

 private:
  void begin(std::size_t more_rows);
  BatchReport end();
  GLsizeiptr bytes() const;

  Handle<BufferKind> buffer_;
  std::vector<Float4> more_;
};

}  // namespace phymul::gl
