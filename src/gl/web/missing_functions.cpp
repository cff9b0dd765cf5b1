// SPDX-License-Identifier: MIT
//
// Functions of OpenGL that WebGL 2 lacks. The callers ask ContextInfo first, which never says that they are there.
#include <cstdio>
#include <cstdlib>

#include "web_api.h"

namespace {

[[noreturn]] void missing(const char* name) {
  std::fprintf(stderr, "phymul: %s was called, which WebGL 2 does not have\n", name);
  std::abort();
}

}  // namespace

#define PHYMUL_MISSING(type, name, ...) \
  type name(__VA_ARGS__) {              \
    missing(#name);                     \
  }

extern "C" {
PHYMUL_MISSING(void, glPolygonMode, GLenum, GLenum)
PHYMUL_MISSING(void, glClampColor, GLenum, GLenum)
PHYMUL_MISSING(void, glDepthRange, GLdouble, GLdouble)
PHYMUL_MISSING(void, glClearDepth, GLdouble)
PHYMUL_MISSING(void, glClipControl, GLenum, GLenum)
PHYMUL_MISSING(void, glClipControlEXT, GLenum, GLenum)
PHYMUL_MISSING(void, glEnablei, GLenum, GLuint)
PHYMUL_MISSING(void, glDisablei, GLenum, GLuint)
PHYMUL_MISSING(GLboolean, glIsEnabledi, GLenum, GLuint)
PHYMUL_MISSING(void, glColorMaski, GLuint, GLboolean, GLboolean, GLboolean, GLboolean)
PHYMUL_MISSING(void, glGetBooleani_v, GLenum, GLuint, GLboolean*)
}

#undef PHYMUL_MISSING
