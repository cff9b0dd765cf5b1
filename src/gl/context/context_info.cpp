// SPDX-License-Identifier: MIT
#include "context_info.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>

#include "context.h"
#include "gl_api.h"

namespace phymul::gl {
namespace {

/// Sorted.
std::vector<std::string> gl_extensions() {
  const GLint count = integer_of(GL_NUM_EXTENSIONS);
  std::vector<std::string> names;
  for (GLint i = 0; i < count; ++i) {
    if (const GLubyte* name = glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))) {
      names.emplace_back(reinterpret_cast<const char*>(name));
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool is_software_renderer(const std::string& renderer) {
  static constexpr std::array names{"llvmpipe", "softpipe", "swrast", "Software Rasterizer", "SwiftShader", "lavapipe"};
  return std::any_of(names.begin(), names.end(),
                     [&](const char* name) { return renderer.find(name) != std::string::npos; });
}

/// The versions name themselves: "OpenGL ES 3.2 Mesa 22.3.6", "4.5 (Core Profile) Mesa 22.3.6".
void read_version(ContextInfo& info) {
  info.version = gl_text(GL_VERSION);
  info.es = info.version.starts_with("OpenGL ES");
  info.major = integer_of(GL_MAJOR_VERSION);
  info.minor = integer_of(GL_MINOR_VERSION);
  info.core_profile =
      info.es || (info.at_least(3, 2) && (integer_of(GL_CONTEXT_PROFILE_MASK) & GL_CONTEXT_CORE_PROFILE_BIT) != 0);
}

void require_version(const ContextInfo& info) {
  if (info.es ? info.at_least(3, 0) : info.at_least(3, 3)) return;
  throw Error(ErrorCode::device, "expected OpenGL 3.3 or OpenGL ES 3.0, or later, got " + info.device());
}

bool can_report_reset(const ContextInfo& info) {
  if (info.es ? info.at_least(3, 2) : info.at_least(4, 5)) return true;
  return info.has("GL_KHR_robustness") || info.has("GL_ARB_robustness") || info.has("GL_EXT_robustness");
}

}  // namespace

bool ContextInfo::has(std::string_view extension) const {
  return std::binary_search(extensions.begin(), extensions.end(), extension);
}

std::string ContextInfo::device() const {
  const std::size_t mesa = version.find("Mesa");
  const std::string driver = mesa == std::string::npos ? vendor : version.substr(mesa);
  return renderer + ", OpenGL " + (es ? "ES " : "") + std::to_string(major) + "." + std::to_string(minor) +
         (es ? "" : (core_profile ? " core" : " compatibility")) + ", " + driver +
         (software ? ", software renderer" : "");
}

std::int64_t loop_turns_of(std::string_view renderer) {
  return renderer.starts_with("llvmpipe") ? 65535 : std::numeric_limits<std::int64_t>::max();
}

ContextInfo read_context_info() {
  ContextInfo info;
  read_version(info);
  info.vendor = gl_text(GL_VENDOR);
  info.renderer = gl_text(renderer_name);
  info.software = is_software_renderer(info.renderer);
  info.loop_turns = loop_turns_of(info.renderer);
  require_version(info);
  info.glsl_version = gl_text(GL_SHADING_LANGUAGE_VERSION);
  info.extensions = gl_extensions();
  if (info.es && !info.has("GL_EXT_color_buffer_float")) {
    throw Error(ErrorCode::device, info.device() + " cannot draw into float textures (EXT_color_buffer_float)");
  }
  info.max_texture_size = integer_of(GL_MAX_TEXTURE_SIZE);
  info.max_color_attachments = integer_of(GL_MAX_COLOR_ATTACHMENTS);
  info.max_draw_buffers = integer_of(GL_MAX_DRAW_BUFFERS);
  info.has_robustness =
      can_report_reset(info) && integer_of(GL_RESET_NOTIFICATION_STRATEGY) == GL_LOSE_CONTEXT_ON_RESET;
  forget_errors();
  return info;
}

void require_backend(const ContextInfo& info, GlBackend backend) {
  if (backend == GlBackend::fragment || info.computes()) return;
  throw Error(ErrorCode::device, "expected OpenGL 4.3 or OpenGL ES 3.1, or later, for compute shaders, got " +
                                     info.device() + "; the backend \"gl\" runs there, by fragment shaders");
}

bool was_reset(const ContextInfo& info) {
  if (!info.has_robustness) return false;
  const char* name = "glGetGraphicsResetStatus";
  if (info.es && !info.at_least(3, 2)) {
    name = info.has("GL_KHR_robustness") ? "glGetGraphicsResetStatusKHR" : "glGetGraphicsResetStatusEXT";
  } else if (!info.es && !info.at_least(4, 5) && !info.has("GL_KHR_robustness")) {
    name = "glGetGraphicsResetStatusARB";
  }
  const auto query = reinterpret_cast<GLenum(GLAPIENTRY*)()>(eglGetProcAddress(name));
  return query && query() != GL_NO_ERROR;
}

bool Context::lost() noexcept {
  if (lost_) return true;
  try {
    lost_ = run([this] { return was_reset(info_); });
  } catch (...) {  // a context that cannot be made current is not therefore lost; call() has noted it if it is
  }
  return lost_;
}

}  // namespace phymul::gl
