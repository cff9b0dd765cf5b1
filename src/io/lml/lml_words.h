// SPDX-License-Identifier: MIT
//
// What the words of LML mean: units, and what a load is applied to.
#pragma once

#include <phymul/model.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/index_table.h"

namespace phymul {

/// A unit of LML and what a value in it is in SI.
struct LmlUnit {
  const char* name;
  LoadType type;
  double factor;
};

/// nullptr: no load of this type has such a unit.
const LmlUnit* find_lml_unit(LoadType type, std::string_view name);

/// The unit meant where a load has none, and the one that is written.
const LmlUnit& default_lml_unit(LoadType type);

/// "mm, micron, nm, ..."
std::string known_lml_units(LoadType type);

/// Spelling of LML ("Translation").
const char* lml_name(LoadType type);

/// The language of appliedTo: `1,3,5-7`, names of groups, `*`; blanks around commas are allowed.
class LmlTargets {
 public:
  explicit LmlTargets(const Model& model);

  /// Particles meant, each once, in the order of the text. Throws Error (without a place) that says what is wrong.
  std::vector<Index> resolve(std::string_view text) const;

  /// Row of the particle with that index. Throws Error where there is none.
  Index particle(std::int64_t wanted) const;

  /// Shortest text of indices and ranges that resolves to these particles.
  std::string spell(const std::vector<Index>& particles) const;

  std::int64_t number(Index particle) const;

 private:
  std::vector<Index> resolve_item(std::string_view item) const;

  const Model& model_;
  IndexTable table_;
};

}  // namespace phymul
