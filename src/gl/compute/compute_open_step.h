// SPDX-License-Identifier: MIT
//
// A step that the host acts in, among the rows of the loads: the list of particles that the host asks for, what is
// gathered of them, and what it adds. Room for all particles, so that no step allocates.
#pragma once

#include <span>
#include <vector>

#include "compute_tables.h"
#include "gl/solver/device.h"

namespace phymul::gl {

class ComputeOpenStep {
 public:
  ComputeOpenStep(const ComputeTables& tables, StorageRows& rows);

  int asked_count() const { return asked_count_; }
  int gathered_row() const { return static_cast<int>(gathered_row_); }  ///< [asked_count()][3]
  int push_count() const { return push_count_; }

  void set_gathered(std::span<const Index> rows, StorageBuffer& buffer);
  void read(std::span<OpenRow> rows, const StorageBuffer& buffer) const;
  void set_pushes(std::span<const Push> pushes, StorageBuffer& buffer);

 private:
  const ComputeTables* tables_;
  std::int64_t asked_row_, gathered_row_, push_row_, force_row_, shift_row_;
  int asked_count_ = 0, push_count_ = 0;
  std::vector<Int4> rows_;
  std::vector<Push> pushes_;  // by place
  std::vector<Float4> values_;
};

}  // namespace phymul::gl
