// SPDX-License-Identifier: MIT
//
// Error: the one exception type of the library. Building (reading files, making models, scenes and solvers) throws it.
// Stepping does not throw: it returns a StepReport. Programming errors inside the library assert in debug builds.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

namespace phymul {

enum class ErrorCode {
  invalid_argument,  ///< an argument or option has a value that is not allowed
  unknown_name,      ///< no group, tool, component or backend has this name
  file_access,       ///< a file cannot be opened, read or written
  file_format,       ///< the content of a file is not what its format requires
  invalid_model,     ///< a model or its elements are inconsistent or degenerate
  not_supported,     ///< this build, backend or file format does not support what was asked for
  device,            ///< a driver, a GPU or the GL module failed
  out_of_memory      ///< a device or a limit on memory has no room
};

/// what() is one message for people: what went wrong, what was expected, what was found and what to do. For files it
/// begins with "file:line: " or "file: byte n: ".
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& text) : Error(ErrorCode::invalid_argument, text) {}
  Error(ErrorCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
  /// `file` and `line` are not added to the text. Lines count from 1; 0: the file has no lines or none is meant.
  Error(ErrorCode code, const std::string& text, const std::string& file, int line = 0)
      : std::runtime_error(text), code_(code), file_(std::make_shared<const std::string>(file)), line_(line) {}

  ErrorCode code() const noexcept { return code_; }
  /// The file that was read or written; empty if there is none.
  std::string file() const { return file_ ? *file_ : std::string(); }
  int line() const noexcept { return line_; }  ///< 1 for the first line; 0: unknown

 private:
  ErrorCode code_;
  std::shared_ptr<const std::string> file_;  // copies of an exception must not throw
  int line_ = 0;
};

}  // namespace phymul
