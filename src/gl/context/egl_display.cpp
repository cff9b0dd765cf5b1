// SPDX-License-Identifier: MIT
#include "egl_display.h"

#include <phymul/error.h>

#include <charconv>
#include <cstdlib>
#include <optional>

#include "gl_functions.h"

namespace phymul::gl {
namespace {

EGLDisplay platform_display(EGLenum platform, void* native) {
  static const auto get = egl_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  return get ? get(platform, native, nullptr) : EGL_NO_DISPLAY;
}

std::vector<EGLDeviceEXT> devices() {
  if (!has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") ||
      !(has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") ||
        has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base"))) {
    return {};
  }
  const auto query = egl_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  EGLint count = 0;
  if (!query || !query(0, nullptr, &count)) return {};
  std::vector<EGLDeviceEXT> found(static_cast<std::size_t>(count));
  if (!query(count, found.data(), &count)) return {};
  found.resize(static_cast<std::size_t>(count));
  return found;
}

const char* device_text(EGLDeviceEXT device, EGLint what) {
  static const auto query = egl_function<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  return query ? query(device, what) : nullptr;
}

bool is_software(EGLDeviceEXT device) {
  return has_extension(device_text(device, EGL_EXTENSIONS), "EGL_MESA_device_software");
}

DisplayChoice choose_device(const std::vector<EGLDeviceEXT>& all, std::size_t number) {
  DisplayChoice choice{"device:" + std::to_string(number), platform_display(EGL_PLATFORM_DEVICE_EXT, all[number])};
  if (is_software(all[number])) {
    choice.name += " (a software renderer)";
  } else if (has_extension(device_text(all[number], EGL_EXTENSIONS), "EGL_EXT_device_drm")) {
    if (const char* file = device_text(all[number], EGL_DRM_DEVICE_FILE_EXT)) {
      choice.name += " (" + std::string(file) + ")";
    }
  }
  return choice;
}

DisplayChoice surfaceless() {
  const bool known = has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless");
  return {"surfaceless", known ? platform_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr) : EGL_NO_DISPLAY};
}

DisplayChoice window_system() {
  return {"default", eglGetDisplay(EGL_DEFAULT_DISPLAY)};
}

std::optional<std::size_t> device_number(std::string_view device) {
  constexpr std::string_view prefix = "device:";
  if (!device.starts_with(prefix)) return {};
  device.remove_prefix(prefix.size());
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(device.data(), device.data() + device.size(), number);
  if (error != std::errc() || end != device.data() + device.size()) return {};
  return number;
}

DisplayChoice named_display(const std::string& device, const std::string& who_asked) {
  if (device == "surfaceless") return surfaceless();
  if (device == "default") return window_system();
  const std::optional<std::size_t> number = device_number(device);
  if (!number) {
    throw Error(who_asked + ": expected \"device:N\", \"surfaceless\" or \"default\", got \"" + device + "\"");
  }
  const std::vector<EGLDeviceEXT> all = devices();
  if (*number >= all.size()) {
    throw Error(who_asked + ": expected a device below " + std::to_string(all.size()) +
                ", the number of devices EGL has here, got \"" + device + "\"");
  }
  return choose_device(all, *number);
}

}  // namespace

std::vector<DisplayChoice> display_choices(const std::string& device) {
  if (!device.empty()) return {named_display(device, "GlOptions::device")};
  if (const char* wish = std::getenv("PHYMUL_EGL"); wish && *wish) return {named_display(wish, "PHYMUL_EGL")};

  std::vector<DisplayChoice> choices;
  const std::vector<EGLDeviceEXT> all = devices();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!is_software(all[i])) choices.push_back(choose_device(all, i));
  }
  choices.push_back(surfaceless());
  choices.push_back(window_system());
  return choices;
}

void initialise(EGLDisplay display) {
  if (display == EGL_NO_DISPLAY) throw Error(ErrorCode::device, "EGL has no such display here");
  if (!eglInitialize(display, nullptr, nullptr))
    throw Error(ErrorCode::device, "eglInitialize: " + egl_error_name(eglGetError()));
}

bool has_extension(const char* list, std::string_view name) {
  std::string_view rest = list ? list : "";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == name) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

bool has_egl_extension(EGLDisplay display, std::string_view name) {
  const char* list = eglQueryString(display, EGL_EXTENSIONS);
  if (!list) eglGetError();  // an EGL without client extensions minds the question
  return has_extension(list, name);
}

}  // namespace phymul::gl
