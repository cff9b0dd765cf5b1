// SPDX-License-Identifier: MIT
//
// Of files: errors about them, their endings, and how one takes the place of another.
#pragma once

#include <phymul/error.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>

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

/// Of the letters A to Z, whatever the locale.
inline std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

/// With its dot, in lower case: ".stl".
inline std::string file_ending(const std::string& path) {
  return lower_case(std::filesystem::path(path).extension().string());
}

/// Calls `write` with a stream to a new file beside `path`, which takes the place of `path` only when complete (of
/// the file it names, where `path` is a link). A pipe or device is written to directly. Throws Error, and leaves no new
/// file, when anything fails.
void replace_file(const std::string& path, const std::function<void(std::ostream&)>& write);

}  // namespace phymul
