// SPDX-License-Identifier: MIT
#include <phymul/display.h>
#include <phymul/error.h>

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

}  // namespace phymul
