// SPDX-License-Identifier: MIT
//
// The float kernels of a body run on Bounded: every force, and how far a float backend may be from it.
#pragma once

#include <gtest/gtest.h>
#include <phymul/topology_textures.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "elastic/dissipation.h"
#include "mirror/kernels.h"
#include "rounding_bound.h"

namespace phymul::test {

using Bounded3 = Vector3<Bounded>;
using BoundedKernels = cpu::Kernels<Bounded>;  // where the volume law does not matter

class BoundedForces {
 public:
  /// With its strains, each exactly a float.
  struct DissipatingStep {
    const StrainMemory& strains;
    double dt, last_dt;
  };
  /// `u` [particles]: displacements, m, each exactly a float.
  BoundedForces(const TopologyTextures& topology, std::span<const Vec3> u,
                const std::optional<DissipatingStep>& dissipation = {})
      : t_(topology), u_(u), sum_(u.size()), dissipation_(dissipation) {
    if (t_.base_count > 0) add_shape();
    add_springs();
    for (const VolumeTexel& term : t_.volumes) {
      t_.options.volume_law == VolumeLaw::bounded ? add_volume<true>(term) : add_volume<false>(term);
    }
    for (const WallTexel& wall : t_.walls) add_wall(wall);
    cpu::with_energy<Bounded>(t_.options, [this](auto energy) {
      for (Index d = 0; d < static_cast<Index>(t_.domains.size()); ++d) add_domain<decltype(energy)>(d);
    });
  }

  Bounded3 force(Index i) const { return sum_[i].total(); }

 private:
  Bounded3 difference(Index a, Index b) const {
    const auto one = [&](int axis) { return rounded(u_[b][axis] - u_[a][axis], 0.0); };
    return {one(0), one(1), one(2)};
  }
  static Bounded3 stored3(const Vec3& v) { return {stored(v.x()), stored(v.y()), stored(v.z())}; }
  Bounded3 rest_edge(Index a, Index b) const { return stored3(t_.rest[b] - t_.rest[a]); }

  struct BaseNow {
    BoundedKernels::DeltaBase base;
    Bounded3 d1, d2;
    Bounded lambda_b, lambda_c, beta;
  };

  BaseNow base_now(Index t) const {
    const BaseTexel& texel = t_.bases[t];
    const auto [a, b, c] = texel.vertex;
    BaseNow now;
    now.beta = stored(texel.beta);
    now.lambda_b = stored(t_.lambda[t][1]);
    now.d1 = difference(a, b);
    if (t_.dimension == 2) {
      now.base = BoundedKernels::delta_base_2d(rest_edge(a, b), now.d1);
      return now;
    }
    now.lambda_c = stored(t_.lambda[t][2]);
    now.d2 = difference(a, c);
    now.base = BoundedKernels::delta_base_3d(rest_edge(a, b), rest_edge(a, c), now.d1, now.d2);
    return now;
  }

  /// F_i, for all reactions but the conservative one.
  Bounded3 attractor_force(Index i) {
    const IndexTexel& at = t_.index[i];
    BoundedSum pull;
    for (Index r = at.first_neighbour; r < at.first_neighbour + at.neighbour_count; ++r) {
      pull.add(stored(t_.alpha[r]) * difference(i, t_.neighbours[r]));
    }
    for (Index t = at.first_base; t < at.first_base + at.base_count; ++t) {
      const BaseNow now = base_now(t);
      pull.add((stored(t_.weight[t]) * now.beta) * now.base.dn);
    }
    return stored(t_.stiffness[i]) * pull.total();
  }

  void react(Index t, const BaseNow& now, const Bounded3& F) {
    std::array<Bounded3, 3> on;
    if (t_.dimension == 2) {
      BoundedKernels::base_reaction_2d(now.base, now.lambda_b, now.beta, F, on[0], on[1]);
    } else {
      BoundedKernels::base_reaction_3d(now.base, now.lambda_b, now.lambda_c, now.beta, F, on[0], on[1], on[2]);
    }
    for (std::size_t corner = 0; corner < static_cast<std::size_t>(t_.dimension); ++corner) {
      sum_[t_.bases[t].vertex[corner]].add(on[corner]);
    }
  }

  void add_shape() {
    for (Index i = 0; i < t_.particle_count; ++i) {
      const IndexTexel& at = t_.index[i];
      if (at.base_count == 0) continue;
      const bool conservative = t_.options.reaction == Reaction::conservative;
      Bounded3 F;
      if (!conservative) {
        F = attractor_force(i);
        sum_[i].add(F);
      }
      if (conservative || t_.options.reaction == Reaction::averaged) {
        for (Index t = at.first_base; t < at.first_base + at.base_count; ++t) add_base(i, t, conservative, F);
        continue;
      }
      for (Index r = at.first_neighbour; r < at.first_neighbour + at.neighbour_count; ++r) {
        const double share = t_.options.reaction == Reaction::full     ? 1.0
                             : t_.options.reaction == Reaction::shared ? 1.0 / at.neighbour_count
                                                                       : t_.alpha[r];
        sum_[t_.neighbours[r]].add(-(stored(share) * F));
      }
    }
  }

