// SPDX-License-Identifier: MIT
//
// What one cut changed of a body of tetrahedra or walls, as data: with it the cut can be made and undone without its
// surface.
#pragma once

#include <phymul/model.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

namespace phymul {

/// Rows and particles are those of the Model that was cut, whose spare particles (with_spare_particles) are the copies.
struct BodyCut {
  /// What a cut changes of a Cell.
  struct Part {
    std::array<Index, 4> particles{};  ///< of a triangle -1 in the last place
    double share = 1.0;
    std::vector<CellCut> cuts{};
    bool operator==(const Part&) const = default;
  };
  struct Change {
    Index row = -1;  ///< of Model::cells
    Part before{}, after{};
    bool operator==(const Change&) const = default;
  };
  /// A cell at the end of Model::cells: the other part of a cell.
  struct Added {
    Index of = -1;  ///< row of Model::cells
    Part part{};
    bool operator==(const Added&) const = default;
  };
  struct Copy {
    Index particle = -1, of = -1;
    bool shared = false;  ///< lies on the surface as the other does, so that it is in the same groups and loads
    bool operator==(const Copy&) const = default;
  };
  struct Mass {
    Index particle = -1;
    double before = 0.0, after = 0.0;  ///< kg, while no cell is removed
    bool operator==(const Mass&) const = default;
  };
  std::vector<Change> changed{};  ///< ascending
  std::vector<Added> added{};
  std::vector<Copy> copies{};
  std::vector<Mass> masses{};

  bool empty() const { return changed.empty(); }
  bool operator==(const BodyCut&) const = default;
};

/// Of a body, in order.
using BodyCuts = std::vector<std::shared_ptr<const BodyCut>>;
inline bool equal_cuts(const BodyCuts& a, const BodyCuts& b) {
  return std::ranges::equal(a, b, [](const auto& one, const auto& other) { return one == other || *one == *other; });
}

}  // namespace phymul
