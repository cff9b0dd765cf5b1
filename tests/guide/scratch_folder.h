// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "support/text_file.h"

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
