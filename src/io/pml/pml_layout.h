// SPDX-License-Identifier: MIT
//
// What write_pml lays out, and the attribute by which it says what plain PML cannot, so that reading gives an equal
// model. Other programs keep or ignore it like any attribute they do not know.
#pragma once

#include <phymul/model.h>
#include <phymul/types.h>

#include <array>
#include <optional>
#include <string_view>
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

inline constexpr const char* pml_mark_attribute = "phymul";

struct PmlMarks {
  bool unnumbered = false;      ///< list of atoms, cell: the model has no file indices, those written are rows
  bool wrapper = false;         ///< multiComponent: stands only because PML wants one root; no row of Model::components
  bool loose = false;           ///< structuralComponent: holds cells that are in no component; no row either
  bool unlisted = false;        ///< structuralComponent "Neighborhoods": no row either
  bool unweighed = false;       ///< structuralComponent: its cells without a material have none, whatever their masses
  std::optional<Index> row;     ///< component, cell: row in the model where it is not the order of the file
  std::optional<double> share;  ///< cell: Cell::share where it is not 1; atom: 0, it may be without mass
  std::vector<std::vector<double>> cuts;  ///< cell: Cell::cuts, m, as many numbers as particles
};

/// Parses the blank-separated words of the attribute ("unnumbered row=12"); none where a word is not known.
std::optional<PmlMarks> parse_pml_marks(std::string_view text);

}  // namespace phymul
