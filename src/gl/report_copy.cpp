// SPDX-License-Identifier: MIT
#include "gl/report_copy.h"

#include <phymul/error.h>

#include <cstring>

namespace phymul::gl {
namespace {

struct Rows {
  Int4 events;
  Float4 largest;
};

}  // namespace

void ReportCopy::bind() {
  const bool first = buffer_ == 0;
  if (first) glGenBuffers(1, &buffer_);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer_);
  if (first) glBufferData(GL_PIXEL_PACK_BUFFER, sizeof(Rows), nullptr, GL_STREAM_READ);
}

BatchReport ReportCopy::take() {
  bind();
  Rows rows{};
  if (const void* from = glMapBufferRange(GL_PIXEL_PACK_BUFFER, 0, sizeof rows, GL_MAP_READ_BIT)) {
    std::memcpy(&rows, from, sizeof rows);
    glUnmapBuffer(GL_PIXEL_PACK_BUFFER);
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  return {rows.events, rows.largest};
}

}  // namespace phymul::gl
