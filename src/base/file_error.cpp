// SPDX-License-Identifier: MIT
#include "file_error.h"

namespace phymul {

void fail_format(const std::string& file, std::size_t line, const std::string& problem) {
  throw Error(ErrorCode::file_format, file + (line > 0 ? ':' + std::to_string(line) : "") + ": " + problem, file,
              static_cast<int>(line));
}

void fail_access(const std::string& file, const std::string& problem) {
  throw Error(ErrorCode::file_access, file + ": " + problem, file);
}

void fail_memory(const std::string& file) {
  throw Error(ErrorCode::out_of_memory, file + ": not enough memory to read it", file);
}

Error with_prefix(const std::string& prefix, const Error& error) {
  return {error.code(), prefix + error.what(), error.file(), error.line()};
}

Error in_file(const std::string& file, const Error& error) {
  if (!error.file().empty()) return error;
  const bool general = error.code() == ErrorCode::invalid_argument || error.code() == ErrorCode::unknown_name;
  return {general ? ErrorCode::file_format : error.code(), error.what(), file, error.line()};
}

}  // namespace phymul
