// SPDX-License-Identifier: MIT
//
// The constants of a body in a storage buffer: SliceTables one after another, under the names of tables.glsl.
#pragma once

#include <vector>

#include "device/slice_tables.h"
#include "gl/objects/storage_rows.h"
#include "gl/solver/body_kind.h"

namespace phymul::gl {

constexpr int lanes = 64;  ///< of a group of invocations, where groups are many

/// As dialect_compute.glsl has them.
enum StorageBinding : GLuint { constant_rows_binding, constant_words_binding, changing_binding, loads_binding };

class ComputeTables {
 public:
  ComputeTables(const SliceTables& slices, const ComputeLimits& limits);

  const BodyKind& kind() const { return kind_; }
  int places() const { return places_; }  ///< rows of a table by place
  const std::vector<Index>& place_of() const { return place_of_; }
  const std::vector<Index>& materials() const { return materials_; }  ///< of domains, by row

  /// A table by particles of the model, so many rows each, in the order of places; `nobody`: rows of no particle.
  template <class Row>
  std::vector<Row> by_place(const std::vector<Row>& by_particle, std::size_t rows_each = 1, Row nobody = {}) const {
    std::vector<Row> rows(rows_each * static_cast<std::size_t>(places_), nobody);
    for (std::size_t k = 0; k < by_particle.size(); ++k) {
      rows[rows_each * static_cast<std::size_t>(place_of_[k / rows_each]) + k % rows_each] = by_particle[k];
    }
    return rows;
  }

  /// Rows whose first numbers, so many, are particles of the model, with their places instead.
  std::vector<Int4> placed(std::vector<Int4> rows, std::size_t particles) const;

  void bind() const;
  /// What every shader of this body finds defined.
  void define(ShaderRequest& request) const;
  /// Tells a kernel where the tables are.
  void place(Kernel& kernel) const { rows_.place(kernel); }

 private:
  void add_all(const SliceTables& slices);

  BodyKind kind_;
  int places_, slice_;
  std::vector<Index> place_of_, materials_;
  StorageRows rows_;
  StorageBuffer constants_;
};

}  // namespace phymul::gl
