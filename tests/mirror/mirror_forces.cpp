// SPDX-License-Identifier: MIT
#include "mirror_forces.h"

#include <bit>
#include <utility>

#include "delta_base.h"
#include "delta_spring.h"
#include "delta_volume.h"

namespace phymul::cpu {
namespace {

Float3 xyz(const Float4& texel) {
  return {texel[0], texel[1], texel[2]};
}

float as_float(std::int32_t bits) {
  return std::bit_cast<float>(bits);
}

bool reacts_by_bases(const FloatTables& t) {
  return t.options.reaction == Reaction::conservative || t.options.reaction == Reaction::averaged;
}

}  // namespace

MirrorForces::MirrorForces(FloatTables tables)
    : tables_(std::move(tables)),
      own_(tables_.has_attractors() ? tables_.particle.size() : 0),
      base_force_(reacts_by_bases(tables_) ? 4 * tables_.base.size() : 0),
      volume_force_(4 * tables_.volume.size()),
      cell_stress_(tables_.cell_stiffness.size()),
      domain_stress_(tables_.domains.range.size()),
      spread_force_(tables_.domains.range.size()) {}

template <bool scaled>
DeltaBase<scaled, float> MirrorForces::base_at(Index t, std::span<const Float3> u, Float3& d1, Float3& d2) const {
  const auto [a, b, c, beta] = tables_.base[t];
  const auto p = static_cast<float>(tables_.options.area_exponent);
  d1 = u[b] - u[a];
  if (tables_.dimension == 2) {
    d2 = Float3{};
    return delta_base_2d<scaled>(xyz(tables_.base_e1[t]), d1, p);
  }
  d2 = u[c] - u[a];
  return delta_base_3d<scaled>(xyz(tables_.base_e1[t]), xyz(tables_.base_e2[t]), d1, d2, p);
}

/// P*_t - x_i of the base's owner i.
template <bool scaled>
Float3 MirrorForces::pull_of_base(Index t, std::span<const Float3> u) const {
  Float3 d1, d2;
  const DeltaBase<scaled, float> base = base_at<scaled>(t, u, d1, d2);
  const Float3 to_a = u[tables_.base[t][0]] - u[tables_.base_share[t][0]];
  return base_pull(base, to_a, d1, d2, tables_.base_e1[t][3], tables_.base_e2[t][3], as_float(tables_.base[t][3]));
}

/// Adds w_t beta_t (g n - n0) of the triples of i's neighbours, from the rest edges at i.
template <bool scaled>
void MirrorForces::add_enumerated_heights(Index i, std::span<const Float3> u, Float3& sum) const {
  const auto [count, first, bases, first_base] = tables_.index[i];
  const auto p = static_cast<float>(tables_.options.area_exponent);
  std::int32_t entry = 4 * tables_.first_height[i];
  for (Index j = first; j < first + count; ++j) {
    for (Index k = j + 1; k < first + count; ++k) {
      const Float3 E1 = xyz(tables_.edge_alpha[k]) - xyz(tables_.edge_alpha[j]);
      const Float3 d1 = u[tables_.neighbour[k]] - u[tables_.neighbour[j]];
      for (Index l = k + 1; l < first + count; ++l, ++entry) {
        const float height = tables_.height[entry / 4][entry % 4];
        if (height == 0.0f) continue;
        const Float3 E2 = xyz(tables_.edge_alpha[l]) - xyz(tables_.edge_alpha[j]);
        const Float3 d2 = u[tables_.neighbour[l]] - u[tables_.neighbour[j]];
        sum += height * delta_base_3d<scaled>(E1, E2, d1, d2, p).change;
      }
    }
  }
}

/// P*_i - x_i.
template <bool scaled>
Float3 MirrorForces::attractor_pull(Index i, std::span<const Float3> u) const {
  const auto [count, first, bases, first_base] = tables_.index[i];
  const bool enumerated = tables_.layout == FloatLayout::enumerated;
  Float3 pull;
  for (Index r = first; r < first + count; ++r) {
    const float alpha = enumerated ? tables_.edge_alpha[r][3] : tables_.alpha[r];
    pull += alpha * (u[tables_.neighbour[r]] - u[i]);
  }
  if (enumerated) {
    add_enumerated_heights<scaled>(i, u, pull);
    return pull;
  }
  for (Index t = first_base; t < first_base + bases; ++t) {
    Float3 d1, d2;
    const float height = as_float(tables_.base_share[t][1]) * as_float(tables_.base[t][3]);
    pull += height * base_at<scaled>(t, u, d1, d2).change;
  }
  return pull;
}

/// Fills own_ and base_force_.
template <bool scaled>
void MirrorForces::shape_rows(std::span<const Float3> u) const {
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const auto particle = static_cast<Index>(i);
    own_[i] = tables_.index[i][2] > 0 ? tables_.particle[i][1] * attractor_pull<scaled>(particle, u) : Float3{};
  }
  if (base_force_.empty()) return;
  const bool conservative = tables_.options.reaction == Reaction::conservative;
  for (Index t = 0; t < tables_.base_count; ++t) {
    Float3 d1, d2;
    const DeltaBase<scaled, float> base = base_at<scaled>(t, u, d1, d2);
    const float share = as_float(tables_.base_share[t][1]), beta = as_float(tables_.base[t][3]);
    const float lambda_b = tables_.base_e1[t][3], lambda_c = tables_.base_e2[t][3];
    const Index owner = tables_.base_share[t][0];
    const Float3 to_a = u[tables_.base[t][0]] - u[owner];
    const Float3 F = share * (conservative ? base_pull(base, to_a, d1, d2, lambda_b, lambda_c, beta) : own_[owner]);
    const auto on = tables_.dimension == 2 ? base_reaction_2d(base, lambda_b, beta, F)
                                           : base_reaction_3d(base, lambda_b, lambda_c, beta, F);
    for (std::size_t corner = 0; corner < 3; ++corner)
      base_force_[4 * static_cast<std::size_t>(t) + corner] = on[corner];
    base_force_[4 * static_cast<std::size_t>(t) + 3] = F;
  }
}

