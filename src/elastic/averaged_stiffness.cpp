// SPDX-License-Identifier: MIT
#include "averaged_stiffness.h"

#include "base/side_by_side.h"
#include "energy_density.h"
#include "mean_gradient.h"

namespace phymul {

bool AveragedStiffness::is_all_of(const TopologyTextures& t) {
  return !t.domains.empty() && t.base_count == 0 && t.springs.empty() && t.volumes.empty() && t.walls.empty();
}

AveragedStiffness::AveragedStiffness(const TopologyTextures& topology) : topology_(topology) {
  particle_.reserve(topology.domains.size());
  for (const DomainTexel& domain : topology.domains) particle_.push_back(domain.particle);
}

void AveragedStiffness::apply(const Eigen::VectorXd& u, Eigen::VectorXd& result) {
  in_halves(static_cast<Index>(topology_.domains.size()), topology_.options.runner.get(),
            [&](int part, Index first, Index last) { apply(first, last, u, part == 0 ? result : other_); });
  result += other_;
}

/// The change of mean_stress (domain_forces.h) with u.
Mat3 AveragedStiffness::stress(Index d, const Eigen::VectorXd& u) const {
  const TopologyTextures& t = topology_;
  const DomainTexel& domain = t.domains[d];
  const Vec3 own = u.segment<3>(3 * domain.particle);
  Mat3 H = Mat3::Zero();
  for_each_area(t, d, [&](Index e, const Vec3& area) {
    const Vec3 difference = u.segment<3>(3 * particle_[e]) - own;
    // An outer product takes twice as long.
    for (int axis = 0; axis < 3; ++axis) H.col(axis) += difference * area[axis];
  });
  H *= domain.inverse_volume;
  const Mat3 P = stress_near_rest<double>(t.options.strain_energy, t.energy_of(d), H) - domain.spread_stiffness * H;
  return P;
}

void AveragedStiffness::apply(Index first, Index last, const Eigen::VectorXd& u, Eigen::VectorXd& result) const {
  const TopologyTextures& t = topology_;
  result.setZero(u.size());
  for (Index d = first; d < last; ++d) {
    const Mat3 Q = stress(d, u);
    const Index i = particle_[d];
    const Vec3 own = u.segment<3>(3 * i);
    Vec3 sum = Vec3::Zero();
    for (const LinkTexel& link : t.links_of(d)) {
      const Index j = particle_[d + link.offset];
      const Vec3 pull = Q * link.area;
      result.segment<3>(3 * j) += pull;
      sum += pull + link.stiffness * (u.segment<3>(3 * j) - own);
    }
    for (const SurfaceLinkTexel& link : t.surface_links_of(d)) {
      const Vec3 pull = Q * link.area;
      result.segment<3>(3 * particle_[d + link.offset]) += pull;
      sum += pull;
    }
    result.segment<3>(3 * i) -= sum;
  }
}

}  // namespace phymul
