// SPDX-License-Identifier: MIT
//
// Errors of GL's debug output.
#pragma once

#include <mutex>
#include <string>

namespace phymul::gl {

struct ContextInfo;

class DebugLog {
 public:
  DebugLog() = default;
  DebugLog(const DebugLog&) = delete;  // GL holds its address
  DebugLog& operator=(const DebugLog&) = delete;

  /// From now on the current context's errors come here, at the call that makes them. Nothing where the context has no
  /// debug output.
  void listen(const ContextInfo& info);

  void add(const std::string& message);
  /// Throws Error with the messages since the last call, if there were any.
  void throw_errors();

 private:
  std::mutex mutex_;  // a driver may report from a thread of its own
  std::string messages_;
  int count_ = 0;
};

}  // namespace phymul::gl
