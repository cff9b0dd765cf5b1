// SPDX-License-Identifier: MIT
#include "writer_file.h"

#include <phymul/error.h>

#include <filesystem>

namespace phymul {

WriterFile::WriterFile(std::string path)
    : path_(std::move(path)), part_(path_ + ".part"), out_(part_, std::ios::binary | std::ios::trunc) {
  if (!out_) {
    done_ = true;
    throw Error(path_ + ": cannot be written; check that its folder exists and may be written to");
  }
}

WriterFile::~WriterFile() {
  if (done_) return;
  out_.close();
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

void WriterFile::complete() {
  out_.close();
  if (!out_) throw Error(path_ + ": could not be written to its end; check the space left on the disk");
  std::error_code problem;
  std::filesystem::rename(part_, path_, problem);
  if (problem) throw Error(path_ + ": cannot be replaced: " + problem.message());
  done_ = true;
}

}  // namespace phymul
