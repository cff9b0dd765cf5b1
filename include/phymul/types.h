// SPDX-License-Identifier: MIT
//
// The words every other header uses. Units are SI throughout: m, kg, s, N, Pa, J.
// Only non-vectorisable Eigen types appear in public structs: their size and alignment do not change with
// the caller's -m flags, so a library and a client built with different ones still agree.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace phymul {

/// Number of a particle, cell or base. Signed, 32 bit: the width of an integer texel. -1 means "none".
using Index = std::int32_t;

/// A point, displacement, velocity or force. In a two-dimensional model the third coordinate is 0.
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// One Vec3 per particle, shape [N][3].
using VecList = std::vector<Vec3>;

static_assert(alignof(Vec3) == alignof(double));
static_assert(sizeof(Vec3) == 3 * sizeof(double));

/// Ragged lists in compressed rows: row i is entry[offset[i]] ... entry[offset[i + 1] - 1].
struct RaggedList {
  std::vector<Index> offset{0};  ///< [rows + 1], never decreasing, starts with 0
  std::vector<Index> entry;      ///< [offset.back()]

  Index rows() const { return static_cast<Index>(offset.size()) - 1; }
  Index size(Index row) const { return offset[row + 1] - offset[row]; }
  const Index* begin(Index row) const { return entry.data() + offset[row]; }
  const Index* end(Index row) const { return entry.data() + offset[row + 1]; }

  /// Appends one row. Amortised constant time per entry.
  template <class Iterator>
  void push_row(Iterator first, Iterator last) {
    entry.insert(entry.end(), first, last);
    offset.push_back(static_cast<Index>(entry.size()));
  }

  bool operator==(const RaggedList&) const = default;
};

}  // namespace phymul
