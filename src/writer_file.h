// SPDX-License-Identifier: MIT
#pragma once

#include <fstream>
#include <string>

namespace phymul {

/// A file being written beside its place, as `<path>.part`. It takes the place of an older one only when complete; a
/// writer that throws before leaves the older one as it was.
class WriterFile {
 public:
  explicit WriterFile(std::string path);  ///< throws Error when it cannot be made
  ~WriterFile();                          ///< removes an incomplete file
  WriterFile(const WriterFile&) = delete;
  WriterFile& operator=(const WriterFile&) = delete;

  std::ostream& out() { return out_; }
  void complete();  ///< throws Error when something was not written (the disk is full)

 private:
  std::string path_;
  std::string part_;
  std::ofstream out_;
  bool done_ = false;
};

}  // namespace phymul
