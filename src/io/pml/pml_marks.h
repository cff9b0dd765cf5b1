// SPDX-License-Identifier: MIT
//
// The attribute by which write_pml says what plain PML cannot, so that reading gives an equal model. Other programs
// keep or ignore it like any attribute they do not know.
#pragma once

#include <phymul/types.h>

#include <optional>
#include <string_view>
#include <vector>

namespace phymul {

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
