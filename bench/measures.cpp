// SPDX-License-Identifier: MIT
#include "measures.h"

#include <phymul/elasticity.h>
#include <phymul/monitor.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>

namespace phymul::bench {
namespace {

PositionError sample_error(const Problem& problem, std::span<const Vec3> displacement) {
  Model samples;
  samples.rest = problem.sample_point;
  VecList found, wanted;
  for (std::size_t s = 0; s < problem.places.size(); ++s) {
    found.push_back(problem.sample_point[s] + problem.places[s].interpolate(displacement));
    wanted.push_back(problem.sample_point[s] + problem.reference[s]);
  }
  return position_error(samples, found, wanted);
}

}  // namespace

Support support(std::span<const Index> particles, const TopologyTextures& topology, const Scene& scene,
                std::span<const Vec3> position) {
  VecList elastic(position.size());
  elastic_forces(topology, position, elastic);
  LoadFrame frame;
  scene.prepare(frame);
  scene.evaluate(0.0, frame);
  Vec3 centre = Vec3::Zero();
  for (const Index i : particles) centre += topology.rest[i] / static_cast<double>(particles.size());
  Support sum;
  for (const Index i : particles) {
    Vec3 force = -elastic[i] - topology.mass[i] * frame.gravity;
    if (!frame.force.empty()) force -= frame.force[i];
    sum.force += force;
    sum.torque += (position[i] - centre).cross(force);
  }
  return sum;
}

Measures measure(const Problem& problem, const TopologyTextures& topology, const Scene& scene,
                 std::span<const Vec3> position) {
  Measures result;
  VecList displacement(position.begin(), position.end());
  for (std::size_t i = 0; i < displacement.size(); ++i) displacement[i] -= topology.rest[i];
  result.displacement = sample_error(problem, displacement);
  for (const Problem::Reaction& reaction : problem.reactions) {
    const Support found = support(reaction.particles, topology, scene, position);
    double off = 0.0, size = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      if (!reaction.value[axis]) continue;
      off += std::pow((reaction.torque ? found.torque : found.force)[axis] - *reaction.value[axis], 2);
      size += std::pow(*reaction.value[axis], 2);
    }
    if (size > 0.0) result.force_error = std::max(result.force_error.value_or(0.0), std::sqrt(off / size));
  }
  return result;
}

PositionError null_error(const Problem& problem) {
  return sample_error(problem, problem.displacement);
}

}  // namespace phymul::bench
