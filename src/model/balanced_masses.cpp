// SPDX-License-Identifier: MIT
#include "material.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "cell_geometry.h"

namespace phymul {
namespace {

/// Of the estimate. It is that of a particle that moves alone: below, the body as a whole sets the step.
constexpr double least_gain = 1.3;
constexpr int halvings = 7;  // of the interval of bounds, by its logarithm
constexpr int most_rounds = 24;
/// Of a particle's mass beyond what it can spare, which it may give in a round: it then asks its own neighbours.
constexpr double passed_on = 0.2;
/// Of its mass, by which a particle may stay lighter than it should be.
constexpr double lightness = 0.01;

/// Vertex v of a cell with its edge neighbours (2-D: two), and their barycentric coordinates' gradients, 1/m.
struct Corner {
  std::array<Index, 4> particle{};
  std::array<Vec3, 4> gradient{};
  int size = 0;  // 0: none, as at the apex of a pyramid, or if it is flat
};

Corner corner_of(const Model& model, const Cell& cell, std::size_t v) {
  Corner corner;
  const std::size_t n = cell.particles.size();
  if (model.dimension == 2) {
    corner.particle = {cell.particles[v], cell.particles[(v + 1) % n], cell.particles[(v + n - 1) % n], -1};
  } else {
    const auto rows = cell_corners(cell.type);
    if (v >= rows.size()) return corner;
    for (int k = 0; k < 4; ++k) corner.particle[k] = cell.particles[rows[v][k]];
  }
  const auto edge = [&](int k) { return Vec3(model.rest[corner.particle[k]] - model.rest[corner.particle[0]]); };
  const Vec3 a = edge(1), b = edge(2), c = model.dimension == 2 ? Vec3(Vec3::UnitZ()) : edge(3);
  const double volume = a.dot(b.cross(c));
  if (!(volume > 0.0)) return corner;
  corner.gradient = {Vec3::Zero(), b.cross(c) / volume, c.cross(a) / volume, a.cross(b) / volume};
  corner.size = model.dimension + 1;
  for (int k = 1; k < corner.size; ++k) corner.gradient[0] -= corner.gradient[k];
  return corner;
}

/// The cells with a material around each particle, and its place in them.
class CellsAround {
 public:
  explicit CellsAround(const Model& model) : first_(model.rest.size() + 1, 0) {
    const auto counts = [&](const Cell& cell) { return cell.material >= 0 && is_solid(model.dimension, cell); };
    for (const Cell& cell : model.cells) {
      if (!counts(cell)) continue;
      for (const Index i : cell.particles) ++first_[i + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    entries_.resize(static_cast<std::size_t>(first_.back()));
    std::vector<Index> next(first_.begin(), first_.end() - 1);
    for (const Cell& cell : model.cells) {
      if (!counts(cell)) continue;
      for (std::size_t v = 0; v < cell.particles.size(); ++v) entries_[next[cell.particles[v]]++] = {&cell, v};
    }
  }

  std::span<const std::pair<const Cell*, std::size_t>> operator[](std::size_t i) const {
    return std::span(entries_).subspan(first_[i], first_[i + 1] - first_[i]);
  }

 private:
  std::vector<Index> first_;
  std::vector<std::pair<const Cell*, std::size_t>> entries_;
};

/// [N] kg/m^2: of each particle a bound on its own block of the stiffness in the law of one mean deformation per
/// particle (docs/theory/physics.md), over the squared speed of the pressure wave: the sum over neighbourhoods d of rho
/// |C_d|^2 / V_d. Other cells than tetrahedra and triangles count by their corners. So only the shape of cells counts,
/// and no material gets mass of another because it is stiffer.
std::vector<double> own_stiffness(const Model& model, const CellsAround& cells) {
  const std::size_t count = model.rest.size();
  std::vector<double> share_of(model.cells.size(), 0.0);  // of each vertex, m^3
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    const Cell& cell = model.cells[c];
    share_of[c] = signed_measure(model.dimension, cell, model.rest) / static_cast<double>(cell.particles.size());
  }
  std::vector<double> stiffness(count, 0.0);
  std::vector<Index> row_of(count, -1), around;  // of the neighbourhood at hand
  std::vector<Vec3> area;
  for (std::size_t d = 0; d < count; ++d) {
    around.clear();
    area.clear();
    double volume = 0.0, own_mass = 0.0;
    for (const auto& [cell, place] : cells[d]) {
      const double share = share_of[cell - model.cells.data()];
      volume += share;
      own_mass += share * model.materials[cell->material].density;
      const Corner corner = corner_of(model, *cell, place);
      for (int e = 0; e < corner.size; ++e) {
        const Index j = corner.particle[e];
        if (row_of[j] < 0) {
          row_of[j] = static_cast<Index>(around.size());
          around.push_back(j);
          area.push_back(Vec3::Zero());
        }
        area[row_of[j]] += share * corner.gradient[e];
      }
    }
    for (std::size_t k = 0; k < around.size(); ++k) {
      stiffness[around[k]] += own_mass * area[k].squaredNorm() / (volume * volume);
      row_of[around[k]] = -1;
    }
  }
  return stiffness;
}

struct Transfer {
  std::vector<double> mass;  // [N] kg
  bool is_done = false;      // each particle has what it needs
};

/// Each particle with less than stiffness / bound asks those in its cells that have enough, in proportion to what they
/// can give, until none does.
Transfer transfer(const CellsAround& cells, const std::vector<double>& stiffness, std::vector<double> mass,
                  double bound) {
  const std::size_t count = mass.size();
  Transfer result{.mass = std::move(mass)};
  const auto spare = [&](std::size_t i) { return result.mass[i] - stiffness[i] / bound; };
  const auto lacks = [&](std::size_t i) { return spare(i) < -lightness * result.mass[i]; };
  struct Giver {
    double can_give = -1.0, asked = 0.0;  // kg; below 0: not yet looked at in this round
  };
  std::vector<Giver> givers(count);
  std::vector<std::size_t> asking, around;
  for (std::size_t i = 0; i < count; ++i) {
    if (lacks(i)) asking.push_back(i);
  }
  const auto each_neighbour = [&](std::size_t i, const auto& visit) {
    for (const auto& [cell, place] : cells[i]) {
      for (const Index j : cell->particles) visit(static_cast<std::size_t>(j));
    }
  };
  std::vector<double> found(count);  // kg, that the neighbours of one that asks can give
  for (int round = 0; round < most_rounds && !asking.empty(); ++round) {
    around.clear();
    for (const std::size_t i : asking) {
      found[i] = 0.0;
      each_neighbour(i, [&](std::size_t j) {
        if (givers[j].can_give < 0.0) {
          around.push_back(j);
          givers[j].can_give = lacks(j) ? 0.0 : std::max(spare(j), 0.0) + passed_on * result.mass[j];
        }
        found[i] += givers[j].can_give;
      });
    }
    for (const std::size_t i : asking) {
      if (!(found[i] > 0.0)) continue;
      each_neighbour(i, [&](std::size_t j) { givers[j].asked -= spare(i) * givers[j].can_give / found[i]; });
    }
    for (const std::size_t i : asking) {
      if (!(found[i] > 0.0)) continue;
      const double lack = -spare(i);
      each_neighbour(i, [&](std::size_t j) {
        const auto [can_give, asked] = givers[j];
        if (!(can_give > 0.0)) return;
        const double given = lack * can_give / found[i] * std::min(1.0, can_give / asked);
        result.mass[i] += given;
        result.mass[j] -= given;
      });
    }
    asking.clear();
    for (const std::size_t i : around) {  // those that asked among them
      givers[i] = {};
      if (lacks(i)) asking.push_back(i);
    }
  }
  result.is_done = asking.empty();
  return result;
}

double moved_between(const std::vector<double>& from, const std::vector<double>& to) {
  double sum = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) sum += std::max(0.0, to[i] - from[i]);
  return sum;
}

using Moments = Eigen::Matrix<double, 10, 1>;

/// Multiplies the masses by a polynomial of second degree so that the moments up to the second are those of `as`.
void keep_moments(const VecList& rest, const std::vector<double>& as, std::vector<double>& mass) {
  Vec3 centre = Vec3::Zero();
  double total = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < as.size(); ++i) {
    centre += as[i] * rest[i];
    total += as[i];
  }
  centre /= total;
  for (std::size_t i = 0; i < as.size(); ++i) squares += as[i] * (rest[i] - centre).squaredNorm();
  const double scale = std::sqrt(total / squares);
  const auto powers = [&](std::size_t i) {
    const Vec3 x = scale * (rest[i] - centre);
    Moments p;
    p << 1.0, x, x.x() * x.x(), x.y() * x.y(), x.z() * x.z(), x.y() * x.z(), x.z() * x.x(), x.x() * x.y();
    return p;
  };
  Moments lost = Moments::Zero();
  Eigen::Matrix<double, 10, 10> products = Eigen::Matrix<double, 10, 10>::Zero();
  for (std::size_t i = 0; i < as.size(); ++i) {
    const Moments p = powers(i);
    lost += (as[i] - mass[i]) * p;
    products += mass[i] * p * p.transpose();
  }
  const Moments polynomial = products.ldlt().solve(lost);  // 0 for powers that vanish, as those of z in 2-D
  for (std::size_t i = 0; i < as.size(); ++i) mass[i] *= 1.0 + polynomial.dot(powers(i));
}

}  // namespace

