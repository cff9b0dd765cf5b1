// SPDX-License-Identifier: MIT
//
// Forces of the vector backend, by any of its instruction sets, and what share of the rounding bound they are off.
#pragma once

#include <array>
#include <cmath>
#include <initializer_list>
#include <iostream>
#include <limits>
#include <memory>
#include <string>

#include "bodies.h"
#include "bounded_forces.h"
#include "cpu/simd/instruction_set.h"
#include "environment.h"

namespace phymul::test {

/// Names an instruction set in the environment for as long as this lives.
struct InstructionSet : Environment {
  explicit InstructionSet(const char* name) : Environment("PHYMUL_CPU_ISA", name) {}
};

inline SolverOptions any_step(int threads = 1) {
  return {.on_unstable = UnstableStep::allow, .spectrum = Spectrum{1e9, 0.0, 0}, .threads = threads};
}

/// A power of two: nothing is rounded by it.
inline constexpr double tiny_step = 0x1p-20;

/// Elastic forces as one step from standstill shows them: v+ = dt (f / m).
inline VecList forces_of(Solver& solver, const VecList& position) {
  State state = rest_state(solver.model());
  state.position = position;
  solver.reset(state);
  EXPECT_TRUE(solver.step(1, tiny_step).ok());
  solver.read(state);
  VecList force = state.velocity;
  for (std::size_t i = 0; i < force.size(); ++i) force[i] *= solver.topology().mass[i] / tiny_step;
  return force;
}

/// Random displacements, each exactly a float.
inline VecList random_displacements(const Model& model, double amount, std::uint32_t seed) {
  VecList u = random_positions(model, amount, seed);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = (u[i] - model.rest[i]).cast<float>().cast<double>();
  return u;
}

/// The largest error of a component over its bound; infinite where it is beyond a bound of 0.
inline double share_of_bound(const Bounded3& bound, const Vec3& exact, const Vec3& found) {
  const std::array<double, 3> most{bound.x.error, bound.y.error, bound.z.error};
  double share = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    // The mass and its inverse, and their product with the force, are rounded too.
    const double allowed = most[static_cast<std::size_t>(axis)] + 3.0 * unit * std::abs(exact[axis]);
    const double error = std::abs(found[axis] - exact[axis]);
    if (!(error <= allowed) && allowed == 0.0) return std::numeric_limits<double>::infinity();
    if (allowed > 0.0) share = std::max(share, std::isfinite(error) ? error / allowed : 2.0);
  }
  return share;
}

/// Holds forces to the rounding bound, and keeps the largest share of it that any was off.
class ShareOfBound {
 public:
  /// At displacements u, each exactly a float; by every instruction set, with every number of threads.
  void look(const std::shared_ptr<const TopologyTextures>& tables, const Scene& scene, const VecList& u,
            const std::string& what, std::initializer_list<int> threads = {1}) {
    const VecList x = sum_of(tables->rest, u);
    const VecList exact = forces_at(*tables, x);
    const BoundedForces bounded(*tables, u);
    for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) {
      const InstructionSet chosen(kernels->name);
      for (const int count : threads) {
        const VecList found = forces_of(*make_solver("cpu", tables, scene, any_step(count)), x);
        for (std::size_t i = 0; i < x.size(); ++i) {
          const double share = share_of_bound(bounded.force(static_cast<Index>(i)), exact[i], found[i]);
          ASSERT_LE(share, 1.0) << what << ", " << kernels->name << ", " << count << " threads, particle " << i;
          if (share <= worst_) continue;
          worst_ = share;
          where_ = what + ", " + kernels->name;
        }
      }
    }
  }
  /// A bound that nothing comes near would hide mistakes.
  void expect_some() const {
    std::cout << "worst error: " << worst_ << " of the bound (" << where_ << ")\n";
    EXPECT_GT(worst_, 0.01);
  }

 private:
  double worst_ = 0.0;
  std::string where_;
};

}  // namespace phymul::test
