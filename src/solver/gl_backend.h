// SPDX-License-Identifier: MIT
#pragma once

namespace phymul {

/// How a GL backend's passes run: drawn by fragment shaders, or dispatched as compute shaders.
enum class GlBackend { fragment, compute };

constexpr const char* name_of(GlBackend backend) {
  return backend == GlBackend::compute ? "gl-compute" : "gl";
}

}  // namespace phymul
