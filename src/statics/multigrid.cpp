// SPDX-License-Identifier: MIT
#include "multigrid.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/denormals.h"
#include "elastic/domain_forces.h"
#include "elastic/energy_density.h"
#include "elastic/rotation.h"

namespace phymul {
namespace {

using Vector = Eigen::VectorXd;
/// Of a damped sweep over the particles, over the largest eigenvalue: below 2 it converges; a tenth more or less
/// hardly changes the number of evaluations.
constexpr double jump = 1.5;
/// A power iteration of a few steps ends below the largest eigenvalue, the more so the larger the body.
constexpr double above_estimate = 1.3;
constexpr double finest_cells = 1.75;  // of the finest grid, in mean spacings
constexpr double little_change_of_terms = 0.1;
constexpr Index few_nodes = 120;  // factorised as a dense matrix in a few milliseconds at most

void restrict_to(const std::vector<GridPlace>& finer, const PaddedVectors& from, PaddedVectors& to) {
  numbers_of(to).setZero();
  for (std::size_t i = 0; i < finer.size(); ++i) {
    for (int a = 0; a < 8; ++a) to[finer[i].node[a]] += finer[i].weight[a] * from[i];
  }
}

Eigen::Vector4f value_at(const GridPlace& place, const PaddedVectors& from) {
  Eigen::Vector4f value = Eigen::Vector4f::Zero();
  for (int a = 0; a < 8; ++a) value += place.weight[a] * from[place.node[a]];
  return value;
}

/// Of shapes [N] and [3 N].
void copy(const PaddedVectors& from, Vector& to) {
  to.resize(3 * static_cast<Eigen::Index>(from.size()));
  for (std::size_t i = 0; i < from.size(); ++i) {
    to.segment<3>(3 * static_cast<Eigen::Index>(i)) = from[i].head<3>().cast<double>();
  }
}

}  // namespace

std::vector<Mat3> diagonal_at_rest(const TopologyTextures& t) {
  std::vector<Mat3> diagonal(static_cast<std::size_t>(t.particle_count), Mat3::Zero());
  std::vector<std::pair<Index, Vec3>> of;  // particle and how H d depends on it
  for (Index d = 0; d < static_cast<Index>(t.domains.size()); ++d) {
    const DomainTexel& domain = t.domains[d];
    of.assign(1, {domain.particle, Vec3::Zero()});
    const auto add = [&](Index e, const Vec3& area) {
      const Index i = t.domains[e].particle;
      const Vec3 g = domain.inverse_volume * area;
      of.front().second -= g;
      const auto known = std::ranges::find(of, i, &std::pair<Index, Vec3>::first);
      if (known != of.end()) {
        known->second += g;
      } else {
        of.emplace_back(i, g);
      }
    };
    for_each_area(t, d, [&](Index e, const Vec3& area) { add(e, area); });
    for (const LinkTexel& link : t.links_of(d)) diagonal[domain.particle].diagonal().array() += link.stiffness;
    const double volume = 1.0 / domain.inverse_volume;
    std::array<std::array<Mat3, 3>, 3> stress;  // of H = e_a e_b^T
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        const Mat3 H = Vec3::Unit(a) * Vec3::Unit(b).transpose();
        stress[a][b] = volume * (stress_near_rest<double>(t.options.strain_energy, t.energy_of(d), H) -
                                 domain.spread_stiffness * H);
      }
    }
    for (const auto& [i, g] : of) {
      for (int a = 0; a < 3; ++a) {
        diagonal[i].col(a) += (g[0] * stress[a][0] + g[1] * stress[a][1] + g[2] * stress[a][2]) * g;
      }
    }
  }
  return diagonal;
}

