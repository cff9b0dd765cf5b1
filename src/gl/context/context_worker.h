// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "context.h"
#include "egl_context.h"

namespace phymul::gl {

/// GlContext::worker: a context that stays current on a thread of its own, which does what it is told, one task at a
/// time.
class WorkerContext : public Context {
 public:
  WorkerContext(const GlOptions& options, GlBackend backend);
  ~WorkerContext() override;
  void throw_debug_errors() override { egl_->debug_log().throw_errors(); }

 private:
  void call(Task task, void* argument) override;
  void serve(const GlOptions& options, GlBackend backend);  ///< the thread
  void open(const GlOptions& options, GlBackend backend);
  void finish(std::exception_ptr failure);

  std::unique_ptr<EglContext> egl_;  // made and ended on the thread
  std::mutex callers_;               // one at a time
  std::mutex mutex_;                 // of what follows
  std::condition_variable changed_;
  Task task_ = nullptr;
  void* argument_ = nullptr;
  bool done_ = false, stop_ = false;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace phymul::gl
