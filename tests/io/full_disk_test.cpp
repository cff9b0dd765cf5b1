// SPDX-License-Identifier: MIT
//
// Every writer on a disk that is full, on a device that takes nothing and in a folder that there is not: an Error names
// the file, the file that was there before stays whole, and no draft is left beside it.
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <functional>

#include "support/message_of.h"
#include "support/text_file.h"

namespace phymul {
namespace {

namespace fs = std::filesystem;

/// While it lives, no file of this process grows beyond `bytes`. To a writer that is a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    EXPECT_EQ(getrlimit(RLIMIT_FSIZE, &before_), 0);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);  // write() then fails, as on a disk
    const rlimit now{bytes, before_.rlim_max};
    EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &now), 0);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

Model large_body() {
  Model model = make_block({0.1, 0.1, 0.1}, 8, 8, 8);  // more than 4096 bytes in every format
  set_material(model, {.young = 1e4, .poisson = 0.3, .density = 1000});
  return model;
}

struct Writer {
  const char* name;
  std::function<void(const std::string& path)> write;
};

std::vector<Writer> writers(const Model& model) {
  return {
      {"vtu", [&](const std::string& path) { write_vtu(model, rest_state(model), path); }},
      {"csv", [&](const std::string& path) { write_csv(model, rest_state(model), path); }},
      {"pml", [&](const std::string& path) { write_pml(model, path); }},
      {"lml",
       [&](const std::string& path) {
         Load load{.type = LoadType::force, .direction = Vec3(0, 0, 1)};
         for (Index i = 0; i < 200; ++i) load.particles.push_back(i);
         for (int k = 0; k < 200; ++k) load.events.push_back({0.1 * k, 1.0 / (k + 1)});
         write_lml({load}, model, path);
       }},
      {"state",
       [&](const std::string& path) {
         const Scene scene(model);
         save_state(*make_solver("reference", model, scene), path);
       }},
      {"recording",
       [&](const std::string& path) {
         Scene scene(model);
         const auto solver = make_solver("reference", model, scene);
         save_recording(Recorder(*solver, scene).recording(), path);
       }},
  };
}

std::ptrdiff_t files_beside(const std::string& path) {
  const fs::directory_iterator files(fs::path(path).parent_path());
  return std::distance(begin(files), end(files));
}

ErrorCode code_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode::device;  // none of the writers': there was no Error
}

TEST(FullDisk, KeepsTheOldFileWhole) {
  const Model model = large_body();
  for (const Writer& writer : writers(model)) {
    SCOPED_TRACE(writer.name);
    const TextFile file(std::string("body.") + writer.name, "as it was");
    for (const rlim_t room : {0, 1, 4096}) {
      std::string message;
      ErrorCode code{};
      {
        const FullDisk disk(room);
        message = message_of([&] { writer.write(file.path()); });
        code = code_of([&] { writer.write(file.path()); });
      }
      EXPECT_TRUE(message.starts_with(file.path() + ": ")) << message;
      EXPECT_TRUE(says(message, "is the disk full?"));
      EXPECT_EQ(code, ErrorCode::file_access);
      EXPECT_EQ(text_of(file.path()), "as it was");
      EXPECT_EQ(files_beside(file.path()), 1) << "no draft stays";
    }
    writer.write(file.path());  // there is room again
    EXPECT_GT(fs::file_size(file.path()), 4096u) << "or the disk was never full";
  }
}

TEST(FullDisk, DevicesAndMissingFoldersAreNamed) {
  const Model model = large_body();
  for (const Writer& writer : writers(model)) {
    SCOPED_TRACE(writer.name);
    const TextFile file("there", "");
    const std::string nowhere = (fs::path(file.path()).parent_path() / "none" / "file").string();
    EXPECT_TRUE(refuses([&] { writer.write(nowhere); }, nowhere + ": cannot be written; check that its folder exists"));
    // Through a link of our own: where this fails, it is not the machine's device that is lost.
    const std::string device = file.path() + ".device";
    fs::create_symlink("/dev/full", device);
    if (!fs::is_character_file(device)) continue;
    EXPECT_TRUE(refuses([&] { writer.write(device); }, device + ": "));
    EXPECT_EQ(code_of([&] { writer.write(device); }), ErrorCode::file_access);
    EXPECT_TRUE(fs::is_symlink(device));
  }
}

/// A frame that could not be written whole is written again under the same number.
TEST(FullDisk, ASeriesGoesOnWhereItWas) {
  const Model model = large_body();
  const TextFile file("series.pvd", "");
  const std::string stem = (fs::path(file.path()).parent_path() / "series").string();
  VtkSeries series(stem);
  State state = rest_state(model);
  series.write(model, state);
  const std::string before = text_of(stem + ".pvd");
  state.time = 1.0;
  {
    const FullDisk disk(4096);
    EXPECT_THROW(series.write(model, state), Error);
  }
  // The frame fits, the list of frames does not.
  fs::remove(stem + ".pvd");
  fs::create_directory(stem + ".pvd");
  EXPECT_THROW(series.write(model, state), Error);
  EXPECT_EQ(series.frames(), 1u);
  fs::remove(stem + ".pvd");
  series.write(model, state);
  EXPECT_EQ(series.frames(), 2u);
  const std::string after = text_of(stem + ".pvd");
  EXPECT_TRUE(says(after, "series_000001.vtu"));
  EXPECT_FALSE(says(after, "series_000002.vtu"));
}

}  // namespace
}  // namespace phymul
