// SPDX-License-Identifier: MIT
#include "calibrated_bases.h"
#include "model/cell_geometry.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "cell_terms.h"
#include "corner_simplices.h"
#include "isotropic_fit.h"

namespace phymul {
namespace {

// A corner's own view and its three edge neighbours' views. On a cube these weights make the fourth moment isotropic:
// four diagonals at 0.15, three axes at 2/15.
constexpr double corner_view = 0.6;

constexpr double tolerated_anisotropy = 0.03;
constexpr double least_view_share = 0.1;  // against the deformations of a hexahedron that leave its mean alone

struct StiffBase {
  Index owner;
  RestBase base;
  double stiffness;  // k_t, N/m
};

struct View {
  Index owner;
  RestBase base;
  double share;  // of the cell's shape energy, sum 1
};

std::vector<View> views_of(const Model& model, CellType type, const std::vector<CornerSimplex>& corners) {
  double volume = 0.0;
  for (const CornerSimplex& corner : corners) volume += corner.share;
  const double first = type == CellType::tetrahedron ? 0.25 : corner_view;
  std::vector<View> views;
  for (const CornerSimplex& corner : corners) {
    for (const OppositeFace& face : opposite_faces(corner)) {
      const double part = face.owner == corner.vertex[0] ? first : (1.0 - first) / 3.0;
      views.push_back({face.owner, rest_base(model.rest, face.owner, face.vertex), part * corner.share / volume});
    }
  }
  return views;
}

// Distance of the views' fourth moment from the isotropic one, over the latter's size.
double anisotropy(const std::vector<View>& views) {
  FourthMoment moment = FourthMoment::Zero();
  for (const View& view : views) moment += view.share * fourth_moment(view.base.normal);
  return (moment - isotropic_moment(3)).norm() / isotropic_moment(3).norm();
}

double mean_deformation_share(const std::vector<View>& views, const TopologyOptions& options) {
  if (options.poisson_route == PoissonRoute::area_exponent) return 0.0;
  const double needed = 1.0 - tolerated_anisotropy / std::max(anisotropy(views), tolerated_anisotropy);
  return std::max(options.cell_average, std::min(needed, 1.0 - least_view_share));
}

// Views and volume terms of one cell; returns what is left to its mean deformation.
CellShare add_cell(const Model& model, Index row, const Calibration& material, const TopologyOptions& options,
                   std::vector<StiffBase>& bases, std::vector<VolumeTexel>& volumes) {
  const CellType type = model.cells[row].type;
  const std::vector<CornerSimplex> corners = corner_simplices(model, row);
  const std::vector<View> views = views_of(model, type, corners);
  const double averaged =
      options.bases == BaseSelection::fitted ? options.cell_average : mean_deformation_share(views, options);
  // A tetrahedron has one volume, in its cell term where it has that.
  const double averaged_volume = type == CellType::tetrahedron && averaged > 0.0 ? 1.0 : averaged;
  double volume = 0.0;
  for (const CornerSimplex& corner : corners) {
    volume += corner.share;
    const double stiffness = (1.0 - averaged_volume) * material.kappa * corner.share;
    if (stiffness > 0.0) volumes.push_back({corner.vertex, 1.0 / corner.volume, stiffness});
  }
  if (options.bases != BaseSelection::fitted) {
    const double energy = (1.0 - averaged) * material.c * volume;
    for (const View& view : views) {
      bases.push_back({view.owner, view.base, energy * view.share / (view.base.beta * view.base.beta)});
    }
  }
  return {averaged, averaged_volume};
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
                                    const std::vector<Calibration>& calibration) {
  const double share = 1.0 - options.cell_average;
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

CalibratedBody calibrated_body(const Model& model, const TopologyOptions& options,
                               const std::vector<Calibration>& calibration, std::int64_t most_rows) {
  CalibratedBody body;
  std::vector<StiffBase> bases;
  std::vector<CellShare> shares(model.cells.size());
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    const Cell& cell = model.cells[row];
    if (!is_volume(cell.type)) continue;
    shares[row] = add_cell(model, row, calibration[cell.material], options, bases, body.volumes);
  }
  if (options.bases == BaseSelection::fitted) bases = fitted_views(model, options, calibration);
  merge(bases);
  require_base_rows(bases.size(), most_rows);
  body.bases = table_of(model.particle_count(), bases);
  body.cells = cell_terms(model, calibration, shares);
  return body;
}

}  // namespace phymul
