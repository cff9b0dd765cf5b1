// SPDX-License-Identifier: MIT
#include "packed_dissipation.h"

#include <cmath>

namespace phymul::cpu {

PackedDissipation::PackedDissipation(const TopologyTextures& topology, const PackedAverages& averages)
    : topology_(topology), averages_(averages), kept_(kept_strains(topology)), columns_(6 * kept_.count()) {
  const auto slots = static_cast<std::size_t>(averages.slots);
  constants_.assign(simd::dissipation_columns * slots, 0.0f);
  strains_.assign(columns_ * slots, 0.0f);
  next_strains_ = strains_;
}

/// Calls each(domain, place).
template <class Each>
void PackedDissipation::for_each_domain(const Each& each) const {
  for (std::size_t place = 0; place < averages_.domain_of_place.size(); ++place) {
    const Index d = averages_.domain_of_place[place];
    if (d != none) each(static_cast<std::size_t>(d), place);
  }
}

/// Column 0 of a place; the next one is `lanes` further.
float* PackedDissipation::at(Floats& rows, std::size_t columns, std::size_t place) const {
  const auto lanes = static_cast<std::size_t>(averages_.lanes);
  return &rows[place / lanes * columns * lanes + place % lanes];
}

void PackedDissipation::reset(const StrainMemory& memory) {
  fresh_ = memory.empty();
  if (fresh_) return;
  for_each_domain([&](std::size_t d, std::size_t place) {
    float* const to = at(strains_, columns_, place);
    for (std::size_t k = 0; k < columns_; ++k) {
      to[k * averages_.lanes] = static_cast<float>(memory[d * kept_.count() + k / 6][k % 6]);
    }
  });
}

StrainMemory PackedDissipation::memory() const {
  StrainMemory memory;
  if (fresh_) return memory;
  memory.resize(topology_.dissipation.size() * kept_.count());
  for_each_domain([&](std::size_t d, std::size_t place) {
    const float* const from = at(const_cast<Floats&>(strains_), columns_, place);
    for (std::size_t k = 0; k < columns_; ++k) {
      memory[d * kept_.count() + k / 6][k % 6] = from[k * averages_.lanes];
    }
  });
  return memory;
}

void PackedDissipation::pack_constants(double dt) {
  packed_dt_ = dt;
  for_each_domain([&](std::size_t d, std::size_t place) {
    const DissipationTexel& of = topology_.dissipation[d];
    const double e = of.relaxation_strength > 0.0 ? std::exp(-dt / of.relaxation_time) : 1.0;
    const double branch = of.relaxation_strength * std::sqrt(e);
    const std::array<double, simd::dissipation_columns> columns{2.0 * of.mu * of.retardation_time,
                                                                of.lambda * of.retardation_time, 2.0 * of.mu * branch,
                                                                of.lambda * branch, 1.0 - e};
    float* const to = at(constants_, columns.size(), place);
    for (std::size_t k = 0; k < columns.size(); ++k) to[k * averages_.lanes] = static_cast<float>(columns[k]);
  });
}

const simd::Dissipation* PackedDissipation::job(double dt, double last_dt) {
  if (dt != packed_dt_) pack_constants(dt);
  job_ = {.constants = constants_.data(),
          .strains = strains_.data(),
          .next_strains = next_strains_.data(),
          .elastic_columns = static_cast<int>(averages_.constants.size()) / averages_.slots,
          .inverse_dt = static_cast<float>(1.0 / (last_dt > 0.0 ? last_dt : dt)),
          .rate = kept_.rate,
          .branch = kept_.branch,
          .fresh = fresh_};
  return &job_;
}

void PackedDissipation::accept() {
  strains_.swap(next_strains_);
  fresh_ = false;
}

}  // namespace phymul::cpu
