// SPDX-License-Identifier: MIT
//
// StorageBuffer: rows of 16 bytes that kernels read and write, and the way back from them.
#pragma once

#include "gl/context/gl_api.h"

#include <cstdint>
#include <iterator>

#include "handle.h"
#include "kernel.h"

namespace phymul::gl {

class StorageBuffer {
 public:
  StorageBuffer() = default;
  /// Of undefined content. Throws Error where it is more than a shader sees, or than the driver has memory for.
  StorageBuffer(std::int64_t rows, const char* name, const ComputeLimits& limits);

  GLuint id() const { return *id_; }
  std::int64_t rows() const { return rows_; }

  void bind(GLuint binding) const { glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, *id_); }
  void write(std::int64_t first_byte, const void* data, std::int64_t bytes);
  /// A vector or a span, to where row `first_row` begins.
  template <class Rows>
  void write_rows(std::int64_t first_row, const Rows& rows) {
    write(16 * first_row, std::data(rows), static_cast<std::int64_t>(std::size(rows) * sizeof(*std::data(rows))));
  }
  /// Rows on the device, to a byte of the buffer bound to `target`, which is not GL_COPY_READ_BUFFER.
  void copy(std::int64_t first_row, std::int64_t rows, GLenum target, std::int64_t to_byte) const;
  /// Waits for the device; by a copy, so that the rows stay where kernels are quick to reach them.
  void read(std::int64_t first_row, std::int64_t rows, void* out) const;

 private:
  Handle<BufferKind> id_;
  std::int64_t rows_ = 0;
};

}  // namespace phymul::gl
