// SPDX-License-Identifier: MIT
//
// What changes, on the device, in one storage buffer: three pairs of displacement (m) and velocity (m/s) by place; what
// the last step measured; forces of attractors, terms of bases, volumes and domains, four rows each; rows of a
// report. Of a body that dissipates also the strains of its domains, with each pair, and the constants of its material.
#pragma once

#include "compute_tables.h"
#include "gl/solver/state_copies.h"

namespace phymul::gl {

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