Multigrid::Multigrid(const TopologyTextures& topology, std::span<const std::uint8_t> fixed,
                     std::span<const Mat3> diagonal, Tangent& tangent)
    : topology_(topology), tangent_(tangent), free_(Vector::Ones(3 * topology.particle_count)), diagonal_(diagonal) {
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if ((fixed[i] >> axis & 1) != 0) free_[3 * static_cast<Eigen::Index>(i) + axis] = 0.0;
    }
  }
  turned_inverse_.assign(diagonal_.size(), padded(Mat3::Zero()));
  double volume = 0.0;
  for (const DomainTexel& domain : topology.domains) volume += 1.0 / domain.inverse_volume;
  const double spacing = std::cbrt(volume / static_cast<double>(topology.particle_count));
  GridShape shape = GridShape::over(topology.rest, finest_cells * spacing);
  while (true) {
    Coarse coarse{.level = GridLevel(topology, fixed, shape), .finer = {}, .stiffness = {}, .b = {}, .x = {}, .r = {}};
    if (coarse_.empty()) {
      for (const Vec3& rest : topology.rest) coarse.finer.push_back(coarse.level.place_of(rest));
    } else {
      const GridLevel& finer = coarse_.back().level;
      for (Index node = 0; node < finer.nodes(); ++node) {
        coarse.finer.push_back(coarse.level.place_of(finer.node_place(node)));
      }
    }
    coarse.b.resize(static_cast<std::size_t>(coarse.level.nodes()));
    coarse.x = coarse.r = coarse.b;
    const bool last = coarse.level.nodes() <= few_nodes || shape.cells == std::array<Index, 3>{1, 1, 1};
    if (!last) coarse.stiffness = coarse.level.empty_stiffness();
    coarse_.push_back(std::move(coarse));
    if (last) break;
    shape = shape.coarser();
  }
  PaddedVectors* const own[] = {&padded_free_, &strongest_, &of_r_, &of_z_, &image_, &residual_, &scaled_};
  for (PaddedVectors* vectors : own) vectors->assign(diagonal_.size(), Eigen::Vector4f::Zero());
  double sum = 0.0;
  for (std::size_t i = 0; i < diagonal_.size(); ++i) {
    padded_free_[i].head<3>() = free_.segment<3>(3 * static_cast<Eigen::Index>(i)).cast<float>();
    sum += diagonal_[i].trace();
  }
  typical_stiffness_ = sum / static_cast<double>(diagonal_.size());
}

bool Multigrid::begin(RestTerms terms) {
  terms_ = terms;
  evaluations_ = 0;
  const bool has_terms = std::ranges::any_of(of_terms_, [](const Mat3& block) { return !block.isZero(0.0); });
  if (!of_terms_.empty()) {
    for (Coarse& coarse : coarse_) coarse.level.remove_terms();
    of_terms_.clear();
  }
  std::uint32_t bits = 1;
  for (std::size_t i = 0; i < strongest_.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      bits = bits * 1664525u + 1013904223u;
      strongest_[i][axis] = padded_free_[i][axis] * static_cast<float>(static_cast<double>(bits) / 4294967296.0 - 0.5);
    }
  }
  return has_terms;
}

bool Multigrid::follow_terms() {
  std::vector<Mat3> now(terms_.empty() ? 0 : diagonal_.size(), Mat3::Zero());
  for (const RestTerm* term : terms_) term->add_diagonal(now);
  of_terms_.resize(now.size(), Mat3::Zero());
  double size = 0.0, change = 0.0;
  bool lacks = false;  // a stiffness: corrections would overshoot there
  for (std::size_t i = 0; i < now.size(); ++i) {
    size += now[i].norm();
    change += (now[i] - of_terms_[i]).norm();
    lacks |= now[i].trace() > diagonal_[i].trace() + 2.0 * of_terms_[i].trace();
  }
  if (!lacks && change <= little_change_of_terms * size) return false;
  of_terms_ = std::move(now);
  for (Coarse& coarse : coarse_) coarse.level.add_terms(topology_, of_terms_);
  return true;
}

void Multigrid::turn(std::span<const Mat3> gradients) {
  std::vector<Mat3> sums(turned_inverse_.size(), Mat3::Zero());  // of the F of a particle's domains
  for (std::size_t d = 0; d < gradients.size(); ++d) {
    sums[topology_.domains[d].particle] += Mat3::Identity() + gradients[d];
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const Mat3 R = polar_rotation(sums[i]);
    Mat3 block = R * diagonal_[i] * R.transpose();
    if (!of_terms_.empty()) block += of_terms_[i];                         // which do not turn with the body
    if (!block.isZero(0.0)) turned_inverse_[i] = padded(block.inverse());  // zero where cells were removed
  }
  for (Coarse& coarse : coarse_) {
    if (coarse.stiffness.rows() > 0) coarse.level.assemble(gradients, coarse.stiffness);
  }
  direct_.compute(coarse_.back().level.dense_stiffness(gradients));
}

