// SPDX-License-Identifier: MIT
//
// Three regions of a labelled image, each with its material: liver, vessel and kidney hang from their top.
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

phymul::LabelImage painted() {
  phymul::LabelImage image;
  image.size = {64, 48, 48};
  for (int axis = 0; axis < 3; ++axis) image.step[axis] = 2e-3 * phymul::Vec3::Unit(axis);  // m
  for (int voxel = 0; voxel < 64 * 48 * 48; ++voxel) {
    const double i = voxel % 64 - 25, j = voxel / 64 % 48 - 24, k = voxel / (64 * 48) - 24;
    const bool liver = std::hypot(i / 22, j / 20, k / 20) < 1, vessel = liver && std::hypot(i, k + 4) < 4;
    const bool kidney = std::hypot((i - 26) / 10, j / 14, k / 18) < 1;
    image.label.push_back(vessel ? 2 : liver ? 1 : kidney ? 3 : 0);
  }
  return image;
}

int main(int argc, char** argv) try {
  const phymul::LabelImage image = argc > 1 ? phymul::read_labels(argv[1]) : painted();
  phymul::BodyReport report;
  phymul::Model body = phymul::make_body(
      image, {.spacing = 0.008, .regions = {{1, "liver"}, {2, "vessel"}, {3, "kidney"}}}, &report);  // spacing: m
  for (const phymul::RegionReport& region : report.regions)
    std::printf("%s: %.1f of %.1f ml\n", region.name.c_str(), 1e6 * region.volume, 1e6 * region.wanted_volume);
  double low = body.rest[0].z(), high = low;
  for (const phymul::Vec3& at : body.rest) low = std::min(low, at.z()), high = std::max(high, at.z());
  body.add_group("top", body.particles_in([&](const phymul::Vec3& at) { return at.z() > high - 0.2 * (high - low); }));
  phymul::Simulation sim(body, {.materials = {{"liver", {.young = 4e3, .poisson = 0.45, .density = 1060}},
                                              {"vessel", {.young = 60e3, .poisson = 0.45, .density = 1050}},
                                              {"kidney", {.young = 12e3, .poisson = 0.45, .density = 1050}}}});
  sim.scene().fix("top").gravity({0, 0, -9.81});
  const phymul::RestResult rest = sim.run_to_rest();
  std::printf("%s; sags %.1f mm\n", rest.message().c_str(), 1e3 * sim.max_displacement());
  phymul::write_vtu(sim.model(), sim.state(), "segmentation.vtu");  // for ParaView
  return rest.converged() ? 0 : 1;
} catch (const phymul::Error& error) {
  return std::puts(error.what()), 1;
}
