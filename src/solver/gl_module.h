// SPDX-License-Identifier: MIT
//
// The door between the library and its GL part, a module that is loaded at the first wish for it: a machine without
// libGLEW, libEGL or libGL runs everything else.
#pragma once

#include <phymul/backend.h>
#include <phymul/version.h>

#include <array>
#include <cstddef>
#include <string>

namespace phymul {

/// How a GL backend's passes run: drawn by fragment shaders, or dispatched as compute shaders.
enum class GlBackend { fragment, compute };

constexpr const char* name_of(GlBackend backend) {
  return backend == GlBackend::compute ? "gl-compute" : "gl";
}

class Display;       // display.h
struct VisibleSkin;  // view/display_lists.h

/// Both sides must have been built from the same headers. Trivial types only: it is read before anything is trusted.
struct GlModuleStamp {
  char version[16] = PHYMUL_VERSION;
  std::array<std::size_t, 8> sizes{sizeof(SolverBackend), sizeof(SolverOptions),    sizeof(GlOptions), sizeof(Scene),
                                   sizeof(LoadFrame),     sizeof(TopologyTextures), sizeof(Model),     sizeof(State)};
  bool operator==(const GlModuleStamp& other) const {
    return std::string_view(version) == other.version && sizes == other.sizes;
  }
};

struct GlDevice {
  std::string name;       ///< a sentence's worth: renderer, version, driver
  bool software = false;  ///< a processor that plays GPU
};

struct GlModule {
  GlModuleStamp stamp;
  /// Opens a context as the options say and the backend needs, and closes it; throws Error with what was tried.
  GlDevice (*probe)(GlBackend backend, const GlOptions& options) = nullptr;
  std::unique_ptr<Solver> (*make)(GlBackend, std::shared_ptr<const TopologyTextures>, const Scene&,
                                  const SolverOptions&) = nullptr;
  /// Of the solver, or where it is null of what Display::show is given; a skin, where there is one, in place of the
  /// body.
  std::unique_ptr<Display> (*make_display)(const Model& model, const Solver* solver,
                                           std::shared_ptr<const VisibleSkin> skin, const GlOptions& options) = nullptr;
};

/// Name and type of the module's one function.
constexpr const char* gl_module_entry = "phymul_gl_module";
using GlModuleEntry = const GlModule* (*)();

/// The module: PHYMUL_GL_MODULE (a full path), or the first found of phymul/libphymul_gl.so beside the library or
/// program that holds this code, ../lib/phymul/ from there, where the dynamic loader looks, and where it was to be
/// installed. Stays loaded. Throws Error that lists what was tried.
const GlModule& load_gl_module();

}  // namespace phymul
