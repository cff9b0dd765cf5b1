// SPDX-License-Identifier: MIT
#include "base_selection.h"

#include "corner_simplices.h"
#include "isotropic_fit.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace phymul {
namespace {

// Room for rounding, so that equal bases on equal neighbourhoods pass or fail together.
constexpr double threshold_slack = 1e-9;

bool passes(const RestBase& base, const TopologyOptions& options) {
  if (!has_plane(base)) return false;
  if (options.bases == BaseSelection::all) return true;
  if (base.quality < options.min_quality * (1 - threshold_slack)) return false;
  return std::ranges::all_of(base.lambda, [&options](double lambda) {
    return std::abs(lambda) <= options.max_barycentric * (1 + threshold_slack);
  });
}

// Lower bases than this share of the mean distance to the neighbours are left out of fitted sets.
constexpr double lowest_base = 0.2;

double mean_neighbour_distance(const Model& model, Index owner) {
  double sum = 0.0;
  for (const Index* j = model.neighbours.begin(owner); j != model.neighbours.end(owner); ++j) {
    sum += (model.rest[*j] - model.rest[owner]).norm();
  }
  return sum / std::max<Index>(model.neighbours.size(owner), 1);
}

// Centroid of the simplex that a base and its owner span, from the owner.
Vec3 sample_centre(const Model& model, Index owner, const RestBase& base) {
  Vec3 sum = Vec3::Zero();
  for (const Index v : base.vertex) {
    if (v >= 0) sum += model.rest[v] - model.rest[owner];
  }
  return sum / (base.vertex[2] < 0 ? 3.0 : 4.0);
}

void append_row(const std::vector<RestBase>& row, std::int64_t most_rows, BaseTable& table) {
  require_base_rows(table.base.size() + row.size(), most_rows);
  table.base.insert(table.base.end(), row.begin(), row.end());
  table.weight.insert(table.weight.end(), row.size(), row.empty() ? 0.0 : 1.0 / static_cast<double>(row.size()));
  table.offset.push_back(table.base.size());
}

void append_fitted_row(const std::vector<FittedBase>& row, std::int64_t most_rows, BaseTable& table) {
  require_base_rows(table.base.size() + row.size(), most_rows);
  double sum = 0.0;
  for (const FittedBase& it : row) sum += it.weight / (it.base.beta * it.base.beta);
  for (const FittedBase& it : row) {
    table.base.push_back(it.base);
    table.weight.push_back(it.weight / (it.base.beta * it.base.beta) / sum);
  }
  table.offset.push_back(table.base.size());
}

}  // namespace

std::vector<RestBase> neighbour_bases(const Model& model, Index owner, const TopologyOptions& options) {
  const Index* n = model.neighbours.begin(owner);
  const Index count = model.neighbours.size(owner);
  std::vector<RestBase> result;
  const auto keep = [&](const std::array<Index, 3>& vertex) {
    const RestBase base = rest_base(model.rest, owner, vertex);
    if (passes(base, options)) result.push_back(base);
  };
  for (Index j = 0; j < count; ++j) {
    for (Index k = j + 1; k < count; ++k) {
      if (model.dimension == 2) keep({n[j], n[k], -1});
      for (Index l = k + 1; l < count && model.dimension == 3; ++l) keep({n[j], n[k], n[l]});
    }
  }
  return result;
}

std::vector<std::vector<RestBase>> opposite_bases(const Model& model) {
  std::vector<std::vector<RestBase>> result(model.rest.size());
  for (const CornerSimplex& simplex : corner_simplices(model)) {
    for (const OppositeFace& face : opposite_faces(simplex)) {
      std::vector<RestBase>& row = result[face.owner];
      if (std::ranges::find(row, face.vertex, &RestBase::vertex) != row.end()) continue;
      row.push_back(rest_base(model.rest, face.owner, face.vertex));
    }
  }
  return result;
}

std::vector<FittedBase> fitted_bases(const Model& model, Index owner, const TopologyOptions& options) {
  std::vector<RestBase> candidates = neighbour_bases(model, owner, options);
  const double spacing = mean_neighbour_distance(model, owner);
  std::erase_if(candidates, [spacing](const RestBase& base) { return std::abs(base.beta) < lowest_base * spacing; });
  std::vector<Vec3> normals;
  VecList centres;
  for (const RestBase& base : candidates) {
    normals.push_back(base.normal);
    centres.push_back(sample_centre(model, owner, base) / spacing);
  }
  const Eigen::VectorXd weight = sparse_weights(normals, centres, model.dimension);
  std::vector<FittedBase> result;
  for (std::size_t t = 0; t < candidates.size(); ++t) {
    const double u = weight[static_cast<Eigen::Index>(t)];
    if (u > 0.0) result.push_back({candidates[t], u});
  }
  return result;
}

void require_base_rows(std::size_t rows, std::int64_t most) {
  if (static_cast<std::int64_t>(rows) <= most) return;
  throw Error("the table of bases needs more than " + std::to_string(most) +
              " rows, which is all that max_texture_size or 32-bit numbers allow. Use fewer neighbours or a sparser "
              "base selection");
}

BaseTable select_bases(const Model& model, const TopologyOptions& options, std::int64_t most_rows) {
  BaseTable table;
  table.stiffness = model.stiffness;
  std::vector<std::vector<RestBase>> opposite;
  if (options.bases == BaseSelection::opposite_faces) opposite = opposite_bases(model);
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (options.bases == BaseSelection::fitted) {
      append_fitted_row(fitted_bases(model, i, options), most_rows, table);
    } else {
      append_row(opposite.empty() ? neighbour_bases(model, i, options) : opposite[i], most_rows, table);
    }
  }
  return table;
}

}  // namespace phymul
