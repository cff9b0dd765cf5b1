// SPDX-License-Identifier: MIT
//
// A CSV file that is written row by row, so that a run that is cut short leaves what it found.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace phymul::bench {

class CsvFile {
 public:
  /// Throws Error where the file cannot be written. Begins with comment lines ("# key: value") of where it was made.
  CsvFile(const std::string& path, const std::vector<std::string>& columns);
  ~CsvFile();
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  void row(const std::vector<std::string>& fields);  ///< as many as columns; quoted where needed; flushed

 private:
  std::FILE* file_;
  std::size_t columns_;
};

std::string field(double value);  ///< empty where it is not finite

}  // namespace phymul::bench
