// SPDX-License-Identifier: MIT
#include "profile.h"

#include <algorithm>
#include <limits>

namespace phymul {

int Profile::row(std::string_view name) {
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    if (rows_[k].sums.name == name) return static_cast<int>(k);
  }
  Row row;
  row.sums.name = name;
  rows_.push_back(std::move(row));
  return static_cast<int>(rows_.size()) - 1;
}

void Profile::add(int row, double seconds, int runs) {
  Row& of = rows_[static_cast<std::size_t>(row)];
  if (of.first_run == 0) of.first_run = ++order_;
  of.sums.runs += runs;
  of.sums.seconds += seconds;
}

void Profile::add_device(int row, double seconds) {
  Row& of = rows_[static_cast<std::size_t>(row)];
  if (!of.device) of.sums.device_seconds = 0.0;
  of.device = true;
  of.sums.device_seconds += seconds;
}

void Profile::lose_device(int row) {
  rows_[static_cast<std::size_t>(row)].disturbed = true;
}

std::vector<PassProfile> Profile::rows() const {
  std::vector<Row> ran;
  for (const Row& row : rows_) {
    if (row.sums.runs > 0) ran.push_back(row);
  }
  std::ranges::sort(ran, {}, &Row::first_run);
  std::vector<PassProfile> passes;
  for (Row& row : ran) {
    if (row.disturbed) row.sums.device_seconds = std::numeric_limits<double>::quiet_NaN();
    passes.push_back(std::move(row.sums));
  }
  return passes;
}

void Profile::clear() {
  for (Row& row : rows_) {
    std::string name = std::move(row.sums.name);
    row = Row{};
    row.sums.name = std::move(name);
  }
  order_ = 0;
}

std::vector<PassProfile> SolverBackend::profile() const {
  if (!profile_) return {};
  do_profile();
  return profile_->rows();
}

void SolverBackend::clear_profile() {
  if (!profile_) return;
  do_profile();
  profile_->clear();
}

}  // namespace phymul
