// SPDX-License-Identifier: MIT
//
// Single steps of a GL backend: beside those of its float mirror, within the rounding bound, and at rest.
#pragma once

#include <algorithm>
#include <cstdio>

#include "support/bounded_forces.h"
#include "support/gl_twins.h"

namespace phymul::test {

/// From so many states, each further off rest by `further` of the spacing. Skips the test on a renderer that does not
/// keep to the text of shaders.
inline void expect_the_mirrors_bits(const GlTwins& twins, const Model& model, int states, double further) {
  if (!twins.same_bits_expected()) {
    GTEST_SKIP() << "NOT TESTED: " << twins.gl->device() << " is not llvmpipe of Mesa 22";
  }
  const double dt = 0.3 * std::min(twins.gl->stable_step(), 1.0);
  const double speed = 0.1 * mean_spacing(model) / dt;
  for (int k = 0; k < states; ++k) {
    twins.reset(random_state(model, 0.02 + further * k, speed, 17 + k));
    ASSERT_TRUE(all_step(1, dt, twins.gl, twins.mirror));
    ASSERT_EQ(difference(twins.gl->read(), twins.mirror->read()), "") << "state " << k;
  }
}

/// The largest errors of forces in single steps from standing still: velocities are dt / m times the forces, whose
/// bound follows from the formulas; nothing in it is fitted.
struct SingleStepErrors {
  double of_bound = 0.0, of_force = 0.0;  ///< of the largest force of the body, by the double reference

  /// Expects them within the bound; `further` as above.
  void measure(const GlTwins& twins, const TopologyTextures& tables, int states, double further) {
    const double dt = 0.3 * std::min(twins.gl->stable_step(), 1.0);
    for (int k = 0; k < states; ++k) {
      twins.gl->reset(random_state(twins.gl->model(), 0.05 + further * k, 0.0, 29 + k));
      const State start = twins.gl->read();  // as rounded
      VecList u = start.position, exact(u.size());
      for (std::size_t i = 0; i < u.size(); ++i) u[i] = (u[i] - tables.rest[i]).cast<float>().cast<double>();
      elastic_forces(tables, start.position, exact);
      ASSERT_TRUE(twins.gl->step(1, dt).ok());
      const VecList velocity = twins.gl->read().velocity;
      of_bound = std::max(of_bound, share_of_bound(tables, BoundedForces(tables, u), velocity, dt));
      const double largest = largest_norm(exact);
      for (std::size_t i = 0; i < u.size(); ++i) {
        of_force = std::max(of_force, (tables.mass[i] / dt * velocity[i] - exact[i]).norm() / largest);
      }
    }
  }
  void print() const {
    std::printf("[   BOUND  ] worst error %.3f of the bound, %.2g of the largest force\n", of_bound, of_force);
  }
};

/// Steps from the rest shape, shifted, change no bit.
inline void expect_rest_is_kept(const GlTwins& twins, const Model& model, const Vec3& shift, int steps) {
  State start = rest_state(model);
  for (Vec3& x : start.position) x += shift;
  twins.gl->reset(start);
  start = twins.gl->read();
  ASSERT_TRUE(twins.gl->step(steps, 0.3 * twins.gl->stable_step()).ok());
  State end = twins.gl->read();
  end.time = start.time;
  EXPECT_EQ(difference(end, start), "");
}

}  // namespace phymul::test
