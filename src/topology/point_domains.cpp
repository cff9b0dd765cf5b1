// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/types.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "averaged_body.h"
#include "base/decimal.h"
#include "body_frames.h"
#include "model/cell_geometry.h"

namespace phymul {
namespace {

/// Between two places of a neighbourhood: 0 is the particle, k its neighbour k - 1.
struct WeightedEdge {
  Index from, to;
  double weight;  ///< m (2-D: 1)
};

/// A fit that changes the prior weight of an edge to a neighbour by a larger factor is no good one: it would put nearly
/// all weight on few neighbours.
constexpr double most_lopsided = 1e3;
/// Prior weight of an edge between neighbours, over that of one from the particle.
constexpr double prior_between = 0.1;

/// What an edge e adds to the sums that are fitted: e e^T by entries, those off the diagonal times root 2, so that the
/// product of two is that of their entries; then e.
using Moments = Eigen::Matrix<double, 9, 1>;
using Curvature = Eigen::Matrix<double, 9, 9>;

Moments moments(const Vec3& e) {
  const double root = std::sqrt(2.0);
  Moments m;
  m << e.x() * e.x(), e.y() * e.y(), e.z() * e.z(), root * e.x() * e.y(), root * e.y() * e.z(), root * e.z() * e.x(), e;
  return m;
}

/// Weights whose sum of w e e^T is the unit tensor and, if they are to be balanced, whose sum of w e is zero: of all
/// such the ones of greatest entropy relative to the prior ones (Jaynes 1957; for shape functions Arroyo and Ortiz
/// 2006), w = prior exp(L . moments of e). L is where the sum of w less L . target is least, a convex function:
/// Newton's method finds it if there is such a place.
class IsotropicFit {
 public:
  explicit IsotropicFit(int dimension) : dimension_(dimension) { target_.head(dimension).setOnes(); }

  void add(const Vec3& e, double prior) {
    moments_.push_back(moments(e));
    prior_.push_back(prior);
  }

  /// Weights, in order of the edges. Empty where there are none, or where one is more than `most` times its prior one
  /// or less than 1/most of it.
  std::vector<double> weights(bool balanced, double most) {
    scale_priors();
    std::vector<int> idle;  // sums that are not fitted
    if (!balanced) idle = {6, 7, 8};
    if (dimension_ == 2) idle.insert(idle.end(), {2, 4, 5, 8});
    Moments L = Moments::Zero();
    for (int step = 0; step < 60; ++step) {
      Moments slope;
      Curvature curvature;
      const double value = derivatives(L, slope, curvature);
      for (const int k : idle) {
        slope[k] = 0.0;
        curvature.row(k).setZero();
        curvature.col(k).setZero();
        curvature(k, k) = curvature(0, 0);
      }
      const double error = slope.norm();
      const Eigen::LDLT<Curvature> factor(curvature);
      const auto pivots = factor.vectorD().cwiseAbs();
      if (!std::isfinite(error) || !(pivots.minCoeff() > 1e-13 * pivots.maxCoeff())) return {};
      const Moments move = -factor.solve(slope);
      double part = 1.0;
      const auto descends = [&] { return sum(L + part * move) <= value + 0.25 * part * slope.dot(move); };
      while (error > near_ && part > 1e-6 && !descends()) part *= 0.5;
      L += part * move;
      if (error <= near_) return accepted(L, most);  // after that step the error is its square
    }
    return {};
  }

 private:
  void scale_priors() {
    double trace = 0.0;
    for (std::size_t p = 0; p < prior_.size(); ++p) trace += prior_[p] * moments_[p].head<3>().sum();
    for (double& w : prior_) w *= dimension_ / trace;
  }

  double weight(std::size_t p, const Moments& L) const { return prior_[p] * std::exp(L.dot(moments_[p])); }

  double sum(const Moments& L) const {
    double total = -L.dot(target_);
    for (std::size_t p = 0; p < prior_.size(); ++p) total += weight(p, L);
    return total;
  }

  double derivatives(const Moments& L, Moments& slope, Curvature& curvature) const {
    slope = -target_;
    curvature.setZero();
    double total = -L.dot(target_);
    for (std::size_t p = 0; p < prior_.size(); ++p) {
      const double w = weight(p, L);
      total += w;
      slope += w * moments_[p];
      curvature += w * moments_[p] * moments_[p].transpose();
    }
    return total;
  }

  std::vector<double> accepted(const Moments& L, double most) const {
    std::vector<double> result;
    for (std::size_t p = 0; p < prior_.size(); ++p) {
      if (!(std::abs(L.dot(moments_[p])) <= std::log(most))) return {};
      result.push_back(weight(p, L));
    }
    return result;
  }

