// SPDX-License-Identifier: MIT
//
// Context: where GL calls are made, whosever context it is.
#pragma once

#include <phymul/error.h>
#include <phymul/gl.h>

#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "context_info.h"
#include "solver/gl_module.h"

namespace phymul::gl {

/// A context that is there, but cannot be made current now: the host has another one current, or it is on another
/// thread.
struct Unreachable : Error {
  using Error::Error;
};

/// Who has GL objects keeps a std::shared_ptr to their context, and makes, uses and deletes them inside run(). One
/// thread at a time.
class Context {
 public:
  /// As GlOptions::context says, of the version that the backend needs. Throws Error that lists what was tried.
  static std::shared_ptr<Context> open(const GlOptions& options, GlBackend backend = GlBackend::fragment);

  virtual ~Context() = default;
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  /// Calls f with the context current, and leaves the caller's thread as it was: what EGL had bound there, and with
  /// GlContext::current the state of the caller's context (see StateGuard). Returns what f returns (a value), and
  /// throws what it throws; Error where the context cannot be made current. A run() inside f costs nothing.
  template <class Function>
  std::invoke_result_t<Function&> run(Function&& function);

  /// Deletes objects: run() that never throws, and does nothing where the context is lost or cannot be reached, as
  /// their objects went with it or belong to a host that has put its context away.
  template <class Function>
  void discard(Function&& function) noexcept;

  const ContextInfo& info() const { return info_; }

  /// Has the device gone away, or been reset? Its objects are then gone too; once true it stays so. Asks the driver,
  /// where ContextInfo::has_robustness.
  bool lost() noexcept;
  /// For whoever finds out otherwise.
  void mark_lost() noexcept { lost_ = true; }

  /// Errors that GL's debug output has reported, as an Error; nothing unless GlOptions::debug. In the caller's own
  /// context (GlContext::current) its own debug output has them.
  virtual void throw_debug_errors() {}

 protected:
  using Task = void (*)(void*);
  Context() = default;
  virtual void call(Task task, void* argument) = 0;

  ContextInfo info_;
  bool lost_ = false;
};

template <class Function>
std::invoke_result_t<Function&> Context::run(Function&& function) {
  using Result = std::invoke_result_t<Function&>;
  static_assert(!std::is_reference_v<Result>, "what a function returns out of a context is a value");
  if constexpr (std::is_void_v<Result>) {
    auto task = [&] { function(); };
    call([](void* it) { (*static_cast<decltype(task)*>(it))(); }, &task);
  } else {
    std::optional<Result> result;
    auto task = [&] { result.emplace(function()); };
    call([](void* it) { (*static_cast<decltype(task)*>(it))(); }, &task);
    return std::move(*result);
  }
}

template <class Function>
void Context::discard(Function&& function) noexcept {
  if (lost_) return;
  try {
    run(std::forward<Function>(function));
  } catch (...) {  // the objects are out of reach; nothing is left to do
  }
}

}  // namespace phymul::gl
