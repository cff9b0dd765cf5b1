// SPDX-License-Identifier: MIT
//
// EGL displays to look for a context on. A display is the process': no one here ever ends one (eglTerminate), which
// would take the host's contexts with it.
#pragma once

#include <phymul/gl.h>

#include <string>
#include <string_view>
#include <vector>

#include "gl_api.h"

namespace phymul::gl {

struct DisplayChoice {
  std::string name;  ///< "device:0 (/dev/dri/renderD128)", "surfaceless", "default"
  EGLDisplay display = EGL_NO_DISPLAY;
};

/// Displays in the order they should be tried, none of them initialised: the one that GlOptions::device or PHYMUL_EGL
/// names, or devices that are no software renderer, surfaceless, default. Throws Error for a name that is none.
std::vector<DisplayChoice> display_choices(const std::string& device);

/// eglInitialize, or an Error with EGL's reason.
void initialise(EGLDisplay display);

/// Is `name` a word of the list, as eglQueryString and eglQueryDeviceStringEXT give them? A null list is empty.
bool has_extension(const char* list, std::string_view name);

/// Of the display, or with EGL_NO_DISPLAY of EGL itself.
bool has_egl_extension(EGLDisplay display, std::string_view name);

template <class Function>
Function egl_function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

}  // namespace phymul::gl