  static constexpr double near_ = 1e-8;
  int dimension_;
  Moments target_ = Moments::Zero();
  std::vector<Moments> moments_;
  std::vector<double> prior_;
};

/// Weights w > 0 with sum of w e e^T = volume times the unit tensor over the edges e. With that
///   H = 1/volume sum of w (u_to - u_from) e^T
/// is a mean displacement gradient, exact for linear fields; and sum of w |u_to - u_from - H e|^2 is the same as
/// sum of w |u_to - u_from|^2 - volume |H|^2, never negative.
/// `r`: neighbours relative to the particle. Where those alone cannot be so weighted (on edges and corners of a body
/// they are all on one side) the edges between near neighbours join. Empty where nothing helps: the neighbours are in a
/// plane, or too few.
std::vector<WeightedEdge> isotropic_edges(const VecList& r, int dimension, double volume) {
  double reach = 0.0;
  for (const Vec3& p : r) reach = std::max(reach, p.norm());
  if (!(reach > 0.0)) return {};
  // Lengths over the reach. The weight of far neighbours goes to zero smoothly, a little beyond the last one.
  const auto kernel = [&](Index k) {
    const double q = r[k].norm() / (1.1 * reach);
    return (1.0 - q) * (1.0 - q) * (1.0 + 2.0 * q);
  };
  IsotropicFit fit(dimension);
  std::vector<WeightedEdge> edges;
  const auto count = static_cast<Index>(r.size());
  for (Index k = 0; k < count; ++k) {
    edges.push_back({0, k + 1, 0.0});
    fit.add(r[k] / reach, kernel(k));
  }
  // Balanced inside the body, where that makes the divergence of a uniform stress almost zero; not on its surface.
  std::vector<double> weight = fit.weights(true, most_lopsided);
  if (weight.empty()) weight = fit.weights(false, most_lopsided);
  if (weight.empty()) {
    // Edges between the nearest neighbours, as few as will do: each may make a pair of particles that was none.
    std::vector<Index> near(r.size());
    std::iota(near.begin(), near.end(), 0);
    std::ranges::stable_sort(near, {}, [&](Index k) { return r[k].squaredNorm(); });
    Index joined = 1;
    for (const Index most : {8, 14, 20, count}) {
      if (!weight.empty()) break;
      for (; joined < std::min(most, count); ++joined) {
        for (Index b = 0; b < joined; ++b) {
          edges.push_back({near[b] + 1, near[joined] + 1, 0.0});
          fit.add((r[near[joined]] - r[near[b]]) / reach, prior_between * kernel(near[b]) * kernel(near[joined]));
        }
      }
      weight = fit.weights(false, std::numeric_limits<double>::max());
    }
  }
  if (weight.empty()) return {};
  for (std::size_t p = 0; p < edges.size(); ++p) edges[p].weight = volume / (reach * reach) * weight[p];
  return edges;
}

/// Of the volume that masses and density give over that of the shape, or the other way round: beyond it the masses were
/// not made for the density.
constexpr double most_excess = 10.0;

using Edges = std::vector<std::vector<WeightedEdge>>;  // [N], by rows of particles

std::vector<double> volumes(const Model& model, const std::vector<PointCell>& cells) {
  std::vector<double> volume;
  double whole = 0.0, seen = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    volume.push_back(model.mass[i] / model.materials.front().density);
    whole += volume.back();
    seen += cells[i].volume;
  }
  if (!(whole < most_excess * seen && seen < most_excess * whole)) {
    throw Error(ErrorCode::invalid_model, "the masses say that the body's volume is " + to_decimal(whole) +
                                              " m^3, the places of its particles " + to_decimal(seen) +
                                              "; call set_material, which gives particles without cells their masses");
  }
  return volume;
}

[[noreturn]] void refuse(const Model& model, Index i) {
  const bool plane = model.dimension == 2;
  throw Error(ErrorCode::invalid_model,
              "particle " + std::to_string(model.file_index(i)) + " has " + std::to_string(model.neighbours.size(i)) +
                  " neighbours, from which no gradient follows: expected at least " + (plane ? "3" : "4") +
                  " that are not all in one " + (plane ? "line" : "plane") +
                  " with it. Give it more, as nearest_neighbours does, or cells");
}

Edges edges_of(const Model& model, const RaggedList& neighbours, const std::vector<double>& volume) {
  Edges all;
  VecList r;
  for (Index i = 0; i < model.particle_count(); ++i) {
    r.clear();
    for (const Index* j = neighbours.begin(i); j != neighbours.end(i); ++j) {
      r.push_back(model.rest[*j] - model.rest[i]);
    }
    all.push_back(isotropic_edges(r, model.dimension, volume[i]));
    if (all.back().empty()) refuse(model, i);
    for (WeightedEdge& edge : all.back()) {
      const auto at = [&](Index place) { return place == 0 ? i : neighbours.begin(i)[place - 1]; };
      edge.from = at(edge.from);
      edge.to = at(edge.to);
    }
  }
  return all;
}

/// Rows of all pairs that an edge needs, with zeros for areas: its ends with each other and with the particle.
void pair_domains(const Edges& edges, Domains& domains) {
  std::vector<std::vector<Index>> rows(edges.size());
  const auto pair = [&](Index d, Index e) {
    rows[d].push_back(e);
    rows[e].push_back(d);
  };
  for (Index i = 0; i < static_cast<Index>(edges.size()); ++i) {
    rows[i].push_back(i);
    for (const WeightedEdge& edge : edges[i]) {
      pair(edge.from, edge.to);
      pair(i, edge.from);
      pair(i, edge.to);
    }
  }
  for (Index d = 0; d < static_cast<Index>(rows.size()); ++d) {
    std::vector<Index>& row = rows[d];
    for (Index& e : row) e -= d;
    std::ranges::sort(row);
    row.erase(std::ranges::unique(row).begin(), row.end());
    domains.pairs.push_row(row.begin(), row.end());
  }
  domains.kind.resize(edges.size());
  std::iota(domains.kind.begin(), domains.kind.end(), 0);
  domains.first_of_kind = domains.kind;
  domains.area.assign(domains.pairs.entry.size(), Vec3::Zero());
}

auto neighbour_pairs(const Model& model) {
  return [&model](const auto& visit) {
    for (Index i = 0; i < model.particle_count(); ++i) {
      for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) visit(i, *j);
    }
  };
}

