// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

/// The bytes of a file.
inline std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  EXPECT_TRUE(in.is_open()) << path;
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A folder that no other test has: tests run at the same time.
inline std::filesystem::path own_folder() {
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string("phymul_") + test->test_suite_name() + '_' + test->name();
  for (char& c : name) c = c == '/' ? '_' : c;
  return std::filesystem::temp_directory_path() / name;
}

/// A file in own_folder() (`name` may have folders), removed with the object.
class TextFile {
 public:
  TextFile(const std::string& name, const std::string& bytes) : folder_(own_folder()) {
    path_ = (folder_ / name).string();
    std::filesystem::create_directories(std::filesystem::path(path_).parent_path());
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  ~TextFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::filesystem::path folder_;
  std::string path_;
};

/// An empty folder, in which the test works while this lives: the guide's code names files without a folder.
class ScratchFolder {
 public:
  ScratchFolder() : before_(std::filesystem::current_path()), folder_(own_folder()) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    std::filesystem::current_path(folder_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::current_path(before_, ignored);
    std::filesystem::remove_all(folder_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

 private:
  std::filesystem::path before_, folder_;
};
