// SPDX-License-Identifier: MIT
#include "mirror_forces.h"

#include <utility>

namespace phymul::cpu {
namespace {

using Forces = Kernels<float>;  // where the volume law does not matter

bool reacts_by_bases(const FloatTables& t) {
  return t.options.reaction == Reaction::conservative || t.options.reaction == Reaction::averaged;
}

}  // namespace

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

MirrorForces::MirrorForces(FloatTables tables)
    : tables_(std::move(tables)),
      own_(tables_.has_attractors() ? tables_.particle.size() : 0),
      base_force_(reacts_by_bases(tables_) ? 4 * tables_.base.size() : 0),
      volume_force_(4 * tables_.volume.size()),
      wall_force_(8 * static_cast<std::size_t>(tables_.walls.count())),
      domain_stress_(tables_.domains.range.size()),
      spread_force_(tables_.domains.range.size()) {}

void MirrorForces::scale(std::span<const double> of_materials) {
  factor_.resize(of_materials.empty() ? 0 : tables_.domains.material.size());
  spread_factors(tables_.domains.material, of_materials, factor_);
}

Forces::DeltaBase MirrorForces::base_at(Index t, std::span<const Float3> u, Float3& d1, Float3& d2) const {
  const auto [a, b, c, beta] = tables_.base[t];
  d1 = u[b] - u[a];
  if (tables_.dimension == 2) {
    d2 = Float3{};
    return Forces::delta_base_2d(xyz(tables_.base_e1[t]), d1);
  }
  d2 = u[c] - u[a];
  return Forces::delta_base_3d(xyz(tables_.base_e1[t]), xyz(tables_.base_e2[t]), d1, d2);
}

/// P*_t - x_i of the base's owner i.
Float3 MirrorForces::pull_of_base(Index t, std::span<const Float3> u) const {
  Float3 d1, d2;
  const Forces::DeltaBase base = base_at(t, u, d1, d2);
  const Float3 to_a = u[tables_.base[t][0]] - u[tables_.base_share[t][0]];
  return Forces::base_pull(base, to_a, d1, d2, tables_.base_e1[t][3], tables_.base_e2[t][3],
                           as_float(tables_.base[t][3]));
}

/// Adds w_t beta_t (n - n0) of the triples of i's neighbours, from the rest edges at i.
void MirrorForces::add_enumerated_heights(Index i, std::span<const Float3> u, Float3& sum) const {
  const auto [count, first, bases, first_base] = tables_.index[i];
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
        sum += height * Forces::delta_base_3d(E1, E2, d1, d2).dn;
      }
    }
  }
}

/// P*_i - x_i.
Float3 MirrorForces::attractor_pull(Index i, std::span<const Float3> u) const {
  const auto [count, first, bases, first_base] = tables_.index[i];
  const bool enumerated = tables_.layout == FloatLayout::enumerated;
  Float3 pull;
  for (Index r = first; r < first + count; ++r) {
    const float alpha = enumerated ? tables_.edge_alpha[r][3] : tables_.alpha[r];
    pull += alpha * (u[tables_.neighbour[r]] - u[i]);
  }
  if (enumerated) {
    add_enumerated_heights(i, u, pull);
    return pull;
  }
  for (Index t = first_base; t < first_base + bases; ++t) {
    Float3 d1, d2;
    const float height = as_float(tables_.base_share[t][1]) * as_float(tables_.base[t][3]);
    pull += height * base_at(t, u, d1, d2).dn;
  }
  return pull;
}

