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

/// Energies by type of cell: exact, of the means, and of the spread at s = 1.
struct Energies {
  std::array<double, cell_types> exact{}, means{}, spread{};

  void operator+=(const Energies& other) {
    for (std::size_t type = 0; type < cell_types; ++type) {
      exact[type] += other.exact[type];
      means[type] += other.means[type];
      spread[type] += other.spread[type];
    }
  }
};

class BendingTest {
 public:
  BendingTest(const Model& model, const Domains& domains)
      : model_(model), domains_(domains), centre_(centroid(model, domains)), ways_(bendings(model.dimension)) {
    for (const Material& material : model.materials) elastic_.emplace_back(material, model.dimension);
    for (Sums& half : halves_) half.of.resize(ways_.size());
  }

  /// Of each bending.
  std::vector<Energies> energies() {
    in_halves(domains_.of_cell.rows(), [&](int part, Index first, Index last) {
      std::vector<CellPoint> points;
      for (Index row = first; row < last; ++row) {
        if (domains_.of_cell.size(row) > 0) add_cell(row, points, halves_[part]);
      }
    });
    in_halves(domains_.count(), [&](int part, Index first, Index last) {
      for (Index d = first; d < last; ++d) add_mean(d, halves_[part].of);
    });
    std::vector<Energies> sum = halves_[0].of;
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += halves_[1].of[k];
    return sum;
  }

 private:
  /// Of one half of the body.
  struct Sums {
    std::vector<Energies> of;                            // each bending
    std::array<std::vector<double>, cell_types> volume;  // [D] of a domain in cells of a type; empty without any
  };

  Vec3 from_centre(Index particle) const { return model_.rest[particle] - centre_; }

  void add_cell(Index row, std::vector<CellPoint>& points, Sums& sums) const {
    const Cell& cell = model_.cells[row];
    const Elastic& elastic = elastic_[cell.material];
    const auto type = static_cast<std::size_t>(cell.type);
    const std::size_t vertices = cell.particles.size();
    cell_points(model_, row, points);
    std::array<std::array<double, 8>, 3> height;  // along each axis
    std::array<Products, 8> product;
    for (std::size_t v = 0; v < vertices; ++v) {
      const Vec3 x = from_centre(cell.particles[v]);
      for (int axis = 0; axis < 3; ++axis) height[axis][v] = x[axis];
      product[v] = products(x);
    }
    std::array<double, 3> square;
    for (int axis = 0; axis < 3; ++axis) {
      square[axis] = integral_of_square(cell.type, points, std::span(height[axis]).first(vertices));
    }
    for (std::size_t k = 0; k < ways_.size(); ++k) sums.of[k].exact[type] += 0.5 * elastic.young * square[ways_[k].b];
    std::vector<double>& volume = sums.volume[type];
    volume.resize(domains_.particle.size(), 0.0);
    for (const CellPoint& point : points) {
      Gradients gradients = Gradients::Zero();
      for (std::size_t v = 0; v < vertices; ++v) {
        add(point.gradient[v], product[v], gradients);
        volume[domains_.of_cell.begin(row)[v]] += point.volume * point.value[v];
      }
      for (std::size_t k = 0; k < ways_.size(); ++k) {
        const double squares = bent(gradients, ways_[k], elastic.poisson).squaredNorm();
        sums.of[k].spread[type] += point.volume * 0.5 * elastic.mu * squares;
      }
    }
  }

  /// What the mean of a domain has, and what the stabiliser takes off for it at s = 1, to the types of its cells.
  void add_mean(Index d, std::vector<Energies>& sums) const {
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
      const double energy = elastic.energy(H), off = 0.5 * elastic.mu * H.squaredNorm();
      for (const Sums& half : halves_) {
        for (std::size_t type = 0; type < cell_types; ++type) {
          if (half.volume[type].empty()) continue;
          sums[k].means[type] += half.volume[type][d] * energy;
          sums[k].spread[type] -= half.volume[type][d] * off;
        }
      }
    }
  }

  const Model& model_;
  const Domains& domains_;
  Vec3 centre_;
  std::vector<Bending> ways_;
  std::vector<Elastic> elastic_;
  std::array<Sums, 2> halves_;
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
