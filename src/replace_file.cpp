// SPDX-License-Identifier: MIT
#include "replace_file.h"

#include <phymul/error.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>

namespace phymul {

void replace_file(const std::string& path, const std::function<void(std::ostream&)>& write) {
  namespace fs = std::filesystem;
  // In the same folder, for a rename across file systems is none; a name of its own for each writer.
  static std::atomic<unsigned> serial{0};
  const auto ticks = std::chrono::steady_clock::now().time_since_epoch().count();
  const std::string draft = path + ".part" + std::to_string(ticks) + '-' + std::to_string(serial++);
  std::error_code problem;
  try {
    std::ofstream out(draft, std::ios::binary);
    if (!out) throw Error("cannot be written; check that its folder exists and may be written to");
    write(out);
    out.close();
    if (!out) throw Error("cannot be written to its end; is the disk full?");
    fs::rename(draft, path, problem);
    if (problem) throw Error("cannot be replaced (" + problem.message() + ')');
  } catch (const Error& error) {
    fs::remove(draft, problem);
    throw Error(path + ": " + error.what());
  } catch (...) {
    fs::remove(draft, problem);
    throw;
  }
}

}  // namespace phymul
