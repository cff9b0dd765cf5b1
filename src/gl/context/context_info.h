// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/gl.h>

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "solver/gl_module.h"

namespace phymul::gl {

struct ContextInfo {
  bool es = false;           ///< OpenGL ES, not desktop OpenGL
  int major = 0, minor = 0;  ///< of OpenGL or OpenGL ES
  bool core_profile = true;  ///< false: a desktop context that still knows the fixed functions (a host's)
  std::string vendor, renderer, version, glsl_version;
  std::string display;    ///< where it was found: "device:0 (/dev/dri/renderD128)", "surfaceless", "host"
  bool software = false;  ///< the renderer is a processor, not a GPU
  std::int64_t loop_turns = std::numeric_limits<std::int64_t>::max();  ///< loop_turns_of(renderer)
  int max_texture_size = 0;
  int max_color_attachments = 0;
  int max_draw_buffers = 0;
  bool has_robustness = false;          ///< a reset of the device can be asked for, and takes no other context along
  std::vector<std::string> extensions;  ///< sorted

  bool at_least(int wanted_major, int wanted_minor) const {
    return major > wanted_major || (major == wanted_major && minor >= wanted_minor);
  }
  bool has(std::string_view extension) const;
  /// "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 core, Mesa 22.3.6, software renderer"
  std::string device() const;
  /// Storage buffers and compute shaders: OpenGL 4.3, OpenGL ES 3.1.
  bool computes() const { return es ? at_least(3, 1) : at_least(4, 3); }
};

/// Of the context that is current; functions must be loaded. Throws Error when it is none phymul can work in: OpenGL
/// 3.3 or OpenGL ES 3.0 with EXT_color_buffer_float.
ContextInfo read_context_info();

/// Throws Error where the context is none that the backend can run in.
void require_backend(const ContextInfo& info, GlBackend backend);

/// Turns of all loops of a shader together after which they end, done or not. None but llvmpipe's are known to do so
/// (Mesa's LP_MAX_TGSI_LOOP_ITERATIONS).
std::int64_t loop_turns_of(std::string_view renderer);

/// Has the device been reset? Of the current context.
bool was_reset(const ContextInfo& info);

}  // namespace phymul::gl