/// Energies of a bending: exact, of the means, and of the spread at s = 1.
struct PointEnergies {
  double exact = 0.0, means = 0.0, spread = 0.0;
};

/// The stabiliser, as calibrated_stabilisers finds it for cells; here the exact energy is an integral over the
/// particles' shares of space, each scaled to the particle's volume.
class BendingOfPoints {
 public:
  BendingOfPoints(const Model& model, const Edges& edges, const std::vector<double>& volume,
                  const std::vector<PointCell>& cells)
      : model_(model),
        edges_(edges),
        volume_(volume),
        cells_(cells),
        elastic_(model.materials[0], model.dimension),
        frames_(model, volume, neighbour_pairs(model)) {}

  double stabiliser() const {
    double sum = 0.0;
    int found = 0;
    for (const Bending& way : bendings(model_.dimension)) {
      const PointEnergies energy = energies(way);
      if (!(energy.spread > 1e-9 * energy.exact)) continue;  // nothing to calibrate by
      sum += (energy.exact - energy.means) / energy.spread;
      ++found;
    }
    return found > 0 ? sum / found : 0.0;
  }

 private:
  PointEnergies energies(const Bending& way) const {
    PointEnergies sum;
    for (Index i = 0; i < model_.particle_count(); ++i) {
      const PointCell& cell = cells_[i];
      const Vec3 across = frames_.of_part(frames_.part(i)).axes.col(way.b);
      const double height = frames_.local(i)[way.b];
      const double square =
          cell.volume * height * height + 2.0 * height * cell.first.dot(across) + across.dot(cell.second * across);
      sum.exact += 0.5 * elastic_.young * volume_[i] / cell.volume * square;
      Mat3 H = Mat3::Zero();
      double squares = 0.0;
      for (const WeightedEdge& edge : edges_[i]) {
        const Vec3 from = frames_.local(edge.from), to = frames_.local(edge.to);
        const Vec3 apart =
            bent(to, way, elastic_.poisson, model_.dimension) - bent(from, way, elastic_.poisson, model_.dimension);
        H += edge.weight / volume_[i] * apart * (to - from).transpose();
        squares += edge.weight * apart.squaredNorm();
      }
      sum.means += volume_[i] * elastic_.energy(H);
      sum.spread += 0.5 * elastic_.mu * (squares - volume_[i] * H.squaredNorm());
    }
    return sum;
  }

  const Model& model_;
  const Edges& edges_;
  const std::vector<double>& volume_;
  const std::vector<PointCell>& cells_;
  Elastic elastic_;
  BodyFrames frames_;
};

}  // namespace

PointDomains point_domains(const Model& model) {
  if (model.materials.size() != 1) {
    throw Error(ErrorCode::invalid_model, "a body without cells has one material for all its particles, this one has " +
                                              std::to_string(model.materials.size()) +
                                              "; add cells where materials differ");
  }
  const RaggedList neighbours = point_neighbours(model);
  const std::vector<PointCell> cells = point_cells(model, neighbours);
  PointDomains body;
  Domains& domains = body.domains;
  domains.volume = volumes(model, cells);
  const Edges edges = edges_of(model, neighbours, domains.volume);
  domains.material.assign(edges.size(), 0);
  pair_domains(edges, domains);
  body.stiffness = {domains.pairs.offset, std::vector<double>(domains.pairs.entry.size(), 0.0)};
  const auto row = [&](Index d, Index e) { return domains.first_pair(d) + domains.place(d, e); };
  for (Index i = 0; i < static_cast<Index>(edges.size()); ++i) {
    domains.particle.push_back(i);
    for (const WeightedEdge& edge : edges[i]) {
      const Vec3 area = edge.weight * (model.rest[edge.to] - model.rest[edge.from]);
      domains.area[row(i, edge.to)] += area;
      domains.area[row(i, edge.from)] -= area;
      body.stiffness.value[row(edge.from, edge.to)] += edge.weight;
      body.stiffness.value[row(edge.to, edge.from)] += edge.weight;
    }
  }
  body.stabiliser = BendingOfPoints(model, edges, domains.volume, cells).stabiliser();
  return body;
}

}  // namespace phymul