/// Fills own_ and base_force_.
void MirrorForces::shape_rows(std::span<const Float3> u) const {
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const auto particle = static_cast<Index>(i);
    own_[i] = tables_.index[i][2] > 0 ? tables_.particle[i][1] * attractor_pull(particle, u) : Float3{};
  }
  if (base_force_.empty()) return;
  const bool conservative = tables_.options.reaction == Reaction::conservative;
  for (Index t = 0; t < tables_.base_count; ++t) {
    Float3 d1, d2;
    const Forces::DeltaBase base = base_at(t, u, d1, d2);
    const float share = as_float(tables_.base_share[t][1]), beta = as_float(tables_.base[t][3]);
    const float lambda_b = tables_.base_e1[t][3], lambda_c = tables_.base_e2[t][3];
    const Index owner = tables_.base_share[t][0];
    const Float3 to_a = u[tables_.base[t][0]] - u[owner];
    const Float3 F =
        share * (conservative ? Forces::base_pull(base, to_a, d1, d2, lambda_b, lambda_c, beta) : own_[owner]);
    Float3* on = &base_force_[4 * static_cast<std::size_t>(t)];
    if (tables_.dimension == 2) {
      Forces::base_reaction_2d(base, lambda_b, beta, F, on[0], on[1]);
    } else {
      Forces::base_reaction_3d(base, lambda_b, lambda_c, beta, F, on[0], on[1], on[2]);
    }
    on[3] = F;
  }
}

template <bool bounded>
void MirrorForces::volume_rows(std::span<const Float3> u) const {
  for (std::size_t v = 0; v < tables_.volume.size(); ++v) {
    const auto& at = tables_.volume[v];
    const Float4 &e1 = tables_.volume_e1[v], &e2 = tables_.volume_e2[v];
    const Float3 E1 = xyz(e1), E2 = xyz(e2), d1 = u[at[1]] - u[at[0]], d2 = u[at[2]] - u[at[0]];
    Float3* on = &volume_force_[4 * v];
    if (tables_.dimension == 2) {
      Kernels<float, bounded>::triangle_area_forces(E1, E2, d1, d2, e1[3], e2[3], on[0], on[1], on[2]);
    } else {
      Kernels<float, bounded>::tetrahedron_volume_forces(E1, E2, xyz(tables_.volume_e3[v]), d1, d2, u[at[3]] - u[at[0]],
                                                         e1[3], e2[3], on[0], on[1], on[2], on[3]);
    }
  }
}

/// Triangles of walls, as walls_pass.glsl has them.
void MirrorForces::wall_rows(std::span<const Float3> u) const {
  for (std::size_t w = 0; w < static_cast<std::size_t>(tables_.walls.count()); ++w) {
    const Int4 &first = tables_.walls.vertex[2 * w], &last = tables_.walls.vertex[2 * w + 1];
    const Float4* const law = &tables_.walls.law[FloatWalls::law_texels * w];
    const Float4& mixed = law[11];
    const std::array<Index, 5> vertex{first[1], first[2], first[3], last[0], last[1]};
    const Float3 T1 = xyz(law[0]), T2 = xyz(law[1]), X[3] = {xyz(law[2]), xyz(law[3]), xyz(law[4])};
    std::array<Float3, 5> d, h;
    Float3 H1, H2;
    for (std::size_t k = 0; k < 5; ++k) {
      d[k] = u[vertex[k]] - u[first[0]];
      h[k] = {law[5 + k][2], law[5 + k][3], k < 4 ? law[10][k] : mixed[0]};
      H1 += law[5 + k][0] * d[k];
      H2 += law[5 + k][1] * d[k];
    }
    const Forces::WallFrame now = Forces::wall_frame(T1, T2, H1, H2);
    Float3 change{inner_product(now.turn, X[0]), inner_product(now.turn, X[1]), inner_product(now.turn, X[2])};
    for (std::size_t k = 0; k < 5; ++k) change += inner_product(now.normal, d[k]) * h[k];
    const auto bent = [&](float by_11, float by_22, float by_12) {
      return by_11 * change.x + by_22 * change.y + by_12 * change.z;
    };
    const Float3 moment{bent(law[2][3], mixed[3], mixed[2]), bent(mixed[3], law[3][3], mixed[1]),
                        bent(mixed[2], mixed[1], law[4][3])};
    Float3 by_normal = moment.x * X[0] + moment.y * X[1] + moment.z * X[2];
    std::array<float, 5> share;
    for (std::size_t k = 0; k < 5; ++k) {
      share[k] = inner_product(h[k], moment);
      by_normal += share[k] * d[k];
    }
    const Forces::WallStress stress = Forces::wall_stress(now, T1, T2, H1, H2, law[0][3], law[1][3]);
    Float3 P1, P2, sum;
    Forces::wall_pulls(now, stress, by_normal, P1, P2);
    for (std::size_t k = 0; k < 5; ++k) {
      const Float3 pull = law[5 + k][0] * P1 + law[5 + k][1] * P2 + share[k] * now.normal;
      wall_force_[8 * w + k + 1] = -pull;
      sum += pull;
    }
    wall_force_[8 * w] = sum;
  }
}

