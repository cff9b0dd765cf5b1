// SPDX-License-Identifier: MIT
#include "storage_buffer.h"

#include <phymul/error.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "gl/context/context_info.h"
#include "handle.h"
#include "pass.h"

namespace phymul::gl {
namespace {

std::int64_t limit(GLenum name) {
  GLint64 value = 0;
  glGetInteger64v(name, &value);
  return value;
}

std::int64_t groups_along(GLuint axis) {
  GLint count = 0;
  glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, axis, &count);
  return count;
}

ShaderRequest with_group(ShaderRequest request, int group) {
  request.defines.emplace_back("GROUP", group);
  return request;
}

}  // namespace

ComputeLimits ComputeLimits::of_context() {
  return {.block_bytes = limit(GL_MAX_SHADER_STORAGE_BLOCK_SIZE),
          .groups_across = groups_along(0),
          .groups_down = groups_along(1),
          .invocations = static_cast<int>(limit(GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS)),
          .loop_turns = loop_turns_of(gl_text(GL_RENDERER))};
}

Kernel::Kernel(const ShaderLibrary& library, ShaderRequest request, int group, const ComputeLimits& limits)
    : name_(request.name()),
      program_(Program::computing(library, with_group(std::move(request), group))),
      group_(group),
      limits_(limits) {}

void Kernel::dispatch(int groups) {
  if (groups == 0) return;
  const std::int64_t across = std::min<std::int64_t>(groups, limits_.groups_across);
  const std::int64_t down = (groups + across - 1) / across;
  if (down > limits_.groups_down) {
    throw Error(ErrorCode::not_supported,
                "a pass of " + std::to_string(groups) + " groups of " + std::to_string(group_) +
                    " rows is more than the " + std::to_string(limits_.groups_across) + " x " +
                    std::to_string(limits_.groups_down) +
                    " groups that this driver dispatches at a time; use fewer particles or bases");
  }
  glUseProgram(program_.id());
  const PassTimer::Timed timed(name_, PassTimer::Work::dispatch);
  glDispatchCompute(static_cast<GLuint>(across), static_cast<GLuint>(down), 1);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

namespace {

constexpr std::int64_t row_bytes = 16;

std::string megabytes(std::int64_t bytes) {
  return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB";
}

}  // namespace

StorageBuffer::StorageBuffer(std::int64_t rows, const char* name, const ComputeLimits& limits)
    : rows_(std::max<std::int64_t>(rows, 1)) {
  const std::int64_t bytes = rows_ * row_bytes;
  if (bytes > limits.block_bytes) {
    throw Error(ErrorCode::out_of_memory, "the buffer of " + std::string(name) + " takes " + megabytes(bytes) +
                                              "; a shader of this driver sees " + megabytes(limits.block_bytes) +
                                              ". Use fewer particles or bases, or the backend \"cpu\"");
  }
  forget_errors();
  id_ = Handle<BufferKind>(one_name(glGenBuffers));
  glBindBuffer(GL_COPY_WRITE_BUFFER, *id_);
  glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_COPY);
  glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  throw Error(ErrorCode::out_of_memory, "the buffer of " + std::string(name) + ", " + megabytes(bytes) +
                                            ", could not be made; the driver says " + memory_error(error) +
                                            ". Use fewer particles or bases, or a device with more memory");
}

void StorageBuffer::write(std::int64_t first_byte, const void* data, std::int64_t bytes) {
  if (bytes == 0) return;
  glBindBuffer(GL_COPY_WRITE_BUFFER, *id_);
  glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(first_byte), static_cast<GLsizeiptr>(bytes), data);
  glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
}

void StorageBuffer::copy(std::int64_t first_row, std::int64_t rows, GLenum target, std::int64_t to_byte) const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glBindBuffer(GL_COPY_READ_BUFFER, *id_);
  glCopyBufferSubData(GL_COPY_READ_BUFFER, target, static_cast<GLintptr>(first_row * row_bytes),
                      static_cast<GLintptr>(to_byte), static_cast<GLsizeiptr>(rows * row_bytes));
  glBindBuffer(GL_COPY_READ_BUFFER, 0);
}

void StorageBuffer::read(std::int64_t first_row, std::int64_t rows, void* out) const {
  const auto bytes = static_cast<GLsizeiptr>(rows * row_bytes);
  const Handle<BufferKind> staging(one_name(glGenBuffers));
  glBindBuffer(GL_COPY_WRITE_BUFFER, *staging);
  glBufferData(GL_COPY_WRITE_BUFFER, bytes, nullptr, GL_STREAM_READ);
  copy(first_row, rows, GL_COPY_WRITE_BUFFER, 0);
  const bool came = read_buffer(GL_COPY_WRITE_BUFFER, bytes,
                                [&](const void* from) { std::memcpy(out, from, static_cast<std::size_t>(bytes)); });
  glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
  if (!came) throw Error(ErrorCode::device, "the device gave no copy of its rows");
}

std::int64_t StorageRows::take(const std::string& name, std::int64_t rows) {
  const std::int64_t first = end_;
  end_ += rows;
  if (!name.empty()) note(name, static_cast<int>(first));
  return first;
}

std::int64_t StorageRows::take_words(const std::string& name, std::int64_t words) {
  const std::int64_t first = 4 * take({}, rows_of(4 * words));
  note(name, static_cast<int>(first));
  return first;
}

void StorageRows::send(StorageBuffer& buffer) {
  for (const Content& content : contents_) buffer.write(content.first_byte, content.data, content.bytes);
  contents_.clear();
  kept_.clear();
}

void StorageRows::place(Kernel& kernel) const {
  for (const Uniform& uniform : uniforms_) {
    std::visit([&](auto value) { kernel.set(uniform.name.c_str(), value); }, uniform.value);
  }
}

}  // namespace phymul::gl
