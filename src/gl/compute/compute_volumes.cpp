// SPDX-License-Identifier: MIT
#include "compute_volumes.h"

#include <algorithm>
#include <utility>

namespace phymul::gl {
namespace {

constexpr int sums_a_lane = 4;                 // of facets, before they are worth a dispatch of many groups
constexpr std::int64_t turns_of_a_root = 128;  // volume_root.glsl

std::int64_t size_of(const auto& rows) {
  return static_cast<std::int64_t>(rows.size());
}

}  // namespace

ComputeVolumes::ComputeVolumes(const FloatVolumes& volumes, std::int64_t first, const ComputeTables& tables)
    : tables_(&tables),
      count_(volumes.count()),
      levels_(static_cast<int>(volumes.levels.size())),
      sums_(static_cast<int>(volumes.nodes.size())),
      facet_sums_(volumes.levels.front()[1]),
      most_around_(volumes.most_around),
      end_(first) {
  const auto take = [this](std::int64_t rows) {
    const std::int64_t row = end_;
    end_ += rows;
    return row;
  };
  laws_row_ = take(size_of(volumes.laws));
  ranges_row_ = take(tables.places());
  around_row_ = take(size_of(volumes.around));
  facets_row_ = take(size_of(volumes.facets));
  edges_row_ = take(size_of(volumes.edges));
  nodes_row_ = take(size_of(volumes.nodes));
  levels_row_ = take(size_of(volumes.levels));
  along_row_ = take(tables.places());
  sums_row_ = take(size_of(volumes.nodes));
  roots_row_ = take(count_);
}

/// With places for the first numbers of each row.
std::vector<Int4> ComputeVolumes::placed(std::vector<Int4> rows, std::size_t corners) const {
  for (Int4& row : rows) {
    for (std::size_t k = 0; k < corners; ++k) row[k] = tables_->place_of()[static_cast<std::size_t>(row[k])];
  }
  return rows;
}

void ComputeVolumes::write(const FloatVolumes& volumes, StorageBuffer& rows) const {
  const auto send = [&rows](std::int64_t first, const auto& table) {
    rows.write(16 * first, table.data(), 16 * size_of(table));
  };
  std::vector<Int4> ranges(static_cast<std::size_t>(tables_->places()), Int4{0, 0, -1, 0});
  for (std::size_t i = 0; i < volumes.ranges.size(); ++i) {
    ranges[static_cast<std::size_t>(tables_->place_of()[i])] = volumes.ranges[i];
  }
  send(laws_row_, volumes.laws);
  send(ranges_row_, ranges);
  send(around_row_, placed(volumes.around, 3));
  send(facets_row_, placed(volumes.facets, 4));
  send(edges_row_, volumes.edges);
  send(nodes_row_, volumes.nodes);
  send(levels_row_, volumes.levels);
  send(roots_row_, std::vector<Float4>(static_cast<std::size_t>(count_), Float4{}));
}

void ComputeVolumes::place(Kernel& kernel) const {
  const auto set = [&](const char* name, std::int64_t value) { kernel.set(name, static_cast<int>(value)); };
  set("kept_laws_place", laws_row_);
  set("kept_ranges_place", ranges_row_);
  set("kept_around_place", around_row_);
  set("kept_facets_place", facets_row_);
  set("kept_edges_place", edges_row_);
  set("kept_nodes_place", nodes_row_);
  set("kept_levels_place", levels_row_);
  set("kept_along_place", along_row_);
  set("kept_sums_place", sums_row_);
  set("kept_roots_place", roots_row_);
  set("kept_count", count_);
  set("kept_level_count", levels_);
  set("kept_first_total", sums_ - count_);
}

std::int64_t ComputeVolumes::turns(int group) const {
  const auto rounds = [group](std::int64_t rows) { return (rows + group - 1) / group; };
  const std::int64_t particles = rounds(tables_->kind().particles);
  const std::int64_t sums = (FloatVolumes::terms_a_sum + 1) * (rounds(sums_) + levels_);
  return particles * (1 + most_around_) + sums + rounds(count_) * turns_of_a_root;
}

void KeepingKernels::place(const ComputeVolumes& volumes) {
  volumes.place(sums_);
  volumes.place(step_);
  facet_sums_ = volumes.facet_sums();
}

void KeepingKernels::run(const ComputeState& state, int number, int particles) {
  sums_.set("next_pair", state.free_pair());
  sums_.set("number", number);
  const bool apart = facet_sums_ > sums_a_lane * sums_.group();
  if (apart) {
    sums_.set("first_level", -1);
    sums_.dispatch(sums_.groups_for(facet_sums_));
  }
  sums_.set("first_level", apart ? 1 : 0);
  sums_.dispatch(1);
  step_.set("pair", state.current());
  step_.set("next_pair", state.free_pair());
  step_.set("number", number);
  step_.dispatch(step_.groups_for(particles));
}

const ShaderFiles& keeping_step_files() {
  static const ShaderFiles files{"volume/kept_tables.glsl", "volume/kept_facet.glsl", "volume/kept_along_pass.glsl"};
  return files;
}

const ShaderFiles& keeping_sums_files() {
  static const ShaderFiles files{"volume/kept_tables.glsl",    "volume/kept_facet.glsl",
                                 "volume/kept_sums_pass.glsl", "volume/volume_root.glsl",
                                 "volume/kept_root_pass.glsl", "dialect/wait_for_all.glsl",
                                 "volume/store_kept_sums.glsl"};
  return files;
}

const ShaderFiles& keeping_end_files() {
  static const ShaderFiles files{"volume/kept_step_pass.glsl", "volume/store_kept_step.glsl"};
  return files;
}

}  // namespace phymul::gl
