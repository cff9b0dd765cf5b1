// SPDX-License-Identifier: MIT
//
// A ligament holds a liver to the wall above it. A gallbladder is glued to its lower side.
#include <phymul/phymul.h>

#include <cstdio>

int main() try {
  const phymul::Model liver = phymul::make_block({0.08, 0.06, 0.04}, 8, 6, 4);
  const phymul::Model gallbladder = moved(phymul::make_block({0.04, 0.02, 0.02}, 4, 2, 2), {0.02, 0.02, -0.021});
  phymul::Simulation sim({{"liver", liver}, {"gallbladder", gallbladder}},
                         {.material = phymul::Material{.young = 8e3, .poisson = 0.4, .density = 1060},
                          .solver = {.rest_tolerance = 1e-6}});
  phymul::Scene& scene = sim.scene().gravity({0, 0, -9.81});

  // Parallel fibres, 10 mm long; N/m and N s/m for each m^2 of the surface they hold.
  const phymul::JointHandle ligament =
      scene.attach(sim.model().group("liver/z1"), phymul::World{.offset = {0, 0, 0.01}},
                   {.stiffness = 5e5, .damping = 100, .slack = true, .name = "ligament"});
  const phymul::JointHandle glue = scene.attach(sim.model().group("gallbladder/z1"), "liver",
                                                {.stiffness = 8e6, .breaking_stress = 2e3, .name = "glue"});
  scene.add_joint({phymul::at_mean(sim.model().group("liver/x0")), phymul::at_world({-0.03, 0.03, 0.02})}, 40);

  const phymul::RestResult rest = sim.run_to_rest();
  std::printf("%s\n", rest.message().c_str());
  std::printf("the ligament carries %.2f N, the glue %.3f N; %d of its springs are broken\n",
              sim.report_of(ligament).force.z(), sim.report_of(glue).force.z(), sim.report_of(glue).broken);
  return rest.converged() ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
