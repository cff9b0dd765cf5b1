// SPDX-License-Identifier: MIT
#include "context_debug.h"

#include <phymul/error.h>

#include <utility>

#include "context_info.h"
#include "gl_api.h"

namespace phymul::gl {
namespace {

constexpr int most_messages = 10;

void GLAPIENTRY receive(GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* text, const void* log) noexcept {
  if (type != GL_DEBUG_TYPE_ERROR && type != GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR) return;
  static_cast<DebugLog*>(const_cast<void*>(log))->add(text);
}

}  // namespace

void DebugLog::listen(const ContextInfo& info) {
  const bool in_core = info.es ? info.at_least(3, 2) : info.at_least(4, 3);
  if (!in_core && !info.has("GL_KHR_debug")) return;
  const char* name = info.es && !in_core ? "glDebugMessageCallbackKHR" : "glDebugMessageCallback";
  const auto callback = reinterpret_cast<PFNGLDEBUGMESSAGECALLBACKPROC>(eglGetProcAddress(name));
  if (!callback) return;
  callback(receive, this);
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
}

void DebugLog::add(const std::string& message) {
  const std::lock_guard lock(mutex_);
  if (++count_ <= most_messages) messages_ += (messages_.empty() ? "" : "; ") + message;
}

void DebugLog::throw_errors() {
  std::string messages;
  int count = 0;
  {
    const std::lock_guard lock(mutex_);
    messages = std::exchange(messages_, {});
    count = std::exchange(count_, 0);
  }
  if (count == 0) return;
  throw Error(ErrorCode::device,
              "GL reports " + std::to_string(count) + (count == 1 ? " error: " : " errors: ") + messages);
}

}  // namespace phymul::gl
