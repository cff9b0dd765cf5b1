// SPDX-License-Identifier: MIT
#include "rest_body.h"

#include <phymul/elasticity.h>

#include <algorithm>

#include "elastic/domain_forces.h"
#include "elastic/mean_gradient.h"

namespace phymul {

constexpr Index path_nodes = 600;  ///< of the grid that paths bend on, at most

RestBody::RestBody(const TopologyTextures& topology, std::span<const std::uint8_t> fixed)
    : topology_(topology),
      diagonal_(diagonal_at_rest(topology)),
      tangent_(make_tangent(topology)),
      grid_(topology, fixed, diagonal_, *tangent_),
      path_(topology, grid_.finest_of(path_nodes)),
      of_domains_(topology.domains.size()) {}

void RestBody::add_forces(const VecList& x, std::span<Vec3> force, std::vector<Mat3>& gradients) {
  std::ranges::transform(topology_.domains, of_domains_.begin(), [&](const DomainTexel& domain) -> Vec3 {
    return x[domain.particle] - topology_.rest[domain.particle];
  });
  gradients.resize(of_domains_.size());
  add_domain_forces(
      topology_, [this](Index e) -> const Vec3& { return of_domains_[e]; }, {}, force,
      [&](Index d, const Mat3& H) { gradients[d] = H; });
}

void RestBody::find_gradients(const Eigen::VectorXd& displacement, std::vector<Mat3>& gradients) {
  std::ranges::transform(topology_.domains, of_domains_.begin(), [&](const DomainTexel& domain) -> Vec3 {
    return displacement.segment<3>(3 * static_cast<Eigen::Index>(domain.particle));
  });
  gradients.resize(of_domains_.size());
  for (std::size_t d = 0; d < gradients.size(); ++d) {
    gradients[d] =
        mean_gradient(topology_, static_cast<Index>(d), [this](Index e) -> const Vec3& { return of_domains_[e]; });
  }
}

double potential_energy(const TopologyTextures& topology, const LoadFrame& loads, RestTerms terms,
                        const VecList& position) {
  double energy = elastic_energy(topology, position);
  for (const RestTerm* term : terms) energy += term->energy(position);
  for (std::size_t i = 0; i < position.size(); ++i) {
    energy -= load_on(topology.mass, loads, i).dot(position[i] - topology.rest[i]);
  }
  return energy;
}

}  // namespace phymul
