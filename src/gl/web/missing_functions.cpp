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

extern "C" {
void glPolygonMode(GLenum, GLenum) {
  missing("glPolygonMode");
}
void glClampColor(GLenum, GLenum) {
  missing("glClampColor");
}
void glDepthRange(GLdouble, GLdouble) {
  missing("glDepthRange");
}
void glClearDepth(GLdouble) {
  missing("glClearDepth");
}
void glClipControl(GLenum, GLenum) {
  missing("glClipControl");
}
void glClipControlEXT(GLenum, GLenum) {
  missing("glClipControlEXT");
}
void glEnablei(GLenum, GLuint) {
  missing("glEnablei");
}
void glDisablei(GLenum, GLuint) {
  missing("glDisablei");
}
GLboolean glIsEnabledi(GLenum, GLuint) {
  missing("glIsEnabledi");
}
void glColorMaski(GLuint, GLboolean, GLboolean, GLboolean, GLboolean) {
  missing("glColorMaski");
}
void glGetBooleani_v(GLenum, GLuint, GLboolean*) {
  missing("glGetBooleani_v");
}
}
