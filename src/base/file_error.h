// SPDX-License-Identifier: MIT
//
// Errors about files, and errors that get a file or a prefix on their way up.
#pragma once

#include <phymul/error.h>

#include <cstddef>
#include <string>

namespace phymul {

/// "file:line: problem"; "file: problem" if `line` is 0.
[[noreturn]] void fail_format(const std::string& file, std::size_t line, const std::string& problem);
[[noreturn]] void fail_access(const std::string& file, const std::string& problem);
[[noreturn]] void fail_memory(const std::string& file);  ///< for a file that does not fit in memory

/// The same error behind a prefix. Code, file and line stay.
Error with_prefix(const std::string& prefix, const Error& error);
/// The same error as one about this file, unless it names one already. A value that is not allowed is then one of the
/// file's content.
Error in_file(const std::string& file, const Error& error);

/// Result of read(), whose errors are about this file.
template <class Read>
auto reading(const std::string& file, Read read) {
  try {
    return read();
  } catch (const Error& error) {
    throw in_file(file, error);
  }
}

}  // namespace phymul
