// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

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
  static std::filesystem::path own_folder() {
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    return std::filesystem::temp_directory_path() /
           (std::string("phymul_") + test->test_suite_name() + '_' + test->name());
  }

  std::filesystem::path before_, folder_;
};
