// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

#include <array>
#include <vector>

namespace phymul {

/// Where the parts of a model go in a PML file, settled before writing: a reference may stand before its cell.
class PmlLayout {
 public:
  /// Throws Error for what PML cannot say.
  explicit PmlLayout(const Model& model);

  std::vector<std::vector<Index>> children;    ///< [components]
  std::array<std::vector<Index>, 2> roots;     ///< informative, exclusive
  std::vector<std::vector<Index>> own_cells;   ///< [components] cells first defined there
  std::vector<std::vector<Index>> references;  ///< [components] cells referred to
  std::vector<Index> loose;                    ///< cells in no component
  std::vector<Index> cell_number;              ///< [cells] index as written; -1: none
  Index neighbourhoods = -1;                   ///< the component "Neighborhoods"; -1: none
  bool components_in_order = true;             ///< the file's order is that of the rows
  bool cells_in_order = true;

 private:
  void sort_components();
  void sort_cells();
  void walk(Index root, bool exclusive);
  void require_writable(Index row, bool exclusive) const;
  void number_cells();
  void require_atom_numbers() const;

  const Model& model_;
  std::vector<Index> component_order_;  // rows in the order of the file
  std::vector<Index> cell_order_;       // likewise
};

}  // namespace phymul