const GridLevel& Multigrid::finest_of(Index most_nodes) const {
  const auto fits = [&](const Coarse& coarse) { return coarse.level.nodes() <= most_nodes; };
  const auto found = std::ranges::find_if(coarse_, fits);
  return found == coarse_.end() ? coarse_.back().level : found->level;
}

void Multigrid::apply(const Vector& d, Vector& result) {
  tangent_.apply(d, result);
  for (const RestTerm* term : terms_) term->add_product(d, result);
  result.array() *= free_.array();
  ++evaluations_;
}

void Multigrid::apply(const PaddedVectors& d, PaddedVectors& result) {
  tangent_.apply(d, result);
  if (!terms_.empty()) {
    copy(d, of_d_);
    of_image_.setZero(of_d_.size());
    for (const RestTerm* term : terms_) term->add_product(of_d_, of_image_);
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i].head<3>() += of_image_.segment<3>(3 * static_cast<Eigen::Index>(i)).cast<float>();
    }
  }
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i].array() *= padded_free_[i].array();
  }
  ++evaluations_;
}

void Multigrid::scale(const PaddedVectors& r, PaddedVectors& z) const {
  for (std::size_t i = 0; i < r.size(); ++i) z[i] = product(turned_inverse_[i], r[i]).cwiseProduct(padded_free_[i]);
}

void Multigrid::estimate_largest(int steps) {
  for (int k = 0; k < steps; ++k) {
    apply(strongest_, image_);
    scale(image_, scaled_);
    const float norm = numbers_of(scaled_).norm();
    largest_ = norm / numbers_of(strongest_).norm();
    numbers_of(strongest_) = numbers_of(scaled_) / norm;
  }
  largest_ *= static_cast<float>(above_estimate);
}

void Multigrid::solve_coarsest() {
  Coarse& coarsest = coarse_.back();
  copy(coarsest.b, coarsest_);
  direct_.solveInPlace(coarsest_);
  for (std::size_t i = 0; i < coarsest.x.size(); ++i) {
    coarsest.x[i].head<3>() = coarsest_.segment<3>(3 * static_cast<Eigen::Index>(i)).cast<float>();
  }
}

void Multigrid::cycle(std::size_t level) {
  if (level + 1 == coarse_.size()) return solve_coarsest();
  Coarse &coarse = coarse_[level], &next = coarse_[level + 1];
  numbers_of(coarse.x).setZero();
  coarse.stiffness.rise(coarse.b, coarse.x, coarse.r);
  restrict_to(next.finer, coarse.r, next.b);
  cycle(level + 1);
  for (std::size_t i = 0; i < coarse.x.size(); ++i) coarse.x[i] += value_at(next.finer[i], next.x);
  coarse.stiffness.fall(coarse.b, coarse.x);
}

void Multigrid::solve(const Vector& r, Vector& z) {
  const DenormalsAreZero guard;
  const double largest = r.cwiseAbs().maxCoeff(), unit = typical_stiffness_ / largest;
  if (!(largest > 0.0)) {
    z.setZero(r.size());
    return;
  }
  for (std::size_t i = 0; i < of_r_.size(); ++i) {
    of_r_[i].head<3>() = (unit * r.segment<3>(3 * static_cast<Eigen::Index>(i))).cast<float>();
  }
  scale(of_r_, of_z_);
  const float damping = static_cast<float>(jump) / largest_;
  numbers_of(of_z_) *= damping;
  apply(of_z_, image_);
  numbers_of(residual_) = numbers_of(of_r_) - numbers_of(image_);
  const Coarse& coarse = coarse_.front();
  restrict_to(coarse.finer, residual_, coarse_.front().b);
  cycle(0);
  for (std::size_t i = 0; i < of_z_.size(); ++i) {
    of_z_[i] += value_at(coarse.finer[i], coarse.x).cwiseProduct(padded_free_[i]);
  }
  apply(of_z_, image_);
  numbers_of(residual_) = numbers_of(of_r_) - numbers_of(image_);
  scale(residual_, scaled_);
  numbers_of(of_z_) += damping * numbers_of(scaled_);
  copy(of_z_, z);
  z /= unit;
}

}  // namespace phymul
