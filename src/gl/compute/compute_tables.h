// SPDX-License-Identifier: MIT
//
// The constants of a body in storage buffers: SliceTables one after another in one buffer, under the names of
// tables.glsl, and the heights, the largest table, in a buffer of their own where the driver binds enough.
#pragma once

#include <vector>

#include "device/slice_tables.h"
#include "gl/objects/storage_buffer.h"
#include "gl/solver/body_kind.h"

namespace phymul::gl {

/// As dialect_compute.glsl has them.
enum StorageBinding : GLuint {
  constant_rows_binding,
  constant_words_binding,
  changing_binding,
  loads_binding,
  heights_binding
};

class ComputeTables {
 public:
  ComputeTables(const SliceTables& slices, const ComputeLimits& limits);

  const BodyKind& kind() const { return kind_; }
  int places() const { return places_; }  ///< rows of a table by place
  const std::vector<Index>& place_of() const { return place_of_; }

  void bind() const;
  /// What every shader of this body finds defined.
  void define(ShaderRequest& request) const;
  /// Tells a kernel where the tables are.
  void place(Kernel& kernel) const;

 private:
  struct Table {
    const char* name;  ///< of the uniform
    const void* data;
    std::int64_t bytes, first_byte;
    bool by_words;
  };
  template <class Row>
  void add(const char* name, const std::vector<Row>& rows);
  void add_entries(const FloatTables& rows);
  void add_all(const SliceTables& slices);

  BodyKind kind_;
  int places_, slice_;
  std::vector<Index> place_of_;
  bool heights_apart_;
  std::vector<Table> tables_;
  std::int64_t bytes_ = 0;
  std::vector<std::int32_t> entries_;  // while the tables are sent
  int volume_start_ = 0, spring_start_ = 0;
  StorageBuffer constants_, heights_;
};

}  // namespace phymul::gl
