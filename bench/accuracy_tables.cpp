// SPDX-License-Identifier: MIT
//
// Prints how well a calibrated body does as a material and as a beam: `accuracy_tables [largest n]` (default 16, which
// takes minutes in the double-precision reference).
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "support/bodies.h"
#include "support/mechanics.h"
#include "usage.h"

namespace {

using namespace phymul;
using namespace phymul::test;

void stretch_table() {
  std::printf("Uniform stretch between frictionless plates, asked E = 10 kPa: E found / asked, nu found\n");
  std::printf("%-34s %-18s %-18s %-18s\n", "body", "nu 0", "nu 0.3", "nu 0.45");
  struct Row {
    const char* name;
    Model model;
  };
  std::vector<Row> rows{{"lattice 6x4x4", make_block({0.06, 0.04, 0.04}, 6, 4, 4)},
                        {"tetrahedra of 6x4x4", make_tetrahedral_block({0.06, 0.04, 0.04}, 6, 4, 4, 0.2, 1)},
                        {"tetrahedra of 12x8x8", make_tetrahedral_block({0.06, 0.04, 0.04}, 12, 8, 8, 0.2, 2)}};
  for (Row& row : rows) {
    std::printf("%-34s", row.name);
    for (double poisson : {0.0, 0.3, 0.45}) {
      const Material tissue = soft_tissue(poisson);
      set_material(row.model, tissue);
      const Moduli found = stretch_block(row.model, build_topology(row.model), 1e-4);
      std::printf(" %.4f %8.4f   ", found.young / tissue.young, found.poisson);
    }
    std::printf("\n");
  }
}

void cantilever_table(int largest) {
  std::printf("\nCantilever 0.2 x 0.05 x 0.05 m under a small weight: tip deflection over Timoshenko's\n");
  std::printf("root as in beam theory (free to narrow) | root clamped\n");
  std::printf("%-30s %-6s", "energy", "nu");
  for (int n = 2; n <= largest; n *= 2) std::printf("       n = %-5d", n);
  std::printf("\n");
  for (double poisson : {0.0, 0.3, 0.45}) {
    const Material tissue = soft_tissue(poisson);
    std::printf("%-30s %-6.2f", "material", poisson);
    for (int n = 2; n <= largest; n *= 2) {
      const Model beam = cantilever(n, tissue);
      const TopologyTextures topology = build_topology(beam);
      std::printf("  %.4f|%.4f", cantilever_ratio(beam, topology, tissue, Root::beam),
                  cantilever_ratio(beam, topology, tissue, Root::clamped));
      std::fflush(stdout);
    }
    std::printf("\n");
  }
  std::printf("%-30s %-6.2f", "averaged attractor", 0.3);
  for (int n = 2; n <= std::min(largest, 8); n *= 2) {
    const Material tissue = soft_tissue();
    const Model beam = cantilever(n, tissue);
    const TopologyTextures topology = averaged_tables(beam);
    std::printf("  %6.2f|%6.2f", cantilever_ratio(beam, topology, tissue, Root::beam),
                cantilever_ratio(beam, topology, tissue, Root::clamped));
    std::fflush(stdout);
  }
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(argc, argv,
                          "accuracy_tables [largest number of cells across the cantilever], default 16\n"
                          "Moduli found against those asked for, and cantilevers against beam theory.")) {
    return 0;
  }
  stretch_table();
  cantilever_table(argc > 1 ? std::atoi(argv[1]) : 16);
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
