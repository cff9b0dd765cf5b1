// SPDX-License-Identifier: MIT
#include "files.h"

#include <phymul/error.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>

namespace phymul {
namespace {

namespace fs = std::filesystem;

void close(std::ofstream& out) {
  out.close();
  if (!out) throw Error(ErrorCode::file_access, "cannot be written to its end; is the disk full?");
}

std::ofstream opened(const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  if (!out)
    throw Error(ErrorCode::file_access, "cannot be written; check that its folder exists and may be written to");
  return out;
}

/// A pipe or a device is written to: what took its place would be a plain file.
bool is_special(const std::string& path) {
  std::error_code problem;
  const fs::file_status status = fs::status(path, problem);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// A link stays one: the file that it names is replaced.
std::string behind_link(const std::string& path) {
  std::error_code problem;
  if (!fs::is_symlink(path, problem)) return path;
  const fs::path file = fs::canonical(path, problem);
  return problem ? path : file.string();
}

void replace_plain_file(const std::string& path, const std::function<void(std::ostream&)>& write) {
  // In the same folder, for a rename across file systems is none; a name of its own for each writer.
  static std::atomic<unsigned> serial{0};
  const auto ticks = std::chrono::steady_clock::now().time_since_epoch().count();
  const std::string draft = path + ".part" + std::to_string(ticks) + '-' + std::to_string(serial++);
  std::error_code problem;
  try {
    std::ofstream out = opened(draft);
    write(out);
    close(out);
    fs::rename(draft, path, problem);
    if (problem) throw Error(ErrorCode::file_access, "cannot be replaced (" + problem.message() + ')');
  } catch (...) {
    fs::remove(draft, problem);
    throw;
  }
}

}  // namespace

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

void replace_file(const std::string& path, const std::function<void(std::ostream&)>& write) {
  try {
    if (!is_special(path)) {
      replace_plain_file(behind_link(path), write);
      return;
    }
    std::ofstream out = opened(path);
    write(out);
    close(out);
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what(), path);
  }
}

}  // namespace phymul
