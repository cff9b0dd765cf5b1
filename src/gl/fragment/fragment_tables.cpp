// SPDX-License-Identifier: MIT
#include "fragment_tables.h"

namespace phymul::gl {

FragmentTables::FragmentTables(const FloatTables& tables) : kind_(tables), materials_(tables.domains.material) {
  const auto add = [this](const char* name, const auto& rows) {
    if (!rows.empty()) tables_.add(name, rows);
  };
  tables.for_each(add);
  const FloatEntries entries(tables);
  add("entries", entries.rows);
  volume_start_ = entries.volume_start;
  spring_start_ = entries.spring_start;
}

void FragmentTables::bind(Pass& pass) const {
  tables_.bind(pass);
  pass.set("volume_start", volume_start_);
  pass.set("spring_start", spring_start_);
}

}  // namespace phymul::gl
