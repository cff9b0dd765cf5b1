// SPDX-License-Identifier: MIT
#include "context_worker.h"

#include <utility>

namespace phymul::gl {

WorkerContext::WorkerContext(const GlOptions& options, GlBackend backend)
    : thread_([this, options, backend] { serve(options, backend); }) {
  std::exception_ptr failure;
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return done_; });
    failure = std::exchange(failure_, nullptr);
  }
  if (!failure) return;
  thread_.join();
  std::rethrow_exception(failure);
}

WorkerContext::~WorkerContext() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void WorkerContext::call(Task task, void* argument) {
  if (std::this_thread::get_id() == thread_.get_id()) return task(argument);
  const std::lock_guard one_caller(callers_);
  std::unique_lock lock(mutex_);
  task_ = task;
  argument_ = argument;
  done_ = false;
  changed_.notify_all();
  changed_.wait(lock, [this] { return done_; });
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void WorkerContext::open(const GlOptions& options, GlBackend backend) {
  GlOptions own = options;
  own.context = GlContext::own;
  egl_ = EglContext::open(own, backend);
  egl_->make_current();
  info_ = egl_->info();
}

void WorkerContext::finish(std::exception_ptr failure) {
  {
    const std::lock_guard lock(mutex_);
    failure_ = std::move(failure);
    task_ = nullptr;
    done_ = true;
  }
  changed_.notify_all();
}

void WorkerContext::serve(const GlOptions& options, GlBackend backend) {
  try {
    open(options, backend);
  } catch (...) {
    egl_.reset();
    eglReleaseThread();
    return finish(std::current_exception());
  }
  finish(nullptr);
  for (;;) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return task_ || stop_; });
    if (stop_) break;
    const auto [task, argument] = std::pair(task_, argument_);
    lock.unlock();
    try {
      task(argument);
      finish(nullptr);
    } catch (...) {
      finish(std::current_exception());
    }
  }
  egl_.reset();
  eglReleaseThread();
}

}  // namespace phymul::gl
