// SPDX-License-Identifier: MIT
//
// Time and memory to make a solver of one body: the tables, the solver of backend cpu with its step limit, five steps.
// One body a process, because memory is what the process has reached.
//   set_up_table lattice|springs|tetrahedra cells_along_an_edge
//   set_up_table surface.stl spacing          (m; the file in mm)
#include <phymul/phymul.h>

#include <sys/resource.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <string>

#include "stopwatch.h"
#include "usage.h"

namespace {

using namespace phymul;

constexpr const char* usage =
    "usage: set_up_table lattice|springs|tetrahedra cells_along_an_edge\n"
    "       set_up_table surface.stl spacing        m, of a surface in mm";

/// Bytes that the process has in memory.
double resident() {
  double pages = 0.0;
  std::ifstream("/proc/self/statm") >> pages >> pages;
  return 4096.0 * pages;
}

double peak() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return 1024.0 * static_cast<double>(use.ru_maxrss);
}

Model body(const std::string& kind, double size) {
  const int cells = static_cast<int>(size);
  const Vec3 edges = Vec3::Constant(0.01 * cells);
  if (kind == "springs") return make_block(edges, cells, cells, cells);
  Model model = kind == "lattice"      ? make_block(edges, cells, cells, cells)
                : kind == "tetrahedra" ? make_tetrahedral_block(edges, cells, cells, cells, 0.2, 1)
                                       : make_body(read_surface(kind, 1e-3), {.spacing = size});
  set_material(model, {.young = 10e3, .poisson = 0.45, .density = 1000});
  return model;
}

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(argc, argv, usage)) return 0;
  if (argc != 3) return std::fputs(usage, stderr), 2;
  const std::string kind = argv[1];
  const double before = resident();
  double processor = processor_seconds();
  Stopwatch wall;
  const Model model = body(kind, std::atof(argv[2]));
  const double particles = model.particle_count();
  std::printf("%.0f particles\n", particles);
  const auto print = [&](const char* stage) {
    std::printf("%-8s %9.3f s, %9.3f s of processor time, %5.0f bytes a particle, at most %5.0f\n", stage,
                wall.seconds(), processor_seconds() - processor, (resident() - before) / particles,
                (peak() - before) / particles);
    wall = {};
    processor = processor_seconds();
  };
  print("model");
  TopologyOptions options;
  if (kind == "springs") options.law = Law::springs;
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, options));
  print("tables");
  const Scene scene(model);
  const auto solver = make_solver("cpu", tables, scene);
  print("solver");
  const bool ok = solver->step(5, 0.1 * solver->stable_step()).ok();
  print("5 steps");
  return ok ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
