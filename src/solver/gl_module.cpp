// SPDX-License-Identifier: MIT
#include "gl_module.h"

#include <dlfcn.h>
#include <phymul/error.h>

#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <vector>

namespace phymul {
namespace {

namespace fs = std::filesystem;

constexpr const char* file_name = "libphymul_gl.so";

/// Folder of the shared library or program that this function is part of; empty where it cannot be told.
fs::path own_folder() {
  Dl_info info{};
  if (!dladdr(reinterpret_cast<void*>(&own_folder), &info) || !info.dli_fname) return {};
  std::error_code error;
  fs::path file = fs::canonical(info.dli_fname, error);
  // A program's name is what it was called by, which a changed working folder or a search path makes wrong.
  if (error) file = fs::canonical("/proc/self/exe", error);
  return error ? fs::path() : file.parent_path();
}

std::vector<fs::path> places() {
  if (const char* wish = std::getenv("PHYMUL_GL_MODULE"); wish && *wish) return {wish};
  std::vector<fs::path> all;
  if (const fs::path folder = own_folder(); !folder.empty()) {
    all.push_back(folder / "phymul" / file_name);
    all.push_back(folder / ".." / PHYMUL_LIBDIR_NAME / "phymul" / file_name);
  }
  all.push_back(file_name);
  all.push_back(fs::path(PHYMUL_LIBDIR) / "phymul" / file_name);
  return all;
}

void require_same_build(const GlModule& module, const fs::path& place) {
  const GlModuleStamp here;
  if (module.stamp == here) return;
  const bool same_version = std::string_view(module.stamp.version) == here.version;
  throw Error(ErrorCode::device,
              place.string() + " belongs to phymul " + module.stamp.version + ", this program to " + here.version +
                  (same_version ? ", and was built with other headers or flags" : "") +
                  "; install both from one build, or set PHYMUL_GL_MODULE to the full path of the right one");
}

const GlModule* entry_of(void* library, const fs::path& place) {
  const auto entry = reinterpret_cast<GlModuleEntry>(dlsym(library, gl_module_entry));
  if (!entry)
    throw Error(ErrorCode::device,
                place.string() + " is no GL module of phymul: it has no function " + gl_module_entry);
  const GlModule* module = entry();
  require_same_build(*module, place);
  return module;
}

const GlModule* find_module() {
  std::string failures;
  for (const fs::path& place : places()) {
    if (void* library = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL)) return entry_of(library, place);
    const char* reason = dlerror();
    failures += "\n  " + std::string(reason ? reason : place.c_str());
  }
  throw Error(
      ErrorCode::device,
      "the GL part of phymul could not be loaded. It needs the libraries GLEW, EGL and GL (Debian: libglew2.2 libegl1 "
      "libgl1), and PHYMUL_GL_MODULE may name its full path; tried:" +
          failures);
}

}  // namespace

const GlModule& load_gl_module() {
  static std::mutex mutex;
  static const GlModule* loaded = nullptr;
  const std::lock_guard lock(mutex);
  if (!loaded) loaded = find_module();
  return *loaded;
}

}  // namespace phymul
