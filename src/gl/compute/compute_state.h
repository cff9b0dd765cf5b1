// SPDX-License-Identifier: MIT
//
// What changes, on the device, in one storage buffer: three pairs of displacement (m) and velocity (m/s) by place; what
// the last step measured; forces of attractors, terms of bases, volumes, walls and domains, four rows each; rows of a
// report. Of a body that dissipates also the strains of its domains, with each pair, and the constants of its material.
#pragma once

#include <vector>

#include "device/slice_tables.h"
#include "gl/objects/storage_buffer.h"
#include "gl/solver/body_kind.h"
#include "gl/solver/state_copies.h"

namespace phymul::gl {

constexpr int lanes = 64;  ///< of a group of invocations, where groups are many

/// As dialect_compute.glsl has them.
enum StorageBinding : GLuint { constant_rows_binding, constant_words_binding, changing_binding, loads_binding };

/// The constants of a body in a storage buffer: SliceTables one after another, under the names of tables.glsl.
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

class ComputeState : public StatePairs {
 public:
  static constexpr int most_report_groups = 256;

  ComputeState(const ComputeTables& tables, const ComputeLimits& limits);

  void bind() const { buffer_.bind(changing_binding); }
  void place(Kernel& kernel) const { rows_.place(kernel); }

  void write(const VecList& rest, const State& state);
  void read(const VecList& rest, State& state) const;
  void request_copy(StateCopies& copies, const State& header) const;
  PlaceOf place_of() const { return tables_->place_of(); }

  // Of a body that dissipates.
  void set_dissipation(std::span<const Float4> constants);
  void write_strains(std::span<const Float4> rows);
  std::vector<Float4> read_strains() const;  ///< empty: fresh
  int strains_row(int pair) const { return static_cast<int>(strains_row_ + pair * strain_rows()); }

  /// What the last step measured has been reported by then: rows for whoever shows something.
  int spare_row() const { return static_cast<int>(measured_row_); }
  int report_row() const { return static_cast<int>(report_row_); }
  const StorageBuffer& rows() const { return buffer_; }

 private:
  std::int64_t pair_row(int pair) const { return std::int64_t{2} * pair * tables_->places(); }
  std::int64_t strain_rows() const { return std::int64_t{4} * tables_->kind().domains; }

  const ComputeTables* tables_;
  StorageRows rows_;
  std::int64_t measured_row_ = 0, report_row_ = 0, strains_row_ = 0, dissipation_row_ = 0;
  StorageBuffer buffer_;
};

}  // namespace phymul::gl