template <bool bounded>
void MirrorForces::volume_rows(std::span<const Float3> u) const {
  for (std::size_t v = 0; v < tables_.volume.size(); ++v) {
    const auto& at = tables_.volume[v];
    const Float4 &e1 = tables_.volume_e1[v], &e2 = tables_.volume_e2[v];
    if (tables_.dimension == 2) {
      const auto on = triangle_area_forces<bounded, float>({xyz(e1), xyz(e2)},
                                                           {u[at[1]] - u[at[0]], u[at[2]] - u[at[0]]}, e1[3], e2[3]);
      for (std::size_t corner = 0; corner < 3; ++corner) volume_force_[4 * v + corner] = on[corner];
      continue;
    }
    const auto on = tetrahedron_volume_forces<bounded, float>(
        {xyz(e1), xyz(e2), xyz(tables_.volume_e3[v])}, {u[at[1]] - u[at[0]], u[at[2]] - u[at[0]], u[at[3]] - u[at[0]]},
        e1[3], e2[3]);
    for (std::size_t corner = 0; corner < 4; ++corner) volume_force_[4 * v + corner] = on[corner];
  }
}

/// H = sum over v of (u_v - u_0) (x) gradient_v.
Columns<float> MirrorForces::cell_gradient(Index c, std::span<const Float3> u) const {
  Columns<float> H{};
  const Index first = tables_.cell_vertex[2 * c][0];
  for (Index corner = 1; corner < 8; ++corner) {
    const Index vertex = tables_.cell_vertex[2 * c + corner / 4][corner % 4];
    if (vertex == none) break;
    add_outer(H, u[vertex] - u[first], xyz(tables_.cell_gradient[8 * c + corner]));
  }
  return H;
}

template <bool bounded>
void MirrorForces::cell_rows(std::span<const Float3> u) const {
  for (Index c = 0; c < tables_.cell_count; ++c) {
    const Float2& stiffness = tables_.cell_stiffness[c];
    cell_stress_[c] = cell_stress<bounded>(cell_gradient(c, u), stiffness[0], stiffness[1]);
  }
}

