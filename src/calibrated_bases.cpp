// SPDX-License-Identifier: MIT
#include "calibrated_bases.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "corner_simplices.h"
#include "isotropic_fit.h"

namespace phymul {
namespace {

// A corner's own view and its three edge neighbours' views. On a cube these weights make the fourth moment isotropic:
// four diagonals at 0.15, three axes at 2/15.
constexpr double corner_view = 0.6;

struct StiffBase {
  Index owner;
  RestBase base;
  double stiffness;  // k_t, N/m
};

// k_t of all views of one cell.
void add_cell_views(const Model& model, Index cell, double c, std::vector<StiffBase>& bases) {
  const std::vector<CornerSimplex> corners = corner_simplices(model, cell);
  const bool is_tetrahedron = model.cells[cell].type == CellType::tetrahedron;
  std::vector<StiffBase> views;
  std::vector<Vec3> normals;
  std::vector<double> priors;
  double volume = 0.0;
  for (const CornerSimplex& corner : corners) {
    volume += corner.share;
    for (const OppositeFace& face : opposite_faces(corner)) {
      views.push_back({face.owner, rest_base(model.rest, face.owner, face.vertex), 0.0});
      normals.push_back(views.back().base.normal);
      const double from_corner = face.owner == corner.vertex[0] ? corner_view : (1.0 - corner_view) / 3.0;
      priors.push_back(corner.share * (is_tetrahedron ? 0.25 : from_corner));
    }
  }
  const Eigen::VectorXd prior = Eigen::Map<const Eigen::VectorXd>(priors.data(), std::ssize(priors)) / volume;
  const Eigen::VectorXd weight = view_weights(normals, prior);
  for (std::size_t k = 0; k < views.size(); ++k) {
    const double v = weight[static_cast<Eigen::Index>(k)];
    if (!(v > 0.0)) continue;
    views[k].stiffness = c * volume * v / (views[k].base.beta * views[k].base.beta);
    bases.push_back(views[k]);
  }
}

std::vector<StiffBase> cell_views(const Model& model, const std::vector<Calibration>& calibration, double share) {
  std::vector<StiffBase> bases;
  for (Index cell = 0; cell < static_cast<Index>(model.cells.size()); ++cell) {
    const Cell& it = model.cells[cell];
    if (is_volume(it.type)) add_cell_views(model, cell, share * calibration[it.material].c, bases);
  }
  return bases;
}

// c V_i of every particle: each cell's evenly over its vertices, J.
std::vector<double> shape_energy_shares(const Model& model, const std::vector<Calibration>& calibration) {
  std::vector<double> shares(model.rest.size(), 0.0);
  for (const Cell& cell : model.cells) {
    if (!is_volume(cell.type)) continue;
    const double part =
        calibration[cell.material].c * cell_volume(model, cell) / static_cast<double>(cell.particles.size());
    for (const Index i : cell.particles) shares[i] += part;
  }
  return shares;
}

std::vector<StiffBase> fitted_views(const Model& model, const TopologyOptions& options,
                                    const std::vector<Calibration>& calibration, double share) {
  const std::vector<double> energy = shape_energy_shares(model, calibration);
  std::vector<StiffBase> bases;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (!(energy[i] > 0.0)) continue;
    for (const FittedBase& fitted : fitted_bases(model, i, options)) {
      const double beta = fitted.base.beta;
      bases.push_back({i, fitted.base, share * energy[i] * fitted.weight / (beta * beta)});
    }
  }
  return bases;
}

// Sorted by owner and vertices; the same base from several cells becomes one, with the sum of their stiffness.
void merge(std::vector<StiffBase>& bases) {
  std::ranges::stable_sort(bases, [](const StiffBase& a, const StiffBase& b) {
    return a.owner != b.owner ? a.owner < b.owner : a.base.vertex < b.base.vertex;
  });
  std::size_t last = 0;
  for (std::size_t k = 1; k < bases.size(); ++k) {
    if (bases[k].owner == bases[last].owner && bases[k].base.vertex == bases[last].base.vertex) {
      bases[last].stiffness += bases[k].stiffness;
    } else {
      bases[++last] = bases[k];
    }
  }
  if (!bases.empty()) bases.erase(bases.begin() + static_cast<std::ptrdiff_t>(last) + 1, bases.end());
}

BaseTable table_of(Index particles, const std::vector<StiffBase>& bases) {
  BaseTable table;
  table.offset.assign(static_cast<std::size_t>(particles) + 1, 0);
  table.stiffness.assign(static_cast<std::size_t>(particles), 0.0);
  for (const StiffBase& it : bases) {
    ++table.offset[it.owner + 1];
    table.stiffness[it.owner] += it.stiffness;
  }
  for (Index i = 0; i < particles; ++i) table.offset[i + 1] += table.offset[i];
  for (const StiffBase& it : bases) {
    table.base.push_back(it.base);
    table.weight.push_back(it.stiffness / table.stiffness[it.owner]);
  }
  return table;
}

}  // namespace

std::vector<Calibration> calibrate_model(const Model& model, PoissonRoute route) {
  if (model.dimension != 3) {
    throw Error("a material needs a three-dimensional model, this one has " + std::to_string(model.dimension) +
                " dimensions. Clear its materials and set stiffness in N/m");
  }
  for (Index cell = 0; cell < static_cast<Index>(model.cells.size()); ++cell) {
    if (!is_volume(model.cells[cell].type) || model.cells[cell].material >= 0) continue;
    throw Error(cell_label(model, cell) +
                " has no material although others have; give every volume cell one with set_material");
  }
  std::vector<Calibration> result;
  for (const Material& material : model.materials) result.push_back(calibrate(material, route));
  for (const Calibration& calibration : result) {
    if (std::abs(calibration.exponent - result.front().exponent) <= 1e-9) continue;
    throw Error(
        "the area exponent is one for the whole body, so that all materials must have one Poisson's ratio. "
        "Use PoissonRoute::volume_term");
  }
  return result;
}

BaseTable calibrated_bases(const Model& model, const TopologyOptions& options,
                           const std::vector<Calibration>& calibration, double share, std::int64_t most_rows) {
  std::vector<StiffBase> bases = options.bases == BaseSelection::fitted
                                     ? fitted_views(model, options, calibration, share)
                                     : cell_views(model, calibration, share);
  merge(bases);
  require_base_rows(bases.size(), most_rows);
  return table_of(model.particle_count(), bases);
}

std::vector<VolumeTexel> calibrated_volumes(const Model& model, const std::vector<Calibration>& calibration,
                                            double share) {
  std::vector<VolumeTexel> terms;
  for (const CornerSimplex& simplex : corner_simplices(model)) {
    const double kappa = share * calibration[model.cells[simplex.cell].material].kappa;
    if (kappa > 0.0) terms.push_back({simplex.vertex, 1.0 / simplex.volume, kappa * simplex.share});
  }
  return terms;
}

}  // namespace phymul
