// SPDX-License-Identifier: MIT
#include "stabiliser.h"

#include <algorithm>
#include <limits>

#include "bending.h"
#include "cell_quadrature.h"
#include "model/cell_geometry.h"

namespace phymul {
namespace {

constexpr std::size_t cell_types = 10;  // of CellType

Vec3 centroid(const Model& model, const Domains& domains) {
  Vec3 sum = Vec3::Zero();
  double volume = 0.0;
  for (Index d = 0; d < domains.count(); ++d) {
    sum += domains.volume[d] * model.rest[domains.particle[d]];
    volume += domains.volume[d];
  }
  return sum / volume;
}

/// Energies by type of cell: exact, of the means, and of the spread at s = 1.
struct Energies {
  std::array<double, cell_types> exact{}, means{}, spread{};
};

class BendingTest {
 public:
  BendingTest(const Model& model, const Domains& domains)
      : model_(model), domains_(domains), centre_(centroid(model, domains)), mean_(domains.particle.size()) {
    for (const Material& material : model.materials) elastic_.emplace_back(material, model.dimension);
  }

  std::vector<Energies> energies(const std::vector<Bending>& ways) {
    for (Index d = 0; d < domains_.count(); ++d) {
      const Elastic& elastic = elastic_[domains_.material[d]];
      for (std::size_t k = 0; k < ways.size(); ++k) {
        const Mat3 H = mean_gradient(d, ways[k]);
        mean_[d][k] = {elastic.energy(H), 0.5 * elastic.mu * H.squaredNorm()};
      }
    }
    std::vector<Energies> sums(ways.size());
    for (Index row = 0; row < static_cast<Index>(model_.cells.size()); ++row) {
      if (!is_solid(model_.dimension, model_.cells[row].type)) continue;
      cell_points(model_, row, points_);
      for (std::size_t k = 0; k < ways.size(); ++k) add_cell(row, ways[k], k, sums[k]);
    }
    return sums;
  }

 private:
  /// Energy densities at a domain's mean gradient: of the material, and what the stabiliser takes off at s = 1.
  struct Mean {
    double energy = 0.0, stabiliser = 0.0;
  };

  Vec3 from_centre(Index particle) const { return model_.rest[particle] - centre_; }

  Mat3 mean_gradient(Index d, const Bending& way) const {
    const double nu = elastic_[domains_.material[d]].poisson;
    const Vec3 own = bent(from_centre(domains_.particle[d]), way, nu, model_.dimension);
    Mat3 H = Mat3::Zero();
    for (Index r = domains_.first_pair[d]; r < domains_.first_pair[d + 1]; ++r) {
      const DomainPair& pair = domains_.pairs[r];
      const Vec3 other = bent(from_centre(domains_.particle[pair.domain]), way, nu, model_.dimension);
      H += (other - own) * pair.area.transpose();
    }
    return H / domains_.volume[d];
  }

  void add_cell(Index row, const Bending& way, std::size_t k, Energies& sum) const {
    const Cell& cell = model_.cells[row];
    const Elastic& elastic = elastic_[cell.material];
    const auto type = static_cast<std::size_t>(cell.type);
    const std::size_t vertices = cell.particles.size();
    std::array<Vec3, 8> x, u;
    for (std::size_t v = 0; v < vertices; ++v) {
      x[v] = from_centre(cell.particles[v]);
      u[v] = bent(x[v], way, elastic.poisson, model_.dimension);
    }
    for (const CellPoint& point : points_) {
      double height = 0.0;
      Mat3 H = Mat3::Zero();
      for (std::size_t v = 0; v < vertices; ++v) {
        height += point.value[v] * x[v][way.b];
        H += u[v] * point.gradient[v].transpose();
      }
      sum.exact[type] += point.volume * 0.5 * elastic.young * height * height;
      sum.spread[type] += point.volume * 0.5 * elastic.mu * H.squaredNorm();
      for (std::size_t v = 0; v < vertices; ++v) {
        const Mean& mean = mean_[domains_.of_cell.begin(row)[v]][k];
        const double part = point.volume * point.value[v];
        sum.means[type] += part * mean.energy;
        sum.spread[type] -= part * mean.stabiliser;
      }
    }
  }

  const Model& model_;
  const Domains& domains_;
  Vec3 centre_;
  std::vector<Elastic> elastic_;
  std::vector<std::array<Mean, 6>> mean_;  // [D], by bending
  std::vector<CellPoint> points_;
};

}  // namespace

std::vector<CalibratedStabiliser> calibrated_stabilisers(const Model& model, const Domains& domains) {
  BendingTest test(model, domains);
  std::array<double, cell_types> sum{}, lowest, highest;
  lowest.fill(std::numeric_limits<double>::infinity());
  highest.fill(-std::numeric_limits<double>::infinity());
  std::array<int, cell_types> found{};
  for (const Energies& energy : test.energies(bendings(model.dimension))) {
    for (std::size_t type = 0; type < cell_types; ++type) {
      // A body of one cell, say, has no spread to speak of: nothing to calibrate by.
      if (!(energy.spread[type] > 1e-9 * energy.exact[type])) continue;
      const double s = (energy.exact[type] - energy.means[type]) / energy.spread[type];
      sum[type] += s;
      lowest[type] = std::min(lowest[type], s);
      highest[type] = std::max(highest[type], s);
      ++found[type];
    }
  }
  std::vector<CalibratedStabiliser> result;
  for (std::size_t type = 0; type < cell_types; ++type) {
    if (found[type] == 0) continue;
    result.push_back({static_cast<CellType>(type), std::max(sum[type] / found[type], least_stabiliser), lowest[type],
                      highest[type]});
  }
  return result;
}

}  // namespace phymul
