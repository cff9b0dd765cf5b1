// SPDX-License-Identifier: MIT
//
// The elastic terms of a body, in double precision and plain loops: the truth other backends are held against.
#include <phymul/elasticity.h>
#include <phymul/error.h>

#include <algorithm>

#include "domain_forces.h"
#include "force_shape.h"
#include "force_spring.h"
#include "force_volume.h"
#include "force_wall.h"

namespace phymul {
namespace {

/// A base as it stands: its frame, and P*_t - x_i.
struct BaseNow {
  BaseFrame<double> frame;
  Vec3 pull;
};

BaseFrame<double> frame_of(const TopologyTextures& topology, const BaseTexel& base, std::span<const Vec3> x) {
  const Vec3 &xa = x[base.vertex[0]], &xb = x[base.vertex[1]];
  return topology.dimension == 2 ? base_frame_2d(xa, xb) : base_frame_3d(xa, xb, x[base.vertex[2]]);
}

BaseNow base_now(const TopologyTextures& topology, Index t, Index i, std::span<const Vec3> x) {
  const BaseTexel& base = topology.bases[t];
  BaseNow now;
  now.frame = frame_of(topology, base, x);
  now.pull = base.beta * now.frame.n;
  // From differences to x_i: lambda sums to 1, and a body far from the origin loses no digits.
  for (int corner = 0; corner < topology.dimension; ++corner) {
    now.pull += topology.lambda[t][corner] * (x[base.vertex[corner]] - x[i]);
  }
  return now;
}

/// P*_i - x_i.
Vec3 attractor_pull(const TopologyTextures& topology, Index i, std::span<const Vec3> x) {
  const IndexTexel& at = topology.index[i];
  Vec3 pull = Vec3::Zero();
  for (Index r = at.first_neighbour; r < at.first_neighbour + at.neighbour_count; ++r) {
    pull += topology.alpha[r] * (x[topology.neighbours[r]] - x[i]);
  }
  for (Index t = at.first_base; t < at.first_base + at.base_count; ++t) {
    pull += topology.weight[t] * topology.bases[t].beta * frame_of(topology, topology.bases[t], x).n;
  }
  return pull;
}

/// Gives to the vertices of base t what its owner's force F costs them.
void react(const TopologyTextures& topology, Index t, const BaseNow& now, const Vec3& F, std::span<Vec3> force) {
  const BaseTexel& base = topology.bases[t];
  const auto on = topology.dimension == 2 ? base_reaction_2d(now.frame, topology.lambda[t], base.beta, F)
                                          : base_reaction_3d(now.frame, topology.lambda[t], base.beta, F);
  for (int corner = 0; corner < topology.dimension; ++corner) force[base.vertex[corner]] += on[corner];
}

void shape_forces(const TopologyTextures& topology, std::span<const Vec3> x, std::span<Vec3> force) {
  const Reaction reaction = topology.options.reaction;
  for (Index i = 0; i < topology.particle_count; ++i) {
    const IndexTexel& at = topology.index[i];
    if (at.base_count == 0) continue;
    const double k = topology.stiffness[i];
    const Index first = at.first_base, last = at.first_base + at.base_count;

    if (reaction == Reaction::conservative) {
      for (Index t = first; t < last; ++t) {
        const BaseNow now = base_now(topology, t, i, x);
        const Vec3 F = k * topology.weight[t] * now.pull;
        force[i] += F;
        react(topology, t, now, F, force);
      }
      continue;
    }

    const Vec3 F = k * attractor_pull(topology, i, x);
    force[i] += F;
    if (reaction == Reaction::averaged) {
      for (Index t = first; t < last; ++t)
        react(topology, t, base_now(topology, t, i, x), topology.weight[t] * F, force);
      continue;
    }
    for (Index r = at.first_neighbour; r < at.first_neighbour + at.neighbour_count; ++r) {
      const double share = reaction == Reaction::full     ? 1.0
                           : reaction == Reaction::shared ? 1.0 / at.neighbour_count
                                                          : topology.alpha[r];
      force[topology.neighbours[r]] -= share * F;
    }
  }
}

double shape_energy(const TopologyTextures& topology, std::span<const Vec3> x) {
  double energy = 0.0;
  for (Index i = 0; i < topology.particle_count; ++i) {
    const IndexTexel& at = topology.index[i];
    if (at.base_count == 0) continue;
    if (topology.options.reaction != Reaction::conservative) {
      energy += 0.5 * topology.stiffness[i] * attractor_pull(topology, i, x).squaredNorm();
      continue;
    }
    for (Index t = at.first_base; t < at.first_base + at.base_count; ++t) {
      energy += 0.5 * topology.stiffness[i] * topology.weight[t] * base_now(topology, t, i, x).pull.squaredNorm();
    }
  }
  return energy;
}

void volume_forces(const TopologyTextures& topology, std::span<const Vec3> x, std::span<Vec3> force) {
  const VolumeLaw law = topology.options.volume_law;
  for (const VolumeTexel& term : topology.volumes) {
    const auto& v = term.vertex;
    if (topology.dimension == 2) {
      const auto on =
          triangle_area_forces<double>(law, {x[v[0]], x[v[1]], x[v[2]]}, term.inverse_rest_volume, term.stiffness);
      for (int corner = 0; corner < 3; ++corner) force[v[corner]] += on[corner];
    } else {
      const auto on = tetrahedron_volume_forces<double>(law, {x[v[0]], x[v[1]], x[v[2]], x[v[3]]},
                                                        term.inverse_rest_volume, term.stiffness);
      for (int corner = 0; corner < 4; ++corner) force[v[corner]] += on[corner];
    }
  }
}

double volume_energy(const TopologyTextures& topology, std::span<const Vec3> x) {
  double energy = 0.0;
  for (const VolumeTexel& term : topology.volumes) {
    const auto& v = term.vertex;
    const double J = topology.dimension == 2
                         ? triangle_ratio<double>({x[v[0]], x[v[1]], x[v[2]]}, term.inverse_rest_volume)
                         : tetrahedron_ratio<double>({x[v[0]], x[v[1]], x[v[2]], x[v[3]]}, term.inverse_rest_volume);
    energy += term.stiffness * volume_energy_density(topology.options.volume_law, J);
  }
  return energy;
}

void require_sizes(const TopologyTextures& topology, const char* caller, std::size_t positions, std::size_t results) {
  const auto count = static_cast<std::size_t>(topology.particle_count);
  if (positions == count && results == count) return;
  throw Error(std::string(caller) + ": expected " + std::to_string(count) +
              " positions and room for as many results, got " + std::to_string(positions) + " and " +
              std::to_string(results));
}

}  // namespace

void attractors(const TopologyTextures& topology, std::span<const Vec3> position, std::span<Vec3> attractor) {
  require_sizes(topology, "attractors", position.size(), attractor.size());
  for (Index i = 0; i < topology.particle_count; ++i) {
    attractor[i] = position[i];
    if (topology.index[i].base_count > 0) attractor[i] += attractor_pull(topology, i, position);
  }
}

void elastic_forces(const TopologyTextures& topology, std::span<const Vec3> position, std::span<Vec3> force,
                    std::span<const double> factors) {
  require_sizes(topology, "elastic_forces", position.size(), force.size());
  for (Vec3& f : force) f.setZero();
  if (topology.base_count > 0) shape_forces(topology, position, force);
  for (const SpringTexel& spring : topology.springs) {
    const Vec3 F =
        spring_force<double>(position[spring.end[0]], position[spring.end[1]], spring.rest_length, spring.stiffness);
    force[spring.end[0]] += F;
    force[spring.end[1]] -= F;
  }
  volume_forces(topology, position, force);
  for (const WallTexel& wall : topology.walls) wall_energy(wall, topology.rest, position, force);
  add_domain_forces(topology, displacements_at(topology, position), factors, force, [](Index, const Mat3&) {});
}

Index first_collapsed(const TopologyTextures& topology, std::span<const Vec3> position) {
  require_sizes(topology, "first_collapsed", position.size(), position.size());
  for (Index i = 0; i < topology.particle_count; ++i) {
    const IndexTexel& at = topology.index[i];
    for (Index t = at.first_base; t < at.first_base + at.base_count; ++t) {
      if (frame_of(topology, topology.bases[t], position).n == Vec3::Zero()) return i;
    }
  }
  return -1;
}

StrainSummary strain_summary(const TopologyTextures& topology, std::span<const Vec3> position) {
  require_sizes(topology, "strain_summary", position.size(), position.size());
  StrainSummary found;
  double largest = 1.0;
  if (has_walls_alone(topology)) {
    for (const WallTexel& w : topology.walls) largest = std::max(largest, wall_stiffening(w, topology.rest, position));
    found.growth = growth_of_walls(topology, largest);
  }
  if (topology.domains.empty()) return found;
  const auto displacement = displacements_at(topology, position);
  for (Index d = 0; d < static_cast<Index>(topology.domains.size()); ++d) {
    const Mat3 F = Mat3::Identity() + mean_gradient(topology, d, displacement);
    const double condition = squared_condition<double>(topology.options.strain_energy, topology.energy_of(d), F);
    largest = std::max(largest, condition);
    count_beyond_law(condition, topology.domains[d].particle, found);
  }
  found.growth = growth_of(topology, growth_exponent(topology), largest);
  return found;
}

double frequency_growth(const TopologyTextures& topology, std::span<const Vec3> position) {
  return strain_summary(topology, position).growth;
}

double elastic_energy(const TopologyTextures& topology, std::span<const Vec3> position,
                      std::span<const double> factors) {
  require_sizes(topology, "elastic_energy", position.size(), position.size());
  double energy = topology.base_count > 0 ? shape_energy(topology, position) : 0.0;
  for (const SpringTexel& spring : topology.springs) {
    energy +=
        spring_energy<double>(position[spring.end[0]], position[spring.end[1]], spring.rest_length, spring.stiffness);
  }
  energy += volume_energy(topology, position);
  for (const WallTexel& wall : topology.walls) energy += wall_energy(wall, topology.rest, position, {});
  return energy + domain_energy(topology, displacements_at(topology, position), factors);
}

}  // namespace phymul
