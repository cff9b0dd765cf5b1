// SPDX-License-Identifier: MIT
//
// The forces and the energy of Law::particle_averaged, in double precision and plain loops. `displacement`: as
// mean_gradient() takes it. `factors`: as of elastic_forces().
#pragma once

#include <phymul/elasticity.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "energy_density.h"

namespace phymul {

/// Calls visit(e, area) for the links and surface links of domain d.
template <class Visit>
void for_each_area(const TopologyTextures& t, Index d, const Visit& visit) {
  for (const LinkTexel& link : t.links_of(d)) visit(d + link.offset, link.area);
  for (const SurfaceLinkTexel& link : t.surface_links_of(d)) visit(d + link.offset, link.area);
}

/// H_d = F_d - I, the mean displacement gradient of domain d. `displacement(e)`, m: of the particle of domain e.
template <class Displacement>
Mat3 mean_gradient(const TopologyTextures& t, Index d, const Displacement& displacement) {
  const Vec3 own = displacement(d);
  Mat3 H = Mat3::Zero();
  for_each_area(t, d, [&](Index e, const Vec3& area) { H += (displacement(e) - own) * area.transpose(); });
  return t.domains[d].inverse_volume * H;
}

/// From positions `x` [N], m, the displacements that mean_gradient() takes.
inline auto displacements_at(const TopologyTextures& t, std::span<const Vec3> x) {
  return [&t, x](Index e) {
    const Index i = t.domains[e].particle;
    return Vec3(x[i] - t.rest[i]);
  };
}

/// Of the stiffness of domain d (Scene::stiffness_factors).
inline double factor_of(const TopologyTextures& t, Index d, std::span<const double> factors) {
  const auto material = static_cast<std::size_t>(t.domains[d].material);
  return material < factors.size() ? factors[material] : 1.0;
}

/// frequency_growth() (elasticity.h) is the largest squared_condition() of all domains to this power. Calibrated on
/// uniformly strained bodies (docs/theory/physics.md): the less volume resists, the more frequencies grow.
inline double growth_exponent(const TopologyTextures& t) {
  double shear_over_bulk = 0.0;
  for (const EnergyConstants& p : t.energies) shear_over_bulk = std::max(shear_over_bulk, p[0] / p[1]);
  return 1.0 + 1.6 * shear_over_bulk;
}

/// frequency_growth() of that largest condition. The power is not calibrated in bodies with walls and for a Poisson's
/// ratio below 0.3, which grow by up to so many times more than it says.
inline double growth_of(const TopologyTextures& t, double exponent, double condition) {
  return std::pow(condition, exponent) * (t.walls.empty() ? 1.0 : 3.7) * (exponent < 1.74 ? 1.0 : 2.6);
}

/// What stiffening alone can raise the largest eigenvalue by, in states that the law does not foresee.
inline double most_stiffening(const TopologyTextures& t) {
  double most = 1.0;
  if (t.options.strain_energy != StrainEnergy::stiffening) return most;
  for (const EnergyConstants& p : t.energies) {
    const double end = p[3] > 0.0 ? most_exponent / p[3] : 0.0;  // X
    for (const double X : {std::min(0.999 * end, 3.0), std::min(p[5] > 0.0 ? 1.0 / p[5] : 3.0, 3.0)}) {
      most = std::max(most, 1.0 + growth_exponent(t) * share_of_shear(p) * stiffening_at(p, X));
    }
  }
  return most;
}

/// Adds a domain of the particle, of which squared_condition() is known, to the counts.
inline void count_beyond_law(double condition, Index particle, StrainSummary& to) {
  if (!(condition >= 1e6)) return;
  ++to.beyond_law;
  if (condition >= 2e6) ++to.inverted;
  if (to.first_beyond < 0 || particle < to.first_beyond) to.first_beyond = particle;
}

/// dE/dF_d per volume, the stabiliser's part of it included.
inline Mat3 mean_stress(const TopologyTextures& t, Index d, const Mat3& H) {
  const DomainTexel& domain = t.domains[d];
  Mat3 P;
  energy_density<double>(t.options, t.energy_of(d), Mat3::Identity() + H, &P);
  P -= domain.spread_stiffness * H;
  if (t.dimension == 2) P.row(2).setZero();  // nothing but rounding, which would leave the plane
  return P;
}

/// Adds forces to `force` [N], N. Calls visit(d, H) with the mean displacement gradients.
template <class Displacement, class Visit>
void add_domain_forces(const TopologyTextures& t, const Displacement& displacement, std::span<const double> factors,
                       std::span<Vec3> force, const Visit& visit) {
  for (Index d = 0; d < static_cast<Index>(t.domains.size()); ++d) {
    const double factor = factor_of(t, d, factors);
    const Mat3 H = mean_gradient(t, d, displacement);
    visit(d, H);
    const Mat3 Q = factor * mean_stress(t, d, H);
    const Index i = t.domains[d].particle;
    for (const LinkTexel& link : t.links_of(d)) {
      force[t.domains[d + link.offset].particle] -= Q * link.area;
      force[i] += Q * link.area + factor * link.stiffness * (displacement(d + link.offset) - displacement(d));
    }
    for (const SurfaceLinkTexel& link : t.surface_links_of(d)) {
      force[t.domains[d + link.offset].particle] -= Q * link.area;
      force[i] += Q * link.area;
    }
  }
}

/// J.
template <class Displacement>
double domain_energy(const TopologyTextures& t, const Displacement& displacement, std::span<const double> factors) {
  double energy = 0.0;
  for (Index d = 0; d < static_cast<Index>(t.domains.size()); ++d) {
    const double factor = factor_of(t, d, factors);
    const DomainTexel& domain = t.domains[d];
    const Mat3 H = mean_gradient(t, d, displacement);
    const double density = energy_density<double>(t.options, t.energy_of(d), Mat3::Identity() + H, nullptr);
    energy += factor * (density - 0.5 * domain.spread_stiffness * H.squaredNorm()) / domain.inverse_volume;
    const Vec3 own = displacement(d);
    for (const LinkTexel& link : t.links_of(d)) {  // each from both sides
      energy += 0.25 * factor * link.stiffness * (displacement(d + link.offset) - own).squaredNorm();
    }
  }
  return energy;
}

}  // namespace phymul
