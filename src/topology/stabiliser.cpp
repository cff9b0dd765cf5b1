// SPDX-License-Identifier: MIT
#include "stabiliser.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "cell_quadrature.h"
#include "halves.h"

namespace phymul {
namespace {

constexpr std::size_t cell_types = 10;  // of CellType

/// Bending along axis a about the plane x_b = 0.
struct Bending {
  int a, b, c;
};

std::vector<Bending> bendings(int dimension) {
  if (dimension == 2) return {{0, 1, 2}, {1, 0, 2}};
  return {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
}

/// Constants per unit of Young's modulus.
struct Elastic {
  double mu, lambda;
  double poisson, young;  ///< of the bending field: those of plane strain in 2-D

  Elastic(const Material& material, int dimension) {
    const double nu = material.poisson;
    mu = 0.5 / (1.0 + nu);
    lambda = nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    poisson = dimension == 2 ? nu / (1.0 - nu) : nu;
    young = dimension == 2 ? 1.0 / (1.0 - nu * nu) : 1.0;
  }

  /// Energy density of the strain in a displacement gradient.
  double energy(const Mat3& H) const {
    const Mat3 strain = 0.5 * (H + H.transpose());
    return mu * strain.squaredNorm() + 0.5 * lambda * strain.trace() * strain.trace();
  }
};

/// Products x_a x_b of coordinates, from which every bending is made, at place[a][b]; a column of Gradients each.
using Products = Eigen::Matrix<double, 1, 6>;
using Gradients = Eigen::Matrix<double, 3, 6>;
constexpr std::array<std::array<int, 3>, 3> place{{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}}};

Products products(const Vec3& x) {
  return {x.x() * x.x(), x.y() * x.y(), x.z() * x.z(), x.x() * x.y(), x.y() * x.z(), x.z() * x.x()};
}

/// Adds gradient * product, column by column: an outer product takes twice as long.
void add(const Vec3& gradient, const Products& product, Gradients& sum) {
  for (int k = 0; k < 6; ++k) sum.col(k) += gradient * product[k];
}

/// Displacement gradient of a bending. In 2-D products with x_c are zero.
Mat3 bent(const Gradients& of, const Bending& way, double nu) {
  const auto gradient = [&](int a, int b) { return of.col(place[a][b]).transpose(); };
  Mat3 H;
  H.row(way.a) = gradient(way.a, way.b);
  H.row(way.b) = -0.5 * (gradient(way.a, way.a) + nu * (gradient(way.b, way.b) - gradient(way.c, way.c)));
  H.row(way.c) = -nu * gradient(way.b, way.c);
  return H;
}

Vec3 centroid(const Model& model, const Domains& domains) {
  Vec3 sum = Vec3::Zero();
  double volume = 0.0;
  for (Index d = 0; d < domains.count(); ++d) {
    sum += domains.volume[d] * model.rest[domains.particle[d]];
    volume += domains.volume[d];
  }
  return sum / volume;
}

/// Energies by type of cell. Means and spread are summed as what they differ by, cell by cell: of a fine mesh that is
/// too little to be the difference of two sums.
struct Energies {
  std::array<double, cell_types> exact{};
  std::array<double, cell_types> lacking{};  ///< exact less those of the means
  std::array<double, cell_types> spread{};   ///< at s = 1

  void operator+=(const Energies& other) {
    for (std::size_t type = 0; type < cell_types; ++type) {
      exact[type] += other.exact[type];
      lacking[type] += other.lacking[type];
      spread[type] += other.spread[type];
    }
  }
};

class BendingTest {
 public:
  BendingTest(const Model& model, const Domains& domains)
      : model_(model),
        domains_(domains),
        centre_(centroid(model, domains)),
        ways_(bendings(model.dimension)),
        mean_(domains.particle.size()) {
    for (const Material& material : model.materials) elastic_.emplace_back(material, model.dimension);
  }

  /// Of each bending.
  std::vector<Energies> energies() {
    in_halves(domains_.count(), [&](int, Index first, Index last) {
      for (Index d = first; d < last; ++d) find_mean(d);
    });
    std::array<std::vector<Energies>, 2> sums;
    in_halves(domains_.of_cell.rows(), [&](int part, Index first, Index last) {
      sums[part].resize(ways_.size());
      std::vector<CellPoint> points;
      for (Index row = first; row < last; ++row) {
        if (domains_.of_cell.size(row) > 0) add_cell(row, points, sums[part]);
      }
    });
    for (std::size_t k = 0; k < ways_.size(); ++k) sums[0][k] += sums[1][k];
    return sums[0];
  }

