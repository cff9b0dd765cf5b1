// SPDX-License-Identifier: MIT
//
// GlOptions: where and how a GL backend runs. No GL or EGL header is needed to read this one.
#pragma once

#include <string>

namespace phymul {

/// Whose context a GL backend runs in. The host's context, state and bound API are as before after every call.
enum class GlContext {
  own,     ///< one of its own, headless, through EGL; current only during a call
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

/// The environment overrides what is left at its default: PHYMUL_EGL (device), PHYMUL_GL_DIALECT (desktop, es),
/// PHYMUL_GL_DEBUG (1), PHYMUL_GLSL (shader_folder).
struct GlOptions {
  GlContext context = GlContext::own;
  /// "device:N" (N counts EGL devices from 0), "surfaceless" or "default" (the window system's display). Empty: devices
  /// that are no software renderer, then surfaceless, then default.
  std::string device{};
  GlDialect dialect = GlDialect::automatic;
  BaseLayout layout = BaseLayout::automatic;
  bool debug = false;           ///< GL debug output; an error in it becomes an Error, in step() device_lost
  std::string shader_folder{};  ///< shaders are read from here in place of those built in; empty: built in
};

}  // namespace phymul
