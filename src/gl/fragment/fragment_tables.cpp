// SPDX-License-Identifier: MIT
#include "fragment_tables.h"

#include <phymul/error.h>

#include <limits>

namespace phymul::gl {

FragmentTables::FragmentTables(const FloatTables& tables) : kind_(tables), materials_(tables.domains.material) {
  const auto add = [this](const char* name, const auto& rows) {
    if (!rows.empty()) tables_.add(name, rows);
  };
  add("particle", tables.particle);
  add("index", tables.index);
  add("lists", tables.lists);
  add("neighbours", tables.neighbour);
  add("alpha", tables.alpha);
  add("edge_alpha", tables.edge_alpha);
  add("first_height", tables.first_height);
  add("height", tables.height);
  add("bases", tables.base);
  add("base_e1", tables.base_e1);
  add("base_e2", tables.base_e2);
  add("base_share", tables.base_share);
  add("share", tables.share);
  add("volume", tables.volume);
  add("volume_e1", tables.volume_e1);
  add("volume_e2", tables.volume_e2);
  add("volume_e3", tables.volume_e3);
  add("spring", tables.spring);
  add("domain_range", tables.domains.range);
  add("domain_law", tables.domains.law);
  add("domain_owner", tables.domains.owner);
  add("link_domain", tables.domains.neighbour);
  add("link", tables.domains.link);

  std::vector<std::int32_t> entries = tables.reaction;
  const auto append = [&](const std::vector<std::int32_t>& list) {
    const std::size_t start = entries.size();
    entries.insert(entries.end(), list.begin(), list.end());
    if (entries.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
      throw Error(ErrorCode::not_supported, "the lists of who meets which term have " + std::to_string(entries.size()) +
                                                " rows together; a shader counts to 2147483647");
    }
    return static_cast<int>(start);
  };
  volume_start_ = append(tables.volume_entry);
  spring_start_ = append(tables.spring_other);
  add("entries", entries);
}

void FragmentTables::bind(Pass& pass) const {
  tables_.bind(pass);
  pass.set("volume_start", volume_start_);
  pass.set("spring_start", spring_start_);
}

}  // namespace phymul::gl
