// SPDX-License-Identifier: MIT
#include "float_domains.h"

#include <cmath>
#include <utility>

#include "float_range.h"
#include "topology/energies.h"

namespace phymul {
namespace {

/// By number: the domain of TopologyTextures, or `none`.
std::vector<Index> number_domains(const TopologyTextures& from) {
  std::vector<Index> order, further;
  for (Index i = 0; i < from.particle_count; ++i) {
    const Index first = from.first_domain[i], end = from.first_domain[i + 1];
    order.push_back(first < end ? first : none);
    for (Index d = first + 1; d < end; ++d) further.push_back(d);
  }
  order.insert(order.end(), further.begin(), further.end());
  return order;
}

void pack_links(const TopologyTextures& from, Index d, const std::vector<Index>& number_of, FloatDomains& to) {
  Int4& range = to.range.back();
  const auto rows = [&to] { return static_cast<std::int32_t>(to.link.size()); };
  range[0] = rows();
  for (const LinkTexel& link : from.links_of(d)) {
    to.neighbour.push_back(number_of[d + link.offset]);
    to.link.push_back(texel(link.area, link.stiffness));
  }
  range[1] = rows();
  for (const SurfaceLinkTexel& link : from.surface_links_of(d)) {
    to.neighbour.push_back(number_of[d + link.offset]);
    to.link.push_back(texel(link.area, 0.0));
  }
  range[2] = rows();
}

/// Fills the owners, and the last column of the ranges.
void chain_domains(const TopologyTextures& from, const std::vector<Index>& order, FloatDomains& to) {
  if (to.count() == from.particle_count) return;
  std::vector<Index> last;  // of each particle, so far
  for (Index number = 0; number < to.count(); ++number) {
    const Index i = number < from.particle_count ? number : from.domains[order[number]].particle;
    to.owner.push_back(i);
    if (number < from.particle_count) {
      last.push_back(number);
    } else {
      to.range[last[i]][3] = number;
      last[i] = number;
    }
  }
}

}  // namespace

FloatDomains pack_domains(const TopologyTextures& topology) {
  FloatDomains to;
  if (topology.domains.empty()) return to;
  const std::vector<Index> order = number_domains(topology);
  std::vector<Index> number_of(topology.domains.size());
  for (std::size_t number = 0; number < order.size(); ++number) {
    if (order[number] != none) number_of[order[number]] = static_cast<Index>(number);
  }
  const std::size_t constants = kind_of(topology.options.strain_energy).constants, texels = (constants + 5) / 4;
  to.law_texels = static_cast<int>(texels);
  to.source = order;
  to.kept = kept_strains(topology);
  for (const Index d : order) {
    to.range.push_back({0, 0, 0, none});
    to.material.push_back(d == none ? none : topology.domains[d].material);
    to.law.resize(to.law.size() + texels, Float4{});
    if (d == none) continue;
    const DomainTexel& domain = topology.domains[d];
    Float4* law = &to.law[to.law.size() - texels];
    law[0][0] = narrow(domain.inverse_volume);
    law[0][1] = narrow(domain.spread_stiffness);
    for (std::size_t k = 0; k < constants; ++k) law[(k + 2) / 4][(k + 2) % 4] = narrow(topology.energy_of(d)[k]);
    pack_links(topology, d, number_of, to);
  }
  chain_domains(topology, order, to);
  return to;
}

void spread_factors(std::span<const Index> material, std::span<const double> of_materials, std::span<float> factor) {
  for (std::size_t d = 0; d < factor.size(); ++d) {
    const auto row = static_cast<std::size_t>(material[d]);
    factor[d] = material[d] != none && row < of_materials.size() ? static_cast<float>(of_materials[row]) : 1.0f;
  }
}

FloatDissipation::FloatDissipation(const TopologyTextures& topology, std::vector<Index> source)
    : topology_(topology),
      source_(std::move(source)),
      kinds_(kept_strains(topology).count()),
      constants_(2 * source_.size(), Float4{}) {
  constants(0.0);  // those of any step are not larger
}

const std::vector<Float4>& FloatDissipation::constants(double dt) {
  for (std::size_t row = 0; row < source_.size(); ++row) {
    if (source_[row] == none) continue;
    const DissipationTexel& of = topology_.dissipation[source_[row]];
    const double e = of.relaxation_strength > 0.0 ? std::exp(-dt / of.relaxation_time) : 1.0;
    const double branch = of.relaxation_strength * std::sqrt(e);
    constants_[2 * row] = {narrow(2.0 * of.mu * of.retardation_time), narrow(of.lambda * of.retardation_time),
                           narrow(2.0 * of.mu * branch), narrow(of.lambda * branch)};
    constants_[2 * row + 1][0] = static_cast<float>(1.0 - e);
  }
  return constants_;
}

std::vector<Float4> FloatDissipation::rows(const StrainMemory& memory) const {
  std::vector<Float4> rows(strain_texels * source_.size(), Float4{});
  for (std::size_t row = 0; row < source_.size(); ++row) {
    if (source_[row] == none) continue;
    for (std::size_t k = 0; k < 6 * kinds_; ++k) {
      const Strain& strain = memory[static_cast<std::size_t>(source_[row]) * kinds_ + k / 6];
      rows[strain_texels * row + k / 3][k % 3] = static_cast<float>(strain[k % 6]);
    }
  }
  return rows;
}

StrainMemory FloatDissipation::memory(std::span<const Float4> rows) const {
  StrainMemory memory(topology_.dissipation.size() * kinds_);
  for (std::size_t row = 0; row < source_.size(); ++row) {
    if (source_[row] == none) continue;
    for (std::size_t k = 0; k < 6 * kinds_; ++k) {
      Strain& strain = memory[static_cast<std::size_t>(source_[row]) * kinds_ + k / 6];
      strain[k % 6] = rows[strain_texels * row + k / 3][k % 3];
    }
  }
  return memory;
}

}  // namespace phymul
