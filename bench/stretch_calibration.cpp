// SPDX-License-Identifier: MIT
#include "stretch_calibration.h"

#include <phymul/error.h>
#include <phymul/topology_textures.h>

#include "measures.h"

namespace phymul::bench {
namespace {

constexpr double strain = 0.01;

struct Ends {
  int axis = 0;
  double length = 0.0;
  std::vector<Index> low, high;
};

Ends ends_of(const Model& model) {
  Vec3 low = model.rest[0], high = low;
  for (const Vec3& p : model.rest) low = low.cwiseMin(p), high = high.cwiseMax(p);
  Ends ends;
  (high - low).maxCoeff(&ends.axis);
  const int a = ends.axis;
  ends.length = high[a] - low[a];
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (model.rest[i][a] < low[a] + 1e-6 * ends.length) ends.low.push_back(i);
    if (model.rest[i][a] > high[a] - 1e-6 * ends.length) ends.high.push_back(i);
  }
  if (ends.low.size() < 3 || ends.high.size() < 3) {
    throw Error("the body has no flat ends along its longest side to stretch it by");
  }
  return ends;
}

Load along(int axis, double move, std::vector<Index> particles) {
  Load load;
  load.type = LoadType::translation;
  load.particles = std::move(particles);
  load.direction = Vec3::Unit(axis);
  load.axes = {Axis::free, Axis::free, Axis::free};
  load.axes[axis] = move == 0.0 ? Axis::held : Axis::driven;
  load.events = {{0.0, move}};
  return load;
}

}  // namespace

double stretched_stiffness(const MethodBody& body, const Material& material, const RelaxationPlan& plan) {
  const Ends ends = ends_of(body.model);
  Scene scene(body.model);
  scene.add(along(ends.axis, 0.0, ends.low)).add(along(ends.axis, strain * ends.length, ends.high));
  VecList start = body.model.rest;
  const double origin = body.model.rest[ends.low.front()][ends.axis];
  for (Vec3& p : start) p[ends.axis] += strain * (p[ends.axis] - origin);
  const auto topology = std::make_shared<const TopologyTextures>(build_topology(body.model, body.options));
  const Relaxation rest = relax(topology, scene, start, plan);
  if (rest.status != "ok") throw Error("its stretching test failed: " + rest.status + ": " + rest.message);
  const double pull = support(ends.high, *topology, scene, rest.state.position).force[ends.axis];
  const double wanted = material.young * strain * volume(body.model, body.model.rest) / ends.length;
  if (!(pull > 0.0)) throw Error("its stretching test failed: it does not pull back");
  return wanted / pull;
}

}  // namespace phymul::bench