  void add_base(Index i, Index t, bool conservative, const Bounded3& owner_force) {
    const BaseNow now = base_now(t);
    if (!conservative) {
      react(t, now, stored(t_.weight[t]) * owner_force);
      return;
    }
    const Bounded3 pull = BoundedKernels::base_pull(now.base, difference(i, t_.bases[t].vertex[0]), now.d1, now.d2,
                                                    now.lambda_b, now.lambda_c, now.beta);
    const Bounded share = stored(t_.stiffness[i] * t_.weight[t]);
    const Bounded3 F = share * pull;
    sum_[i].add(F);
    react(t, now, F);
  }

  void add_springs() {
    for (const SpringTexel& spring : t_.springs) {
      const auto [a, b] = spring.end;
      const Bounded k = stored(spring.stiffness);
      const Bounded3 F = BoundedKernels::spring_force(rest_edge(a, b), difference(a, b), k);
      sum_[a].add(F);
      sum_[b].add(-F);
    }
  }

  template <bool bounded>
  void add_volume(const VolumeTexel& term) {
    const auto [a, b, c, d] = term.vertex;
    const Bounded stiffness = stored(term.stiffness);
    if (t_.dimension == 2) {
      const std::array<Bounded3, 2> E{rest_edge(a, b), rest_edge(a, c)}, e{difference(a, b), difference(a, c)};
      const Bounded inverse = stored(term.inverse_rest_volume / 2.0);
      std::array<Bounded3, 3> on;
      cpu::Kernels<Bounded, bounded>::triangle_area_forces(E[0], E[1], e[0], e[1], inverse, stiffness, on[0], on[1],
                                                           on[2]);
      for (std::size_t corner = 0; corner < 3; ++corner) sum_[term.vertex[corner]].add(on[corner]);
    } else {
      const std::array<Bounded3, 3> E{rest_edge(a, b), rest_edge(a, c), rest_edge(a, d)},
          e{difference(a, b), difference(a, c), difference(a, d)};
      const Bounded inverse = stored(term.inverse_rest_volume / 6.0);
      std::array<Bounded3, 4> on;
      cpu::Kernels<Bounded, bounded>::tetrahedron_volume_forces(E[0], E[1], E[2], e[0], e[1], e[2], inverse, stiffness,
                                                                on[0], on[1], on[2], on[3]);
      for (std::size_t corner = 0; corner < 4; ++corner) sum_[term.vertex[corner]].add(on[corner]);
    }
  }

  void add_wall(const WallTexel& wall) {
    std::array<Bounded3, 6> d, X;
    const auto gradient = [&](std::size_t k, std::size_t a) { return stored(wall.gradient[k][a]); };
    const auto hessian = [&](std::size_t k, std::size_t ab) { return stored(wall.hessian[k][ab]); };
    BoundedSum sum1, sum2;
    for (std::size_t k = 1; k < 6; ++k) {
      if (wall.vertex[k] == none) continue;
      d[k] = difference(wall.vertex[0], wall.vertex[k]);
      sum1.add(gradient(k, 0) * d[k]);
      sum2.add(gradient(k, 1) * d[k]);
    }
    const Bounded3 T1 = stored3(wall.tangent[0]), T2 = stored3(wall.tangent[1]), H1 = sum1.total(), H2 = sum2.total();
    auto now = BoundedKernels::wall_frame(T1, T2, H1, H2);
    // The reference finds these as differences in double precision.
    for (Bounded* change : {&now.turn.x, &now.turn.y, &now.turn.z, &now.q}) change->error += 1e-12;
    std::array<Bounded, 3> change, moment;
    for (std::size_t ab = 0; ab < 3; ++ab) {
      X[ab] = stored3(wall.second[ab]);
      change[ab] = inner_product(now.turn, X[ab]);
      for (std::size_t k = 1; k < 6; ++k) {
        change[ab] = change[ab] + hessian(k, ab) * inner_product(now.normal, d[k]);
      }
    }
    constexpr std::array<std::array<std::size_t, 3>, 3> entry{{{0, 5, 4}, {5, 1, 3}, {4, 3, 2}}};
    for (std::size_t ab = 0; ab < 3; ++ab) {
      for (std::size_t c = 0; c < 3; ++c) moment[ab] = moment[ab] + stored(wall.bending[entry[ab][c]]) * change[c];
    }
    Bounded3 by_normal = moment[0] * X[0] + moment[1] * X[1] + moment[2] * X[2], P1, P2;
    std::array<Bounded, 6> share;
    for (std::size_t k = 1; k < 6; ++k) {
      share[k] = hessian(k, 0) * moment[0] + hessian(k, 1) * moment[1] + hessian(k, 2) * moment[2];
      by_normal = by_normal + share[k] * d[k];
    }
    const auto stress = BoundedKernels::wall_stress(now, T1, T2, H1, H2, stored(wall.shear), stored(wall.compliance));
    BoundedKernels::wall_pulls(now, stress, by_normal, P1, P2);
    for (std::size_t k = 1; k < 6; ++k) {
      if (wall.vertex[k] == none) continue;
      const Bounded3 pull = gradient(k, 0) * P1 + gradient(k, 1) * P2 + share[k] * now.normal;
      sum_[wall.vertex[k]].add(-pull);
      sum_[wall.vertex[0]].add(pull);
    }
  }

