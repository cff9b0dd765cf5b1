// SPDX-License-Identifier: MIT
#include "float_volumes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/enclosed_volume.h"

namespace phymul {
namespace {

/// A power of 2 m, which scales without rounding.
double unit_of(double volume) {
  return std::ldexp(1.0, static_cast<int>(std::lround(std::log2(volume) / 3.0)));
}

double mean_mass(const VolumeConstraint& kept, const std::vector<double>& mass) {
  double sum = 0.0;
  for (const auto& t : kept.triangles) {
    for (const Index i : t) sum += mass[static_cast<std::size_t>(i)];
  }
  return sum / static_cast<double>(3 * kept.triangles.size());
}

void add_volume(const VolumeConstraint& kept, const Model& model, FloatVolumes& tables) {
  const int volume = tables.count();
  const double unit = unit_of(kept.volume), cube = unit * unit * unit;
  const double at_rest = enclosed_volume(kept.triangles, model.rest);
  tables.laws.push_back({static_cast<float>(unit), static_cast<float>(1.0 / unit),
                         static_cast<float>(mean_mass(kept, model.mass) / 6.0), 0.0f});
  tables.laws.push_back({static_cast<float>((kept.volume - at_rest) / cube),
                         static_cast<float>(rounded_volume_share * kept.volume / cube), 0.0f, 0.0f});
  const Index o = kept.triangles.front()[0];
  const auto X = [&](Index i) -> const Vec3& { return model.rest[static_cast<std::size_t>(i)]; };
  for (const auto& [a, b, c] : kept.triangles) {
    tables.facets.push_back({a, b, c, o});
    tables.edges.push_back(float4((X(a) - X(o)) / unit));
    tables.edges.push_back(float4((X(b) - X(a)) / unit));
    tables.edges.push_back(float4((X(c) - X(a)) / unit));
    for (const Index i : {a, b, c}) tables.ranges[static_cast<std::size_t>(i)][2] = volume;
  }
}

/// What each particle gathers, in the order of the facets.
void fill_around(FloatVolumes& tables) {
  std::vector<std::int32_t> count(tables.ranges.size(), 0);
  for (const Int4& facet : tables.facets) {
    for (std::size_t k = 0; k < 3; ++k) ++count[static_cast<std::size_t>(facet[k])];
  }
  std::int32_t first = 0;
  for (std::size_t i = 0; i < count.size(); ++i) {
    tables.ranges[i][0] = tables.ranges[i][1] = first;
    first += count[i];
  }
  tables.around.resize(static_cast<std::size_t>(first));
  for (std::size_t row = 0; row < tables.facets.size(); ++row) {
    const auto [a, b, c, o] = tables.facets[row];
    for (const std::int32_t i : {a, b, c}) {
      const std::int32_t at = tables.ranges[static_cast<std::size_t>(i)][1]++;
      tables.around[static_cast<std::size_t>(at)] = {a, b, c, static_cast<std::int32_t>(row)};
    }
  }
}

/// `rows`: first and end facet of each volume.
void fill_sums(std::vector<Int2> rows, FloatVolumes& tables) {
  bool summed = false;
  while (!summed) {
    const auto start = static_cast<std::int32_t>(tables.nodes.size());
    summed = true;
    for (std::size_t volume = 0; volume < rows.size(); ++volume) {
      const auto [first, end] = rows[volume];
      rows[volume][0] = static_cast<std::int32_t>(tables.nodes.size());
      for (std::int32_t row = first; row < end; row += FloatVolumes::terms_a_sum) {
        tables.nodes.push_back(
            {row, std::min(row + FloatVolumes::terms_a_sum, end), static_cast<std::int32_t>(volume), 0});
      }
      rows[volume][1] = static_cast<std::int32_t>(tables.nodes.size());
      summed = summed && rows[volume][1] - rows[volume][0] == 1;
    }
    tables.levels.push_back({start, static_cast<std::int32_t>(tables.nodes.size()), 0, 0});
  }
}

}  // namespace

FloatVolumes pack_volumes(const Scene& scene) {
  FloatVolumes tables;
  if (scene.volume_constraints().empty()) return tables;
  tables.ranges.assign(scene.model().rest.size(), {0, 0, -1, 0});
  std::vector<Int2> rows;
  for (const VolumeConstraint& kept : scene.volume_constraints()) {
    const auto first = static_cast<std::int32_t>(tables.facets.size());
    add_volume(kept, scene.model(), tables);
    rows.push_back({first, static_cast<std::int32_t>(tables.facets.size())});
  }
  fill_around(tables);
  fill_sums(std::move(rows), tables);
  return tables;
}

}  // namespace phymul