/// EnergyConstants.
std::array<float, most_energy_constants> MirrorForces::energy_constants(Index d) const {
  const Float4* law = &tables_.domains.law[tables_.domains.law_texels * d];
  std::array<float, most_energy_constants> p{};
  for (std::size_t k = 0; (k + 2) / 4 < static_cast<std::size_t>(tables_.domains.law_texels); ++k) {
    p[k] = law[(k + 2) / 4][(k + 2) % 4];
  }
  return p;
}

/// H of a domain.
Columns<float> MirrorForces::domain_gradient(Index d, std::span<const Float3> u) const {
  const FloatDomains& t = tables_.domains;
  Columns<float> H{};
  for (Index r = t.range[d][0]; r < t.range[d][2]; ++r) {
    H = Forces::plus_outer(H, u[owner_of(t.neighbour[r])] - u[owner_of(d)], xyz(t.link[r]));
  }
  return Forces::scaled(law_of(d)[0], H);
}

void MirrorForces::domain_rows(std::span<const Float3> u, MirrorDissipation* dissipation) const {
  const FloatDomains& t = tables_.domains;
  for (Index d = 0; d < t.count(); ++d) {
    Float3 spread;
    for (Index r = t.range[d][0]; r < t.range[d][2]; ++r) {
      spread += t.link[r][3] * (u[owner_of(t.neighbour[r])] - u[owner_of(d)]);
    }
    spread_force_[d] = spread;
    const Columns<float> H = domain_gradient(d, u);
    Columns<float>& Q = domain_stress_[d];
    std::array<float, most_energy_constants> p = energy_constants(d);
    with_energy<float>(tables_.options, [&](auto energy) { Q = energy.energy_stress(H, p.data()); });
    Q = Forces::minus(Q, Forces::scaled(law_of(d)[1], H));
    if (tables_.dimension == 2) Q.c0.z = Q.c1.z = 0.0f;
    if (dissipation != nullptr) {
      Columns<float> P = dissipation->stress(d, H);
      if (tables_.dimension == 2) P.c0.z = P.c1.z = P.c2.z = 0.0f;
      Q = Forces::plus(Q, P);
    }
    if (factor_.empty()) continue;
    Q = Forces::scaled(factor_[d], Q);
    spread_force_[d] = factor_[d] * spread_force_[d];
  }
}

Float3 MirrorForces::domain_force(Index d) const {
  const FloatDomains& t = tables_.domains;
  Float3 F = spread_force_[d];
  for (Index r = t.range[d][0]; r < t.range[d][2]; ++r) {
    const Float3 area = xyz(t.link[r]);
    F += Forces::times(domain_stress_[t.neighbour[r]], r < t.range[d][1] ? area : -area);
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
  if (!t.domains.range.empty()) {
    for (Index d = i; d != none; d = t.domains.range[d][3]) f += domain_force(d);
  }
  for (Index r = first[2]; r < last[2]; ++r) {
    f += Forces::spring_force(xyz(t.spring[r]), u[t.spring_other[r]] - u[i], t.spring[r][3]);
  }
  for (Index r = first[3]; r < last[3]; ++r) f += wall_force_[t.walls.entries.entry[r]];
  return f;
}

void MirrorForces::evaluate(std::span<const Float3> u, std::span<Float3> force, MirrorDissipation* dissipation) const {
  shape_rows(u);
  if (tables_.options.volume_law == VolumeLaw::bounded) {
    volume_rows<true>(u);
  } else {
    volume_rows<false>(u);
  }
  domain_rows(u, dissipation);
  wall_rows(u);
  for (Index i = 0; i < tables_.particle_count; ++i) force[i] = gathered(i, u);
}

}  // namespace phymul::cpu