/// H of a domain.
Columns<float> MirrorForces::domain_gradient(Index d, std::span<const Float3> u) const {
  const FloatDomains& t = tables_.domains;
  Columns<float> H{};
  for (Index r = t.range[d][0]; r < t.range[d][2]; ++r) {
    add_outer(H, u[owner_of(t.neighbour[r])] - u[owner_of(d)], xyz(t.link[r]));
  }
  const float scale = t.law[d][0];
  return {scale * H.c0, scale * H.c1, scale * H.c2};
}

template <bool bounded>
void MirrorForces::domain_rows(std::span<const Float3> u) const {
  const FloatDomains& t = tables_.domains;
  for (Index d = 0; d < t.count(); ++d) {
    Float3 spread;
    for (Index r = t.range[d][0]; r < t.range[d][2]; ++r) {
      spread += t.link[r][3] * (u[owner_of(t.neighbour[r])] - u[owner_of(d)]);
    }
    spread_force_[d] = spread;
    const auto [inverse_volume, shape, volume, stabiliser] = t.law[d];
    const Columns<float> H = domain_gradient(d, u);
    Columns<float> P = cell_stress<bounded>(H, shape, volume);
    if (tables_.dimension == 2) P.c0.z = P.c1.z = 0.0f;
    domain_stress_[d] = {P.c0 - stabiliser * H.c0, P.c1 - stabiliser * H.c1, P.c2 - stabiliser * H.c2};
  }
}

Float3 MirrorForces::domain_force(Index d) const {
  const FloatDomains& t = tables_.domains;
  Float3 F = spread_force_[d];
  for (Index r = t.range[d][0]; r < t.range[d][2]; ++r) {
    const Float3 area = xyz(t.link[r]);
    F += times(domain_stress_[t.neighbour[r]], r < t.range[d][1] ? area : -area);
  }
  return F;
}

Float3 MirrorForces::gathered(Index i, std::span<const Float3> u) const {
  const FloatTables& t = tables_;
  const auto &first = t.lists[i], &last = t.lists[i + 1];
  Float3 f;
  if (!own_.empty()) {
    f = own_[i];
  } else if (!base_force_.empty()) {
    const auto [count, row, bases, first_base] = t.index[i];
    for (Index b = first_base; b < first_base + bases; ++b) f += base_force_[4 * b + 3];
  }
  if (!t.share.empty()) {
    for (Index r = first[0]; r < last[0]; ++r) f -= as_float(t.share[r][1]) * own_[t.share[r][0]];
  } else {
    for (Index r = first[0]; r < last[0]; ++r) f += base_force_[t.reaction[r]];
  }
  for (Index r = first[1]; r < last[1]; ++r) f += volume_force_[t.volume_entry[r]];
  for (Index r = first[2]; r < last[2]; ++r) {
    const Index entry = t.cell_entry[r];
    f -= times(cell_stress_[entry / 8], xyz(t.cell_gradient[entry]));
  }
  if (!t.domains.range.empty()) {
    for (Index d = i; d != none; d = t.domains.range[d][3]) f += domain_force(d);
  }
  for (Index r = first[3]; r < last[3]; ++r) {
    f += spring_force(xyz(t.spring[r]), u[t.spring_other[r]] - u[i], t.spring[r][3]);
  }
  return f;
}

void MirrorForces::evaluate(std::span<const Float3> u, std::span<Float3> force) const {
  if (tables_.options.area_exponent != 0.0) {
    shape_rows<true>(u);
  } else {
    shape_rows<false>(u);
  }
  if (tables_.options.volume_law == VolumeLaw::bounded) {
    volume_rows<true>(u);
    cell_rows<true>(u);
    domain_rows<true>(u);
  } else {
    volume_rows<false>(u);
    cell_rows<false>(u);
    domain_rows<false>(u);
  }
  for (Index i = 0; i < tables_.particle_count; ++i) force[i] = gathered(i, u);
}

