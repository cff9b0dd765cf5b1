// SPDX-License-Identifier: MIT
#include "mirror_dissipation.h"

namespace phymul::cpu {

MirrorDissipation::MirrorDissipation(const TopologyTextures& topology, const std::vector<Index>& source)
    : rows_(topology, topology.dissipation.empty() ? std::vector<Index>() : source),
      kept_(kept_strains(topology)),
      strains_(empty() ? 0 : source.size()),
      next_(strains_) {}

void MirrorDissipation::begin_step(double dt, double last_dt) {
  if (dt != packed_dt_) constants_ = rows_.constants(dt);
  packed_dt_ = dt;
  inverse_last_dt_ = static_cast<float>(1.0 / (last_dt > 0.0 ? last_dt : dt));
}

Columns<float> MirrorDissipation::stress(Index d, const Columns<float>& H) {
  const Float4 &moduli = constants_[2 * d], &decay = constants_[2 * d + 1];
  const Of::Symmetric E = Of::green_strain(H);
  Of::Symmetric S{};
  next_[d] = {E, E};
  if (kept_.rate) {
    const Of::Symmetric change = Of::symmetric_minus(E, fresh_ ? E : strains_[d][0]);
    S = Of::symmetric_plus(S, inverse_last_dt_, Of::isotropic_stress(change, moduli[0], moduli[1]));
  }
  if (kept_.branch) {
    const Of::Symmetric before = fresh_ ? E : strains_[d][1];
    const Of::Symmetric q = Of::symmetric_minus(E, before);
    S = Of::symmetric_plus(S, 1.0f, Of::isotropic_stress(q, moduli[2], moduli[3]));
    next_[d][1] = Of::symmetric_plus(before, decay[0], q);
  }
  return Of::first_piola(H, S);
}

void MirrorDissipation::accept() {
  strains_.swap(next_);
  fresh_ = false;
}

}  // namespace phymul::cpu
