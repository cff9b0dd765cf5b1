// SPDX-License-Identifier: MIT
//
// The volumes that a scene keeps, among the rows of its loads.
#pragma once

#include "compute_tables.h"
#include "device/float_volumes.h"

namespace phymul::gl {

class ComputeVolumes {
 public:
  ComputeVolumes(const FloatVolumes& volumes, const ComputeTables& tables, StorageRows& rows);

  int count() const { return count_; }
  int facet_sums() const { return facet_sums_; }         ///< of the first level
  std::int64_t roots_row() const { return roots_row_; }  ///< [count]

 private:
  int count_, facet_sums_;
  std::int64_t roots_row_;
};

}  // namespace phymul::gl
