// SPDX-License-Identifier: MIT
//
// A scene's loads in a storage buffer: gravity per instant, index, parts and values, one after another.
#pragma once

#include "gl/compute_tables.h"
#include "gl/load_table.h"

namespace phymul::gl {

class ComputeLoads {
 public:
  /// Room for the values of as many instants.
  ComputeLoads(const Scene& scene, int instants, const ComputeTables& tables, const ComputeLimits& limits);

  const LoadKind& kind() const { return table_.kind(); }

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  void bind() const { buffer_.bind(loads_binding); }
  void place(Kernel& kernel) const;

 private:
  LoadTable table_;
  std::int64_t index_row_, parts_row_, values_row_;
  StorageBuffer buffer_;
};

}  // namespace phymul::gl
