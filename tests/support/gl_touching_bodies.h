// SPDX-License-Identifier: MIT
//
// A scene of bodies that touch on the device beside the reference.
#pragma once

#include "gl_twins.h"
#include "touching_bodies.h"

namespace phymul::test {

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
    EXPECT_TRUE(all_step(steps, dt, device, reference));
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
    EXPECT_TRUE(all_step(1, dt, device, reference));
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

}  // namespace phymul::test
