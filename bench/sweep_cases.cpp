// SPDX-License-Identifier: MIT
#include "sweep_cases.h"

#include <phymul/topology_textures.h>

#include <cmath>

namespace phymul::bench {
namespace {

constexpr double spacing = 0.005;  // m
constexpr double offset = 0.02;    // of the spacing

}  // namespace

const std::vector<SweepVariant>& sweep_variants() {
  const auto with = [](Reaction reaction, BaseSelection bases) {
    return TopologyOptions{.reaction = reaction, .bases = bases, .on_sparse = SparseParticle::springs};
  };
  static const std::vector<SweepVariant> all{
      {"springs", "none", 0, false, {.law = Law::springs}},
      {"shared_6_all", "all", 6, false, with(Reaction::shared, BaseSelection::all)},
      {"shared_14_all", "all", 14, false, with(Reaction::shared, BaseSelection::all)},
      {"averaged_6", "above the threshold", 6, false, with(Reaction::averaged, BaseSelection::thresholded)},
      {"material_lattice", "none", 6, true, {}},
      {"material_tetrahedra", "none", 0, true, {}},
  };
  return all;
}

const std::vector<int>& sweep_sizes() {
  static const std::vector<int> all{4, 275, 512, 4096, 32768, 262144, 2097152, 16777216};
  return all;
}

bool has_body(const SweepVariant& variant, int size) {
  if (size == 4) return variant.valence == 0 || variant.name == "averaged_6";
  return size != 275 || (variant.valence != 14 && variant.name != "material_tetrahedra");
}

Model sweep_body(const SweepVariant& variant, int size) {
  if (size == 4) return make_tetrahedron(2.0 * spacing);
  Model model;
  if (size == 275) {
    model = make_cylinder(0.010, 0.040, 3, 8, 11);
  } else {
    const int n = static_cast<int>(std::lround(std::cbrt(size))) - 1;
    const Vec3 sides = n * spacing * Vec3::Ones();
    model = variant.valence > 0 ? make_block(sides, n, n, n, variant.valence)
                                : make_tetrahedral_block(sides, n, n, n, 0.2, 7);
  }
  if (variant.material) set_material(model, {.young = 10e3, .poisson = 0.3, .density = 1000.0});
  return model;
}

State sweep_start(const Model& model) {
  State state = rest_state(model);
  const double h = mean_spacing(model);
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    const auto phase = static_cast<double>(i % 7);
    state.position[i] += offset * h * Vec3(std::sin(phase), std::cos(2.0 * phase), std::sin(3.0 * phase + 1.0));
  }
  return state;
}

}  // namespace phymul::bench
