// SPDX-License-Identifier: MIT
//
// gl_api.h where GL is WebGL 2: names of OpenGL ES 3.0, and those of later versions and of desktop OpenGL that the
// sources mention for contexts that have them. No WebGL context has: missing_functions.cpp defines them as errors.
#pragma once

#include <GLES3/gl32.h>

using GLdouble = double;
using GLclampd = double;

// Constants, under their desktop names.
#include <GL/glext.h>
#include <webgl/webgl2.h>

#define GLAPIENTRY
#define GL_FILL 0x1B02
#define GL_POLYGON_MODE 0x0B40
#define GL_POLYGON_SMOOTH 0x0B41
#define GL_POLYGON_STIPPLE 0x0B42
#define GL_LINE_SMOOTH 0x0B20
#define GL_ALPHA_TEST 0x0BC0
#define GL_COLOR_LOGIC_OP 0x0BF2
#define GL_PACK_SWAP_BYTES 0x0D00
#define GL_PACK_LSB_FIRST 0x0D01
#define GL_UNPACK_SWAP_BYTES 0x0CF0
#define GL_UNPACK_LSB_FIRST 0x0CF1

extern "C" {
void glPolygonMode(GLenum face, GLenum mode);
void glClampColor(GLenum target, GLenum clamp);
void glDepthRange(GLdouble near, GLdouble far);
void glClearDepth(GLdouble depth);
void glClipControl(GLenum origin, GLenum depth);
void glClipControlEXT(GLenum origin, GLenum depth);
}

namespace phymul::gl {

inline constexpr GLenum renderer_name = 0x9246;  // UNMASKED_RENDERER_WEBGL: GL_RENDERER says "WebKit WebGL" everywhere
inline constexpr bool in_browser = true;

/// There is nothing to look up: what the browser has is linked.
inline void* eglGetProcAddress(const char*) {
  return nullptr;
}

}  // namespace phymul::gl
