// SPDX-License-Identifier: MIT
#include "measurement.h"

#include <phymul/error.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "run_options.h"

namespace {

constexpr const char* all_columns = "x,y,z,ux,uy,uz";
constexpr const char* places_alone = "x,y,z";

void strip_end(std::string& line) {
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
}

std::vector<double> numbers_of(const std::string& path, int row, const std::string& line, std::size_t wanted) {
  std::vector<double> numbers;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) {
    const std::size_t begin = std::min(field.find_first_not_of(" \t"), field.size());
    double value = 0.0;
    const auto [end, problem] = std::from_chars(field.data() + begin, field.data() + field.size(), value);
    if (problem != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) {
      fail_at(path, row, "expected a number, got \"" + field + '"');
    }
    numbers.push_back(value);
  }
  if (numbers.size() != wanted) {
    fail_at(path, row, "expected " + std::to_string(wanted) + " numbers, got " + std::to_string(numbers.size()));
  }
  return numbers;
}

}  // namespace

Measurement read_measurement(const std::string& path, bool with_displacements) {
  std::ifstream in(path);
  if (!in || std::filesystem::is_directory(path)) {
    throw phymul::Error(phymul::ErrorCode::file_access, path + ": expected a file of measured displacements", path);
  }
  Measurement result;
  int row = 0;
  std::size_t wanted = 0;
  for (std::string line; std::getline(in, line);) {
    ++row;
    strip_end(line);
    if (line.empty() || line[0] == '#') continue;
    if (wanted == 0) {
      if (line != all_columns && (with_displacements || line != places_alone)) {
        fail_at(path, row, std::string("expected the columns ") + all_columns + ", got " + line);
      }
      wanted = line == all_columns ? 6 : 3;
      continue;
    }
    const std::vector<double> v = numbers_of(path, row, line, wanted);
    result.point.emplace_back(v[0], v[1], v[2]);
    if (with_displacements) result.displacement.emplace_back(v[3], v[4], v[5]);
  }
  if (result.point.empty()) fail_at(path, row, "expected at least one point");
  return result;
}

void write_measurement(const std::string& path, const Measurement& measurement) {
  std::ofstream out(path);
  out << all_columns << '\n';
  for (std::size_t k = 0; k < measurement.point.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) out << shortest_decimal(measurement.point[k][axis]) << ',';
    for (int axis = 0; axis < 3; ++axis) {
      out << shortest_decimal(measurement.displacement[k][axis]) << (axis < 2 ? "," : "\n");
    }
  }
  out.close();
  if (!out) throw phymul::Error(phymul::ErrorCode::file_access, path + ": this file cannot be written", path);
}
