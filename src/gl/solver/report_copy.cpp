// SPDX-License-Identifier: MIT
#include "report_copy.h"

#include <cstring>

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

}  // namespace phymul::gl
