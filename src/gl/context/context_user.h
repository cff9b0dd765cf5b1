// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/gl.h>

#include <memory>

namespace phymul::gl {

class Context;

/// What the GL solvers are besides solvers: somebody whose objects others may want to read where they lie.
class ContextUser {
 public:
  virtual ~ContextUser() = default;
  virtual const std::shared_ptr<Context>& context() const = 0;  ///< another one after a loss
  /// Whose context it is: objects are seen in the host's where it is GlContext::current or shared.
  virtual GlContext context_kind() const = 0;
};

}  // namespace phymul::gl