 private:
  /// Energy densities at a domain's mean gradient: of the material, and what the stabiliser takes off at s = 1.
  struct Mean {
    double energy = 0.0, stabiliser = 0.0;
  };

  Vec3 from_centre(Index particle) const { return model_.rest[particle] - centre_; }

  void find_mean(Index d) {
    const Elastic& elastic = elastic_[domains_.material[d]];
    const Products own = products(from_centre(domains_.particle[d]));
    Gradients gradients = Gradients::Zero();
    for (Index r = domains_.pairs.offset[d]; r < domains_.pairs.offset[d + 1]; ++r) {
      const Products other = products(from_centre(domains_.particle[domains_.pairs.entry[r]]));
      add(domains_.area[r], other - own, gradients);
    }
    gradients /= domains_.volume[d];
    for (std::size_t k = 0; k < ways_.size(); ++k) {
      const Mat3 H = bent(gradients, ways_[k], elastic.poisson);
      mean_[d][k] = {elastic.energy(H), 0.5 * elastic.mu * H.squaredNorm()};
    }
  }

  void add_cell(Index row, std::vector<CellPoint>& points, std::vector<Energies>& sums) const {
    const Cell& cell = model_.cells[row];
    const Elastic& elastic = elastic_[cell.material];
    const auto type = static_cast<std::size_t>(cell.type);
    const std::span<const Index> domain(domains_.of_cell.begin(row), domains_.of_cell.end(row));
    cell_points(model_, row, points);
    std::array<std::array<double, 8>, 3> height;  // along each axis
    std::array<Products, 8> product;
    for (std::size_t v = 0; v < domain.size(); ++v) {
      const Vec3 x = from_centre(cell.particles[v]);
      for (int axis = 0; axis < 3; ++axis) height[axis][v] = x[axis];
      product[v] = products(x);
    }
    std::array<double, 3> square;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      square[axis] = integral_of_square(cell.type, points, std::span(height[axis]).first(domain.size()));
    }
    std::array<double, 6> lacking{}, spread{};  // of each bending
    for (std::size_t k = 0; k < ways_.size(); ++k) {
      lacking[k] = 0.5 * elastic.young * square[ways_[k].b];
      sums[k].exact[type] += lacking[k];
    }
    for (const CellPoint& point : points) {
      Gradients gradients = Gradients::Zero();
      for (std::size_t v = 0; v < domain.size(); ++v) add(point.gradient[v], product[v], gradients);
      for (std::size_t k = 0; k < ways_.size(); ++k) {
        spread[k] += point.volume * 0.5 * elastic.mu * bent(gradients, ways_[k], elastic.poisson).squaredNorm();
      }
      for (std::size_t v = 0; v < domain.size(); ++v) {
        const double part = point.volume * point.value[v];
        for (std::size_t k = 0; k < ways_.size(); ++k) {
          lacking[k] -= part * mean_[domain[v]][k].energy;
          spread[k] -= part * mean_[domain[v]][k].stabiliser;
        }
      }
    }
    for (std::size_t k = 0; k < ways_.size(); ++k) {
      sums[k].lacking[type] += lacking[k];
      sums[k].spread[type] += spread[k];
    }
  }

  const Model& model_;
  const Domains& domains_;
  Vec3 centre_;
  std::vector<Bending> ways_;
  std::vector<Elastic> elastic_;
  std::vector<std::array<Mean, 6>> mean_;  // [D], by bending
};

}  // namespace

std::vector<CalibratedStabiliser> calibrated_stabilisers(const Model& model, const Domains& domains) {
  BendingTest test(model, domains);
  std::array<double, cell_types> sum{}, lowest, highest;
  lowest.fill(std::numeric_limits<double>::infinity());
  highest.fill(-std::numeric_limits<double>::infinity());
  std::array<int, cell_types> found{};
  for (const Energies& energy : test.energies()) {
    for (std::size_t type = 0; type < cell_types; ++type) {
      // A body of one cell, say, has no spread to speak of: nothing to calibrate by.
      if (!(energy.spread[type] > 1e-9 * energy.exact[type])) continue;
      const double s = energy.lacking[type] / energy.spread[type];
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
