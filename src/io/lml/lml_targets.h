// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/index_table.h"

namespace phymul {

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