MassBalance balance_masses(const Model& model, std::vector<double>& mass) {
  if (!(model.most_mass_moved > 0.0)) return {};
  const CellsAround cells(model);
  const std::vector<double> stiffness = own_stiffness(model, cells);
  double total = 0.0, sum = 0.0, highest = 0.0;
  for (std::size_t i = 0; i < mass.size(); ++i) {
    if (!(mass[i] > 0.0)) continue;
    total += mass[i];
    sum += stiffness[i];
    highest = std::max(highest, stiffness[i] / mass[i]);
  }
  if (!(sum > 0.0)) return {};
  const double most = model.most_mass_moved * total;
  double low = std::log(sum / total), high = std::log(highest);
  double reached = highest;
  std::vector<double> moved_so_far = mass, best = mass;
  MassBalance balance;
  for (int k = 0; k < halvings; ++k) {
    const double below = low, middle = 0.5 * (low + high), bound = std::exp(middle);
    low = middle;  // unless the bound is reached
    double wanted = 0.0;
    for (std::size_t i = 0; i < mass.size(); ++i) wanted += std::max(0.0, stiffness[i] / bound - mass[i]);
    if (wanted > most) continue;
    Transfer tried = transfer(cells, stiffness, moved_so_far, bound);
    if (!tried.is_done) continue;
    std::vector<double> corrected = tried.mass;
    keep_moments(model.rest, mass, corrected);
    const double moved = moved_between(mass, corrected);
    double rate = 0.0;  // what the correction leaves of the bound
    for (std::size_t i = 0; i < mass.size(); ++i) {
      if (mass[i] > 0.0) rate = std::max(rate, corrected[i] > 0.0 ? stiffness[i] / corrected[i] : highest);
    }
    if (moved > most || rate >= reached) continue;
    low = below;
    high = middle;
    reached = rate;
    balance.moved = moved / total;
    best = std::move(corrected);
    moved_so_far = std::move(tried.mass);
  }
  balance.gain = std::sqrt(highest / reached);
  if (!(balance.gain >= least_gain)) return {};
  mass = std::move(best);
  return balance;
}

}  // namespace phymul
