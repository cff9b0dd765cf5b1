// SPDX-License-Identifier: MIT
//
// Bodies that touch, and a scene of them on the device beside the reference.
#pragma once

#include <algorithm>

#include "gl_twins.h"

namespace phymul::test {

inline constexpr double touching_spacing = 0.005;  // m

inline Model tissue(const Vec3& at, const std::array<int, 3>& cells) {
  Model model = make_block(touching_spacing * Vec3(cells[0], cells[1], cells[2]), cells[0], cells[1], cells[2]);
  set_material(model, {5e3, 0.3, 1000.0});
  return moved(std::move(model), at);
}

inline Model joined_bodies(const Model& low, const Model& high) {
  const NamedBody bodies[] = {{"low", &low}, {"high", &high}};
  return merge_models(bodies);
}

/// A cube of 1 cm over the middle of a slab of 2.5 cm, a gap above it and off its lattice.
inline Model stacked(double gap, const Vec3& at = {0, 0, 0}) {
  return joined_bodies(tissue(at, {5, 5, 2}), tissue(at + Vec3(0.0072, 0.0081, 0.01 + gap), {2, 2, 2}));
}

inline double lowest(const State& state, const std::vector<Index>& particles) {
  double z = 1e9;
  for (const Index i : particles) z = std::min(z, state.position[i].z());
  return z;
}

inline Vec3 mean_place(const State& state, const std::vector<Index>& particles) {
  Vec3 centre = Vec3::Zero();
  for (const Index i : particles) centre += state.position[i] / static_cast<double>(particles.size());
  return centre;
}

/// A scene on the device and on the reference.
class BesideReference {
 public:
  BesideReference(const Model& model, const Scene& scene, SolverOptions options, GlBackend backend = GlBackend::compute)
      : tables_(tables_of(model, {})) {
    options.gl.debug = true;
    if (!options.spectrum) options.spectrum = estimate_spectrum(*tables_, tables_->rest);
    dt = 0.4 * stable_step(*options.spectrum, 1.0);
    device = std::make_unique<gl::DeviceSolver>(backend, tables_, scene, options);
    reference = make_solver("reference", tables_, scene, options);
  }

  /// Off the reference by, of the largest motion; after so many steps.
  double off_after(int steps) {
    EXPECT_TRUE(device->step(steps, dt).ok());
    EXPECT_TRUE(reference->step(steps, dt).ok());
    const State a = device->read(), b = reference->read();
    return largest_distance(a.position, b.position) / largest_distance(b.position, tables_->rest);
  }

  /// Both from the state of the device, a step each: largest difference of velocities in units of rounding, and the
  /// largest change of a velocity, m/s. Floats know the places of a contact to a few 2^-24 of an edge and of its way,
  /// which is a speed over a step.
  struct OneStep {
    double off = 0.0, change = 0.0;
  };
  OneStep one_step() {
    const State start = device->read();
    device->reset(start);
    reference->reset(start);
    EXPECT_TRUE(device->step(1, dt).ok());
    EXPECT_TRUE(reference->step(1, dt).ok());
    const State a = device->read(), b = reference->read();
    const double way = touching_spacing + largest_distance(start.position, tables_->rest);
    return {largest_distance(a.velocity, b.velocity) * dt / (0x1p-24 * way),
            largest_distance(b.velocity, start.velocity)};
  }

  std::unique_ptr<gl::DeviceSolver> device;
  std::unique_ptr<Solver> reference;
  double dt = 0.0;

 private:
  std::shared_ptr<const TopologyTextures> tables_;
};

inline SolverOptions damped(double rate) {
  SolverOptions options;
  options.damping.rate = rate;
  return options;
}

}  // namespace phymul::test
