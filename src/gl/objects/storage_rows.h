// SPDX-License-Identifier: MIT
//
// StorageRows: tables one after another in a storage buffer, and the uniforms by which kernels find them there.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "storage_buffer.h"

namespace phymul::gl {

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
