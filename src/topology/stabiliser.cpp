// SPDX-License-Identifier: MIT
#include "averaged_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "base/side_by_side.h"
#include "body_frames.h"
#include "cell_quadrature.h"
#include "energies.h"

namespace phymul {
namespace {

constexpr std::size_t cell_types = 10;  // of CellType

/// A column for each of the products x_a x_b of coordinates, from which every bending is made; place[a][b] is theirs.
using Gradients = Eigen::Matrix<double, 3, 6>;
constexpr std::array<std::array<int, 3>, 3> place{{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}}};

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

BodyFrames frames_of(const Model& model, const Domains& domains) {
  std::vector<double> volume(model.rest.size(), 0.0);
  for (Index d = 0; d < domains.count(); ++d) volume[domains.particle[d]] += domains.volume[domains.kind[d]];
  return BodyFrames(model, volume, [&](const auto& visit) {
    for (Index d = 0; d < domains.count(); ++d) {
      domains.for_each_pair(d, [&](Index e, Index) {
        const Index i = domains.particle[d], j = domains.particle[e];
        if (i < j) visit(i, j);
      });
    }
  });
}

/// Energies of one part of the body, by type of cell. Means and spread are summed as what they differ by, cell by cell:
/// of a fine mesh that is too little to be the difference of two sums.
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
        frames_(frames_of(model, domains)),
        ways_(bendings(model.dimension)),
        mean_(domains.particle.size()) {
    for (const Material& material : model.materials) elastic_.emplace_back(material, model.dimension);
  }

  const BodyFrames& frames() const { return frames_; }

  /// [parts][bendings]
  std::vector<std::vector<Energies>> energies() {
    in_halves(domains_.count(), domains_.host, [&](int, Index first, Index last) {
      for (Index d = first; d < last; ++d) find_mean(d);
    });
    std::array<std::vector<std::vector<Energies>>, 2> sums;
    in_halves(domains_.of_cell.rows(), domains_.host, [&](int half, Index first, Index last) {
      sums[half].assign(static_cast<std::size_t>(frames_.parts()), std::vector<Energies>(ways_.size()));
      std::vector<CellPoint> points;
      for (Index row = first; row < last; ++row) {
        if (domains_.of_cell.size(row) == 0) continue;
        add_cell(row, points, sums[half][frames_.part(model_.cells[row].particles.front())]);
      }
    });
    for (std::size_t part = 0; part < sums[0].size(); ++part) {
      for (std::size_t k = 0; k < ways_.size(); ++k) sums[0][part][k] += sums[1][part][k];
    }
    return sums[0];
  }

 private:
  /// Energy densities at a domain's mean gradient: of the material, and what the stabiliser takes off at s = 1.
  struct Mean {
    double energy = 0.0, stabiliser = 0.0;
  };

  void find_mean(Index d) {
    const Elastic& elastic = elastic_[domains_.material[d]];
    const Products own = products(frames_.local(domains_.particle[d]));
    const Mat3 to_frame = frames_.of_part(frames_.part(domains_.particle[d])).axes.transpose();
    Gradients gradients = Gradients::Zero();
    domains_.for_each_pair(d, [&](Index e, Index row) {
      const Products other = products(frames_.local(domains_.particle[e]));
      add(to_frame * domains_.area[row], other - own, gradients);
    });
    gradients /= domains_.volume[domains_.kind[d]];
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
    const Mat3 to_frame = frames_.of_part(frames_.part(cell.particles.front())).axes.transpose();
    std::array<std::array<double, 8>, 3> height;  // along each axis
    std::array<Products, 8> product;
    for (std::size_t v = 0; v < domain.size(); ++v) {
      const Vec3 x = frames_.local(cell.particles[v]);
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
      for (std::size_t v = 0; v < domain.size(); ++v) add(to_frame * point.gradient[v], product[v], gradients);
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
  BodyFrames frames_;
  std::vector<Bending> ways_;
  std::vector<Elastic> elastic_;
  std::vector<std::array<Mean, 6>> mean_;  // [D], by bending
};

}  // namespace

namespace {

/// Of one part of the body, from its energies in each bending.
std::vector<CalibratedStabiliser> calibrated(Index part, const std::vector<Energies>& energies) {
  std::array<double, cell_types> sum{}, lowest, highest;
  lowest.fill(std::numeric_limits<double>::infinity());
  highest.fill(-std::numeric_limits<double>::infinity());
  std::array<int, cell_types> found{};
  for (const Energies& energy : energies) {
    for (std::size_t type = 0; type < cell_types; ++type) {
      // A part of one cell, say, has no spread to speak of: nothing to calibrate by.
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
    // Rounded, so that a body beside others, whose sums are cut elsewhere, has the very same value.
    const double value = std::round(sum[type] / found[type] * 1e6) / 1e6;
    result.push_back({part, static_cast<CellType>(type), value, lowest[type], highest[type]});
  }
  return result;
}

}  // namespace

std::vector<double> CalibratedStabilisers::of_cells(const Model& model, const Domains& domains) const {
  // Half the surface around a particle, weighted by N^2: C_dd, over all its domains.
  VecList surface(model.rest.size(), Vec3::Zero());
  std::vector<double> volume(model.rest.size(), 0.0);
  for (Index d = 0; d < domains.count(); ++d) {
    surface[domains.particle[d]] += domains.area[domains.first_pair(d) + domains.place(d, d)];
    volume[domains.particle[d]] += domains.volume[domains.kind[d]];
  }
  std::vector<double> least_of(static_cast<std::size_t>(parts), least_stabiliser_of_layers);
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const double side = std::pow(volume[i], 1.0 / model.dimension);
    if (surface[i].norm() < 1e-6 * std::pow(side, model.dimension - 1)) least_of[part[i]] = least_stabiliser;
  }
  std::vector<double> values(model.cells.size(), 0.0);
  for (Index row = 0; row < domains.of_cell.rows(); ++row) {
    if (domains.of_cell.size(row) == 0) continue;
    const Cell& cell = model.cells[row];
    const double least = least_of[part[cell.particles.front()]];
    values[row] = least;
    for (const CalibratedStabiliser& it : all) {
      if (it.part == part[cell.particles.front()] && it.type == cell.type) values[row] = std::max(least, it.value);
    }
  }
  return values;
}

CalibratedStabilisers calibrated_stabilisers(const Model& model, const Domains& domains) {
  BendingTest test(model, domains);
  CalibratedStabilisers result;
  const std::vector<std::vector<Energies>> energies = test.energies();
  for (Index part = 0; part < test.frames().parts(); ++part) {
    const std::vector<CalibratedStabiliser> of_part = calibrated(part, energies[part]);
    result.all.insert(result.all.end(), of_part.begin(), of_part.end());
  }
  result.parts = test.frames().parts();
  for (Index i = 0; i < model.particle_count(); ++i) result.part.push_back(test.frames().part(i));
  return result;
}

}  // namespace phymul
