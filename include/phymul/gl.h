// SPDX-License-Identifier: MIT
//
// GlOptions: where and how a GL backend runs. No GL or EGL header is needed to read this one: handles are void*.
#pragma once

#include <string>

namespace phymul {

/// Whose context a GL backend runs in. The host's context, state and bound API are as before after every call.
enum class GlContext {
  own,     ///< one of its own, headless, through EGL; current only during a call
  shared,  ///< one of its own that shares objects with the host's EGL context: its textures can be drawn by the host
  worker,  ///< one of its own on a thread of its own: the safe one beside a host that uses GLX
  current  ///< the one the caller has current at every call, EGL or GLX; what a step touches is put back
};

enum class GlDialect {
  automatic,  ///< desktop GL 3.3 core or later, else OpenGL ES 3.0 or later; "gl-compute": 4.3, else 3.1
  desktop,
  es
};

/// How a shader knows the bases of a particle.
enum class BaseLayout {
  automatic,  ///< enumerated where the base set allows it and that is smaller
  table,      ///< the thesis' bases table
  enumerated  ///< triples counted out of the neighbour list, only beta stored; BaseSelection::all in 3-D with the
              ///< reactions full, shared and barycentric. Error elsewhere
};

/// How the backend "gl-compute" cuts a step into dispatches; the bits are the same.
enum class GlCompute {
  automatic,  ///< workgroup on a GPU where the body is small enough, else store
  store,      ///< forces of attractors, bases, volumes and cells in one dispatch, their sums and Verlet in another
  workgroup   ///< many steps in a dispatch, by one group of invocations: for small bodies, where launching is the cost
};

/// The environment overrides what is left at its default: PHYMUL_EGL (device), PHYMUL_GL_DIALECT (desktop, es),
/// PHYMUL_GL_PASSES (2, 4), PHYMUL_GL_COMPUTE (auto, store, workgroup), PHYMUL_GL_DEBUG (1), PHYMUL_GLSL
/// (shader_folder).
struct GlOptions {
  GlContext context = GlContext::own;
  /// GlContext::shared: the host's EGLDisplay and EGLContext. Null: those current on the thread that makes the solver.
  void* host_display = nullptr;
  void* host_context = nullptr;
  /// "device:N" (N counts EGL devices from 0), "surfaceless" or "default" (the window system's display). Empty: devices
  /// that are no software renderer, then surfaceless, then default.
  std::string device{};
  GlDialect dialect = GlDialect::automatic;
  int passes = 2;  ///< 4: attractor, force, reaction, Verlet, each a pass, as in the 2007 thesis; the same bits, slower
  GlCompute compute = GlCompute::automatic;  ///< of "gl-compute"; `passes` is of "gl"
  BaseLayout layout = BaseLayout::automatic;
  /// step() queues its steps and returns the report of the call before, without waiting for the device; of the first
  /// call after a reset() it has nothing to tell, and steps is 0. A failure is said by the next call, which takes no
  /// step then. Whoever looks at the state (read(), energy(), buffers) waits for what is on its way; run_to_rest()
  /// does. States are the same to the last bit.
  bool late_report = false;
  bool debug = false;           ///< GL debug output; an error in it becomes an Error, in step() device_lost
  std::string shader_folder{};  ///< shaders are read from here in place of those built in; empty: built in
};

}  // namespace phymul
