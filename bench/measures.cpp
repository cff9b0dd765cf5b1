// SPDX-License-Identifier: MIT
#include "measures.h"

#include <phymul/elasticity.h>
#include <phymul/load_frame.h>
#include <phymul/monitor.h>

#include <Eigen/Geometry>

#include <cmath>

namespace phymul::bench {
namespace {

std::optional<PositionError> sample_error(const Problem& problem, std::span<const Vec3> displacement) {
  if (!problem.samples) return std::nullopt;
  Model samples;
  samples.rest = problem.sample_point;
  VecList found = problem.samples->deform(displacement), wanted = problem.reference;
  for (std::size_t s = 0; s < found.size(); ++s) {
    found[s] += problem.sample_point[s];
    wanted[s] += problem.sample_point[s];
  }
  return position_error(samples, found, wanted);
}

void take_worse(std::optional<double>& worst, const Vec3& found, const std::array<std::optional<double>, 3>& wanted) {
  double off = 0.0, size = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!wanted[axis]) continue;
    off += std::pow(found[axis] - *wanted[axis], 2);
    size += std::pow(*wanted[axis], 2);
  }
  if (size > 0.0) worst = std::max(worst.value_or(0.0), std::sqrt(off / size));
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
                 std::span<const Vec3> position, const ToolForces& pushed) {
  Measures result;
  VecList displacement(position.begin(), position.end());
  for (std::size_t i = 0; i < displacement.size(); ++i) displacement[i] -= topology.rest[i];
  result.displacement = sample_error(problem, displacement);
  for (const Problem::Reaction& reaction : problem.reactions) {
    const Support found = support(reaction.particles, topology, scene, position);
    take_worse(result.force_error, reaction.torque ? found.torque : found.force, reaction.value);
  }
  for (const Problem::Push& push : problem.pushes) {
    const auto found = pushed.find(push.tool);
    if (found != pushed.end()) take_worse(result.force_error, found->second, push.value);
  }
  return result;
}

std::optional<PositionError> null_error(const Problem& problem) {
  return sample_error(problem, problem.displacement);
}

}  // namespace phymul::bench
