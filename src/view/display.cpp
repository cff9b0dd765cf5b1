// SPDX-License-Identifier: MIT
#include <phymul/display.h>
#include <phymul/error.h>

#include "solver/gl_module.h"

namespace phymul {
namespace {

std::unique_ptr<Display> make(const Model& model, const Solver* solver, const GlOptions& gl) {
  validate(model);
#ifdef PHYMUL_HAS_GL
  return load_gl_module().make_display(model, solver, gl);
#else
  (void)solver, (void)gl;
  throw Error(ErrorCode::not_supported, "this build of phymul draws nothing: it was made without GL (PHYMUL_WITH_GL)");
#endif
}

}  // namespace

std::unique_ptr<Display> make_display(const Solver& solver, const GlOptions& gl) {
  return make(solver.model(), &solver, gl);
}

std::unique_ptr<Display> make_display(const Model& model, const GlOptions& gl) {
  return make(model, nullptr, gl);
}

}  // namespace phymul
