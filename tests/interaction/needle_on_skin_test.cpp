// SPDX-License-Identifier: MIT
//
// A needle that presses on the skin and is dragged: dry friction alone holds what it presses, until it punctures.
#include <algorithm>

#include "support/needle_insertion.h"

namespace phymul::test {
namespace {

using NeedleOnSkin = WithTools;
PHYMUL_WITH_NEEDLES(NeedleOnSkin);

TEST_P(NeedleOnSkin, StaysInItsConeUntilItPunctures) {
  constexpr double friction = 0.5;              // Insertion's
  for (const double stiffness : {0.0, 2e-2}) {  // N m^2; 0: a stiff shaft
    SCOPED_TRACE(stiffness);
    Needle blunt = thin_needle();
    blunt.puncture = 50.0;
    blunt.bending_stiffness = stiffness;
    Insertion needle(GetParam(), 4, 0.5, blunt);
    needle.go(0.002, 0.1, 5);
    double most = 0.0;
    for (int k = 0; k < 20; ++k) {
      needle.pose.position.x() += 0.4e-3;
      needle.scene.tool("needle").move_to(needle.pose);
      ASSERT_TRUE(needle.solver->step(4, needle.dt).ok());
      const Vec3 force = needle.solver->tool_force("needle").force;
      ASSERT_GT(force.z(), 0.02);
      const double across = force.head<2>().norm() / force.z();
      EXPECT_LE(across, friction * (1.0 + 1e3 * roundoff())) << k;
      most = std::max(most, across);
    }
    EXPECT_GT(most, 0.99 * friction);  // it was dragged hard enough to slide
    EXPECT_FALSE(needle.solver->read().tools.at(0).needle.punctured);
  }
}

}  // namespace
}  // namespace phymul::test
