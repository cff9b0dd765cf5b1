// SPDX-License-Identifier: MIT
#include "gl_functions.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <mutex>
#include <utility>

#include "gl_api.h"

namespace phymul::gl {
namespace {

template <class Function>
void fill(Function& pointer, const char* name) {
  if (!pointer) pointer = reinterpret_cast<Function>(eglGetProcAddress(name));
}

/// GLEW takes an OpenGL ES 3.0 context for OpenGL 3.0 and leaves out what came to desktop GL later. It may not be asked
/// for everything (glewExperimental): its version flags, which a host may read, would then be wrong.
void fill_gaps() {
#define PHYMUL_FILL(name) fill(__glew##name, "gl" #name)
  PHYMUL_FILL(CopyBufferSubData);  // OpenGL 3.1
  PHYMUL_FILL(FenceSync);          // 3.2
  PHYMUL_FILL(ClientWaitSync);
  PHYMUL_FILL(DeleteSync);
  PHYMUL_FILL(GetInteger64v);
  PHYMUL_FILL(GetInteger64i_v);
  PHYMUL_FILL(GenSamplers);  // 3.3
  PHYMUL_FILL(DeleteSamplers);
  PHYMUL_FILL(BindSampler);
  PHYMUL_FILL(ClearDepthf);  // 4.1; OpenGL ES 3.0
  PHYMUL_FILL(DepthRangef);
  PHYMUL_FILL(DispatchCompute);  // 4.3; OpenGL ES 3.1
  PHYMUL_FILL(MemoryBarrier);
  PHYMUL_FILL(ClipControl);  // 4.5; an extension of OpenGL ES
  PHYMUL_FILL(ClipControlEXT);
#undef PHYMUL_FILL
}

}  // namespace

void load_functions() {
  static std::mutex mutex;
  static bool loaded = false;
  const std::lock_guard lock(mutex);
  if (loaded) return;
  const GLenum result = glewInit();
  // Under EGL glewInit loads GL's functions, then finds no GLX display and says so: no matter.
  if (result != GLEW_OK && result != GLEW_ERROR_NO_GLX_DISPLAY) {
    throw Error(ErrorCode::device, "GLEW could not load the functions of OpenGL: " +
                                       std::string(reinterpret_cast<const char*>(glewGetErrorString(result))));
  }
  fill_gaps();
  forget_errors();
  loaded = true;
}

std::string egl_error_name(int error) {
  static constexpr std::array<std::pair<int, const char*>, 15> names{
      {{EGL_SUCCESS, "EGL_SUCCESS"},
       {EGL_NOT_INITIALIZED, "EGL_NOT_INITIALIZED"},
       {EGL_BAD_ACCESS, "EGL_BAD_ACCESS"},
       {EGL_BAD_ALLOC, "EGL_BAD_ALLOC"},
       {EGL_BAD_ATTRIBUTE, "EGL_BAD_ATTRIBUTE"},
       {EGL_BAD_CONFIG, "EGL_BAD_CONFIG"},
       {EGL_BAD_CONTEXT, "EGL_BAD_CONTEXT"},
       {EGL_BAD_CURRENT_SURFACE, "EGL_BAD_CURRENT_SURFACE"},
       {EGL_BAD_DISPLAY, "EGL_BAD_DISPLAY"},
       {EGL_BAD_MATCH, "EGL_BAD_MATCH"},
       {EGL_BAD_NATIVE_WINDOW, "EGL_BAD_NATIVE_WINDOW"},
       {EGL_BAD_PARAMETER, "EGL_BAD_PARAMETER"},
       {EGL_BAD_SURFACE, "EGL_BAD_SURFACE"},
       {EGL_BAD_DEVICE_EXT, "EGL_BAD_DEVICE_EXT"},
       {EGL_CONTEXT_LOST, "EGL_CONTEXT_LOST"}}};
  const auto found = std::ranges::find(names, error, &std::pair<int, const char*>::first);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%s (0x%x)", found == names.end() ? "unknown error" : found->second,
                static_cast<unsigned>(error));
  return text.data();
}

}  // namespace phymul::gl
