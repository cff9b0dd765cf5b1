// SPDX-License-Identifier: MIT
//
// The one function that the module shows.
#include "base/compiler.h"
#include "device_solver.h"
#include "gl/context/context.h"
#include "gl/display/body_drawing.h"
#include "solver/gl_module.h"

namespace phymul::gl {
namespace {

GlDevice probe(GlBackend backend, const GlOptions& options) {
  const ContextInfo info = Context::open(options, backend)->info();
  return {info.device(), info.software};
}

}  // namespace
}  // namespace phymul::gl

extern "C" PHYMUL_EXPORT const phymul::GlModule* phymul_gl_module() {
  static const phymul::GlModule module{.stamp = {},
                                       .probe = phymul::gl::probe,
                                       .make = phymul::gl::make_device_solver,
                                       .make_display = phymul::gl::make_display};
  return &module;
}
