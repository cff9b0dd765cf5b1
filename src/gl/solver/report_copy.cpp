// SPDX-License-Identifier: MIT
#include "report_copy.h"

#include <phymul/error.h>

#include <cstring>
#include <limits>

#include "gl/objects/mapped_buffer.h"

namespace phymul::gl {
namespace {

struct Rows {
  Int4 events;
  Float4 largest;
};

}  // namespace

void ReportCopy::begin(std::size_t more_rows) {
  const bool fits = buffer_ && more_rows == more_.size();
  more_.resize(more_rows);
  if (!buffer_) buffer_ = Handle<BufferKind>(one_name(glGenBuffers));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, *buffer_);
  if (!fits) glBufferData(GL_PIXEL_PACK_BUFFER, bytes(), nullptr, GL_STREAM_READ);
}

GLsizeiptr ReportCopy::bytes() const {
  return static_cast<GLsizeiptr>(sizeof(Rows) + more_.size() * sizeof(Float4));
}

BatchReport ReportCopy::end() {
  Rows rows{};
  read_buffer(GL_PIXEL_PACK_BUFFER, bytes(), [&](const void* from) {
    std::memcpy(&rows, from, sizeof rows);
    if (!more_.empty())
      std::memcpy(more_.data(), static_cast<const char*>(from) + sizeof rows, more_.size() * sizeof(Float4));
  });
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  return {rows.events, rows.largest};
}

BatchReport::BatchReport(const Int4& events, const Float4& largest)
    : max_speed(largest[0]), max_acceleration(largest[1]), max_force(largest[2]), max_displacement(largest[3]) {
  constexpr std::int32_t never = std::numeric_limits<std::int32_t>::max();
  if (events[0] < 1) throw Error(ErrorCode::device, "the device gave no report of its steps");
  cut = events[0] == never - 1;
  if (events[0] < never - 1) {
    runaway_step = events[0];
    particle = events[1];
  }
  first_unquiet = events[2] == never ? 0 : events[2];
  last_unquiet = events[3];
}

void BatchReport::see_volumes(std::span<const Float4> roots) {
  for (std::size_t row = 0; row < roots.size(); ++row) {
    const int step = static_cast<int>(roots[row][1]);
    if (step == 0 || (lost_step > 0 && lost_step <= step)) continue;
    lost_step = step;
    lost_volume = static_cast<int>(row);
  }
}

}  // namespace phymul::gl
