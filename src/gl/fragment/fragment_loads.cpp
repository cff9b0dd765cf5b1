// SPDX-License-Identifier: MIT
#include "fragment_loads.h"

namespace phymul::gl {

FragmentLoads::FragmentLoads(const Scene& scene, int instants, const FragmentTables& tables)
    : table_(scene, instants, tables.materials()) {
  if (kind().scaled) {
    factors_ =
        Texture::target(static_cast<std::int64_t>(table_.factors().size()), TexelFormat::r32f, "stiffness_factor");
  }
  if (!kind().any()) return;
  tables_.add("load_index", table_.index());
  tables_.add("load_parts", table_.parts());
  values_ = Texture::target(static_cast<std::int64_t>(table_.values().size()), TexelFormat::r32f, "load_values");
}

void FragmentLoads::evaluate(const std::vector<double>& instants) {
  table_.evaluate(instants);
  if (table_.scale()) factors_.upload(std::span<const float>(table_.factors()));
  const std::size_t modes = static_cast<std::size_t>(table_.mode_count());
  if (values_) values_.upload(std::span<const float>(table_.values().data(), instants.size() * modes));
}

void FragmentLoads::bind(Pass& pass) const {
  if (!values_) return;
  tables_.bind(pass);
  pass.input("load_values", values_);
  pass.set("load_count", table_.mode_count());
}

}  // namespace phymul::gl
