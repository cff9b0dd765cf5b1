// SPDX-License-Identifier: MIT
//
// StorageBuffer: rows of 16 bytes that kernels read and write, and the way back from them. Kernel: a compute program,
// ready to be dispatched, and what the context allows of storage and dispatches.
#pragma once

#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "gl/context/gl_api.h"
#include "handle.h"
#include "program.h"

namespace phymul::gl {

struct ComputeLimits {
  std::int64_t block_bytes = 0;  ///< of a storage buffer that a shader sees
  std::int64_t groups_across = 0, groups_down = 0;
  int invocations = 0;                                                 ///< of a group
  std::int64_t loop_turns = std::numeric_limits<std::int64_t>::max();  ///< ContextInfo::loop_turns

  static ComputeLimits of_context();
};

class Kernel {
 public:
  Kernel() = default;
  /// `group` invocations a group, which the shader knows as GROUP.
  Kernel(const ShaderLibrary& library, ShaderRequest request, int group, const ComputeLimits& limits);

  explicit operator bool() const { return program_.id() != 0; }
  int group() const { return group_; }

  /// For uniforms, which stay. Makes the program current.
  void set(const char* name, int value) { glUniform1i(program_.use_uniform(name), value); }
  void set(const char* name, float value) { glUniform1f(program_.use_uniform(name), value); }

  /// Groups that hold as many invocations.
  int groups_for(std::int64_t rows) const { return static_cast<int>((rows + group_ - 1) / group_); }
  /// So many groups or more, as a rectangle where they are too many for a line. What it writes is seen by the next one.
  void dispatch(int groups);

 private:
  std::string name_;
  Program program_;
  int group_ = 1;
  ComputeLimits limits_;
};

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

/// Tables one after another in a storage buffer, and the uniforms by which kernels find them there.
class StorageRows {
 public:
  std::int64_t end() const { return end_; }

  /// Room for so many rows of 16 bytes. Kernels know the first, which is returned, as `name`; empty: they do not.
  std::int64_t take(const std::string& name, std::int64_t rows);
  /// The same for words, by the first word.
  std::int64_t take_words(const std::string& name, std::int64_t words);

  // Room for a table that send() writes, by its first row or by its first word. One that is no temporary must live
  // until then.
  template <class Row>
  std::int64_t add(const std::string& name, const std::vector<Row>& table) {
    const std::int64_t bytes = static_cast<std::int64_t>(table.size() * sizeof(Row)), row = take(name, rows_of(bytes));
    contents_.push_back({16 * row, table.data(), bytes});
    return row;
  }
  template <class Row>
  std::int64_t add(const std::string& name, std::vector<Row>&& table) {
    const auto kept = std::make_shared<const std::vector<Row>>(std::move(table));
    kept_.push_back(kept);
    return add(name, *kept);
  }
  template <class Table>
  std::int64_t add_words(const std::string& name, Table&& table) {
    const std::int64_t row = add({}, std::forward<Table>(table));
    note(name, static_cast<int>(4 * row));
    return 4 * row;
  }

  /// Any other uniform that kernels of these tables know.
  void note(const std::string& name, std::variant<int, float> value) { uniforms_.push_back({name, value}); }

  /// Writes the tables, and forgets where they came from.
  void send(StorageBuffer& buffer);
  void place(Kernel& kernel) const;

 private:
  struct Content {
    std::int64_t first_byte;
    const void* data;
    std::int64_t bytes;
  };
  struct Uniform {
    std::string name;
    std::variant<int, float> value;
  };
  static std::int64_t rows_of(std::int64_t bytes) { return (bytes + 15) / 16; }

  std::int64_t end_ = 0;
  std::vector<Uniform> uniforms_;
  std::vector<Content> contents_;
  std::vector<std::shared_ptr<const void>> kept_;
};

}  // namespace phymul::gl
