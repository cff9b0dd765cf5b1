// SPDX-License-Identifier: MIT
#pragma once

#include <emscripten/html5_webgl.h>

#include <memory>

#include "gl/context/context.h"

namespace phymul::gl {

/// A WebGL 2 context: the page's own that is current (GlContext::current), or one of a canvas that nobody sees.
class WebContext : public Context {
 public:
  static std::shared_ptr<WebContext> open(const GlOptions& options, GlBackend backend);
  ~WebContext() override;

 private:
  WebContext() = default;
  void call(Task task, void* argument) override;
  void require_there();

  EMSCRIPTEN_WEBGL_CONTEXT_HANDLE handle_ = 0;
  bool is_own_ = false;
  bool inside_ = false;  ///< a call is running
};

}  // namespace phymul::gl