template <bool scaled>
double MirrorForces::shape_energy(std::span<const Float3> u) const {
  double sum = 0.0;
  for (Index i = 0; i < tables_.particle_count; ++i) {
    if (tables_.index[i][2] == 0) continue;
    if (tables_.has_attractors()) {
      sum += pull_energy(tables_.particle[i][1], attractor_pull<scaled>(i, u));
      continue;
    }
    const auto [count, first, bases, first_base] = tables_.index[i];
    for (Index t = first_base; t < first_base + bases; ++t) {
      sum += pull_energy(as_float(tables_.base_share[t][1]), pull_of_base<scaled>(t, u));
    }
  }
  return sum;
}

template <bool bounded>
double MirrorForces::volume_energy(std::span<const Float3> u) const {
  double sum = 0.0;
  for (std::size_t v = 0; v < tables_.volume.size(); ++v) {
    const auto& at = tables_.volume[v];
    const Float3 E1 = xyz(tables_.volume_e1[v]), E2 = xyz(tables_.volume_e2[v]), E3 = xyz(tables_.volume_e3[v]);
    const Float3 d1 = u[at[1]] - u[at[0]], d2 = u[at[2]] - u[at[0]];
    const float inverse = tables_.volume_e1[v][3], stiffness = tables_.volume_e2[v][3];
    const float change = tables_.dimension == 2
                             ? triangle_change<float>({E1, E2}, {d1, d2}, inverse)
                             : tetrahedron_change<float>({E1, E2, E3}, {d1, d2, u[at[3]] - u[at[0]]}, inverse);
    sum += stiffness * volume_energy_density<bounded>(change);
  }
  return sum;
}

template <bool bounded>
double MirrorForces::cell_energy_sum(std::span<const Float3> u) const {
  double sum = 0.0;
  for (Index c = 0; c < tables_.cell_count; ++c) {
    const Float2& stiffness = tables_.cell_stiffness[c];
    sum += cell_energy<bounded>(cell_gradient(c, u), stiffness[0], stiffness[1]);
  }
  return sum;
}

template <bool bounded>
double MirrorForces::domain_energy(std::span<const Float3> u) const {
  const FloatDomains& t = tables_.domains;
  double sum = 0.0;
  for (Index d = 0; d < t.count(); ++d) {
    const auto [inverse_volume, shape, volume, stabiliser] = t.law[d];
    if (inverse_volume == 0.0f) continue;
    const Columns<float> H = domain_gradient(d, u);
    const float squares = inner_product(H.c0, H.c0) + inner_product(H.c1, H.c1) + inner_product(H.c2, H.c2);
    sum += (cell_energy<bounded>(H, shape, volume) - 0.5f * stabiliser * squares) / inverse_volume;
    for (Index r = t.range[d][0]; r < t.range[d][2]; ++r) {
      const Float3 apart = u[owner_of(t.neighbour[r])] - u[owner_of(d)];
      sum += 0.25f * t.link[r][3] * inner_product(apart, apart);
    }
  }
  return sum;
}

double MirrorForces::energy(std::span<const Float3> u) const {
  double sum = tables_.options.area_exponent != 0.0 ? shape_energy<true>(u) : shape_energy<false>(u);
  if (tables_.options.volume_law == VolumeLaw::bounded) {
    sum += volume_energy<true>(u) + cell_energy_sum<true>(u) + domain_energy<true>(u);
  } else {
    sum += volume_energy<false>(u) + cell_energy_sum<false>(u) + domain_energy<false>(u);
  }
  for (Index i = 0; i < tables_.particle_count; ++i) {
    for (Index r = tables_.lists[i][3]; r < tables_.lists[i + 1][3]; ++r) {
      // Each spring stands in the lists of both its ends.
      const Float4& spring = tables_.spring[r];
      sum += 0.5 * spring_energy(xyz(spring), u[tables_.spring_other[r]] - u[i], spring[3]);
    }
  }
  return sum;
}

}  // namespace phymul::cpu