  Bounded3 difference_of_domains(Index d, Index e) const {
    return difference(t_.domains[d].particle, t_.domains[e].particle);
  }

  /// 1/V times the sum over the links, as columns; whether a backend adds the two areas of a surface link first or the
  /// products afterwards is left open.
  cpu::Columns<Bounded> mean_gradient(Index d) const {
    BoundedSum c0, c1, c2;
    const auto add = [&](Index e, const Vec3& area) {
      const Bounded3 u = difference_of_domains(d, e), A = stored3(area);
      c0.add(A.x * u);
      c1.add(A.y * u);
      c2.add(A.z * u);
    };
    for (const LinkTexel& link : t_.links_of(d)) add(d + link.offset, link.area);
    for (const SurfaceLinkTexel& link : t_.surface_links_of(d)) add(d + link.offset, link.area);
    const Bounded inverse = stored(t_.domains[d].inverse_volume);
    return {inverse * c0.total(), inverse * c1.total(), inverse * c2.total()};
  }

  cpu::Columns<Bounded> dissipated_stress(Index d, const cpu::Columns<Bounded>& H) const {
    using Of = cpu::GreenStrain<Bounded>;
    const DissipationTexel& of = t_.dissipation[d];
    const KeptStrains kept = kept_strains(t_);
    std::size_t at = static_cast<std::size_t>(d) * kept.count();
    const Of::Symmetric E = Of::green_strain(H);
    Of::Symmetric S{};
    const auto add = [&](double factor, const Bounded& scale) {
      const Strain& e = dissipation_->strains[at++];
      const Of::Symmetric before{stored3({e[0], e[1], e[2]}), stored3({e[3], e[4], e[5]})};
      S = Of::symmetric_plus(S, scale,
                             Of::isotropic_stress(Of::symmetric_minus(E, before), stored(2.0 * of.mu * factor),
                                                  stored(of.lambda * factor)));
    };
    if (kept.rate) add(of.retardation_time, stored(1.0 / dissipation_->last_dt));
    if (kept.branch) {
      add(of.relaxation_strength * std::exp(-0.5 * dissipation_->dt / of.relaxation_time), Bounded(1.0f));
    }
    return Of::first_piola(H, S);
  }

  template <class Energy>
  void add_domain(Index d) {
    const DomainTexel& domain = t_.domains[d];
    const cpu::Columns<Bounded> H = mean_gradient(d);
    const Bounded spread = stored(domain.spread_stiffness);
    std::array<Bounded, most_energy_constants> p;
    for (std::size_t k = 0; k < p.size(); ++k) p[k] = stored(t_.energy_of(d)[k]);
    cpu::Columns<Bounded> Q = Energy::minus(Energy::energy_stress(H, p.data()), Energy::scaled(spread, H));
    if (dissipation_) Q = Energy::plus(Q, dissipated_stress(d, H));
    for (const LinkTexel& link : t_.links_of(d)) {
      sum_[t_.domains[d + link.offset].particle].add(-BoundedKernels::times(Q, stored3(link.area)));
      sum_[domain.particle].add(stored(link.stiffness) * difference_of_domains(d, d + link.offset));
    }
    for (const SurfaceLinkTexel& link : t_.surface_links_of(d)) {
      sum_[t_.domains[d + link.offset].particle].add(-BoundedKernels::times(Q, stored3(link.area)));
    }
  }

  const TopologyTextures& t_;
  std::span<const Vec3> u_;
  std::vector<BoundedSum> sum_;
  std::optional<DissipatingStep> dissipation_;
};

/// Largest error over bound of the velocities, m/s, that a step of `dt` has given to particles that stood still; a
/// failure where it is above 1. Out of the plane of a flat body nothing moves.
inline double share_of_bound(const TopologyTextures& tables, const BoundedForces& forces, const VecList& velocity,
                             double dt) {
  double worst = 0.0;
  for (Index i = 0; i < tables.particle_count; ++i) {
    const Bounded3 force = forces.force(i);
    const std::array<Bounded, 3> axes{force.x, force.y, force.z};
    if (tables.dimension == 2) {
      EXPECT_EQ(velocity[i].z(), 0.0) << "particle " << i;
    }
    for (int axis = 0; axis < tables.dimension; ++axis) {
      const Bounded v = Bounded() + stored(dt) * (stored(1.0 / tables.mass[i]) * axes[static_cast<std::size_t>(axis)]);
      const double error = std::abs(velocity[i][axis] - v.value);
      EXPECT_LE(error, v.error) << "particle " << i << ", axis " << axis << ", velocity " << v.value;
      if (v.error > 0.0) worst = std::max(worst, error / v.error);
    }
  }
  return worst;
}

}  // namespace phymul::test
