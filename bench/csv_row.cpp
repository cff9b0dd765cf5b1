// SPDX-License-Identifier: MIT
#include "csv_row.h"

#include <phymul/error.h>
#include <phymul/version.h>

#include <cmath>
#include <thread>

#include "machine.h"

namespace phymul::bench {
CsvFile::CsvFile(const std::string& path, const std::vector<std::string>& columns)
    : file_(std::fopen(path.c_str(), "w")), columns_(columns.size()) {
  if (!file_) throw Error(path + ": expected a place to write to");
  std::fprintf(file_, "# machine: %s, %u threads\n", processor().c_str(), std::thread::hardware_concurrency());
  std::fprintf(file_, "# compiler: %s\n# flags: %s\n# phymul: %s\n# date: %s\n", PHYMUL_BENCH_COMPILER,
               PHYMUL_BENCH_FLAGS, PHYMUL_VERSION, today().c_str());
  row(columns);
}

CsvFile::~CsvFile() {
  std::fclose(file_);
}

void CsvFile::row(const std::vector<std::string>& fields) {
  if (fields.size() != columns_) throw Error("CsvFile: a row has another number of fields than there are columns");
  for (std::size_t k = 0; k < fields.size(); ++k) {
    std::string text = fields[k];
    if (text.find_first_of(",\"\n") != std::string::npos) {
      std::string quoted = "\"";
      for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
      text = quoted + "\"";
    }
    std::fprintf(file_, "%s%s", k ? "," : "", text.c_str());
  }
  std::fprintf(file_, "\n");
  if (std::fflush(file_) != 0 || std::ferror(file_) != 0) {
    throw Error(ErrorCode::file_access, "the CSV file cannot be written to its end; is the disk full?");
  }
}

std::string field(double value) {
  if (!std::isfinite(value)) return "";
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace phymul::bench
