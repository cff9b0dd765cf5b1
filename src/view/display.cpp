// SPDX-License-Identifier: MIT
#include <phymul/display.h>
#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "solver/gl_module.h"
#include "visible_skin.h"

namespace phymul {
namespace {

std::unique_ptr<Display> make(const Model& model, const Solver* solver, std::shared_ptr<const VisibleSkin> skin,
                              const GlOptions& gl) {
  validate(model);
#ifdef PHYMUL_HAS_GL
  return load_gl_module().make_display(model, solver, std::move(skin), gl);
#else
  (void)solver, (void)skin, (void)gl;
  throw Error(ErrorCode::not_supported, "this build of phymul draws nothing: it was made without GL (PHYMUL_WITH_GL)");
#endif
}

}  // namespace

std::unique_ptr<Display> make_display(const Solver& solver, const GlOptions& gl) {
  return make(solver.model(), &solver, nullptr, gl);
}

std::unique_ptr<Display> make_display(const Solver& solver, const Skin& skin,
                                      std::span<const std::array<Index, 3>> triangles, const GlOptions& gl) {
  if (skin.size() == 0) throw Error(ErrorCode::invalid_argument, "make_display: expected a skin with points, got none");
  if (!skin.is_bound_to(solver.model())) {
    throw Error(ErrorCode::invalid_argument,
                "make_display: expected a skin bound to the solver's body, got one of another body; bind its points to "
                "Solver::model()");
  }
  Model surface;
  surface.rest = skin.deform(solver.model().rest);
  for (const std::array<Index, 3>& triangle : triangles) {
    for (const Index point : triangle) {
      if (point >= 0 && point < surface.particle_count()) continue;
      throw Error(ErrorCode::invalid_argument, "make_display: a triangle of point " + std::to_string(point) +
                                                   " of a skin of " + std::to_string(skin.size()) + " points");
    }
    surface.cells.push_back({.type = CellType::triangle, .particles = {triangle.begin(), triangle.end()}});
  }
  surface.neighbours = neighbours_from_cells(surface.cells, surface.particle_count());
  return make(solver.model(), &solver, std::make_shared<VisibleSkin>(skin, std::move(surface)), gl);
}

std::unique_ptr<Display> make_display(const Model& model, const GlOptions& gl) {
  return make(model, nullptr, nullptr, gl);
}

/// At equal distances in CIELAB, along lightness 92 to 26, hue 190 to 320 degrees, chroma 5 to 60.
Colour displacement_colour(double share) {
  static constexpr std::array<std::array<double, 3>, 17> table{{{0.867, 0.922, 0.916},
                                                                {0.761, 0.893, 0.891},
                                                                {0.650, 0.849, 0.868},
                                                                {0.542, 0.800, 0.852},
                                                                {0.442, 0.750, 0.841},
                                                                {0.351, 0.699, 0.831},
                                                                {0.272, 0.647, 0.820},
                                                                {0.212, 0.596, 0.807},
                                                                {0.180, 0.545, 0.790},
                                                                {0.182, 0.494, 0.768},
                                                                {0.208, 0.443, 0.741},
                                                                {0.244, 0.392, 0.709},
                                                                {0.281, 0.341, 0.671},
                                                                {0.315, 0.288, 0.628},
                                                                {0.344, 0.234, 0.581},
                                                                {0.367, 0.175, 0.530},
                                                                {0.385, 0.104, 0.475}}};
  // Not clamp(): a share that is not a number, as 0 / 0 of a body at rest, counts as 0.
  const double place = (share > 0.0 ? std::min(share, 1.0) : 0.0) * static_cast<double>(table.size() - 1);
  const auto row = std::min(static_cast<std::size_t>(place), table.size() - 2);
  const double t = place - static_cast<double>(row);
  Colour colour{0.0, 0.0, 0.0, 1.0};
  for (std::size_t k = 0; k < 3; ++k) colour[k] = table[row][k] + t * (table[row + 1][k] - table[row][k]);
  return colour;
}

}  // namespace phymul
