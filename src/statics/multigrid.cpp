// SPDX-License-Identifier: MIT
#include "multigrid.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "elastic/energy_density.h"
#include "elastic/mean_gradient.h"
#include "elastic/rotation.h"

namespace phymul {
namespace {

using Vector = Eigen::VectorXd;
/// Of a damped sweep over the particles, over the largest eigenvalue: below 2 it converges; a tenth more or less
/// hardly changes the number of evaluations.
constexpr double jump = 1.5;
constexpr int coarse_sweeps = 2;
/// A power iteration of a few steps ends below the largest eigenvalue, the more so the larger the body.
constexpr double above_estimate = 1.3;
constexpr double finest_cells = 1.75;  // of the finest grid, in mean spacings
constexpr double little_change_of_terms = 0.1;
constexpr Index few_nodes = 120;  // solved directly in a millisecond or so

void restrict_to(const std::vector<GridPlace>& finer, const Vector& from, Vector& to) {
  to.setZero();
  for (std::size_t i = 0; i < finer.size(); ++i) {
    const Vec3 value = from.segment<3>(3 * static_cast<Eigen::Index>(i));
    for (int a = 0; a < 8; ++a) to.segment<3>(3 * finer[i].node[a]) += finer[i].weight[a] * value;
  }
}

void add_from(const std::vector<GridPlace>& finer, const Vector& from, Vector& to) {
  for (std::size_t i = 0; i < finer.size(); ++i) {
    Vec3 value = Vec3::Zero();
    for (int a = 0; a < 8; ++a) value += finer[i].weight[a] * from.segment<3>(3 * finer[i].node[a]);
    to.segment<3>(3 * static_cast<Eigen::Index>(i)) += value;
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
        stress[a][b] = volume * (cpu::stress_near_rest<double>(t.options.strain_energy, domain.energy, H) -
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

Multigrid::Multigrid(const TopologyTextures& topology, std::span<const std::uint8_t> fixed, Tangent& tangent,
                     RestTerms terms)
    : topology_(topology), tangent_(tangent), terms_(terms), free_(Vector::Ones(3 * topology.particle_count)) {
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if ((fixed[i] >> axis & 1) != 0) free_[3 * static_cast<Eigen::Index>(i) + axis] = 0.0;
    }
  }
  diagonal_ = diagonal_at_rest(topology);
  turned_inverse_.resize(diagonal_.size());
  double volume = 0.0;
  for (const DomainTexel& domain : topology.domains) volume += 1.0 / domain.inverse_volume;
  const double spacing = std::cbrt(volume / static_cast<double>(topology.particle_count));
  GridShape shape = GridShape::over(topology.rest, finest_cells * spacing);
  while (true) {
    Coarse coarse{.level = GridLevel(topology, fixed, shape), .finer = {}, .b = {}, .x = {}, .r = {}};
    if (coarse_.empty()) {
      for (const Vec3& rest : topology.rest) coarse.finer.push_back(coarse.level.place_of(rest));
    } else {
      const GridLevel& finer = coarse_.back().level;
      for (Index node = 0; node < finer.nodes(); ++node) {
        coarse.finer.push_back(coarse.level.place_of(finer.node_place(node)));
      }
    }
    coarse.b = Vector::Zero(3 * coarse.level.nodes());
    coarse.x = coarse.r = coarse.b;
    const bool last = coarse.level.nodes() <= few_nodes || shape.cells == std::array<Index, 3>{1, 1, 1};
    coarse_.push_back(std::move(coarse));
    if (last) break;
    shape = shape.coarser();
  }
  direct_.analyse(coarse_.back().level.stiffness());
  strongest_.resize(free_.size());
  std::uint32_t bits = 1;
  for (double& value : strongest_)
    value = static_cast<double>(bits = bits * 1664525u + 1013904223u) / 4294967296.0 - 0.5;
  strongest_.array() *= free_.array();
}

bool Multigrid::follow_terms() {
  std::vector<Mat3> now(terms_.empty() ? 0 : diagonal_.size(), Mat3::Zero());
  for (const RestTerm* term : terms_) term->add_diagonal(now);
  double size = 0.0, change = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    size += now[i].norm();
    change += of_terms_.empty() ? now[i].norm() : (now[i] - of_terms_[i]).norm();
  }
  if (change <= little_change_of_terms * size) return false;
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
    const Mat3 R = rotation_of(sums[i]);
    Mat3 block = R * diagonal_[i] * R.transpose();
    if (!of_terms_.empty()) block += of_terms_[i];  // which do not turn with the body
    turned_inverse_[i] = block.inverse();
  }
  for (Coarse& coarse : coarse_) coarse.level.assemble(gradients);
  direct_.factorise(coarse_.back().level.stiffness());
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

void Multigrid::scale(const Vector& r, Vector& z) const {
  z.resize(r.size());
  for (std::size_t i = 0; i < turned_inverse_.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    z.segment<3>(at) = turned_inverse_[i] * r.segment<3>(at);
  }
  z.array() *= free_.array();
}

void Multigrid::estimate_largest(int steps) {
  Vector s;
  for (int k = 0; k < steps; ++k) {
    apply(strongest_, image_);
    scale(image_, s);
    largest_ = s.norm() / strongest_.norm();
    strongest_ = s / s.norm();
  }
  largest_ *= above_estimate;
}

void Multigrid::cycle(std::size_t level) {
  Coarse& coarse = coarse_[level];
  if (level + 1 == coarse_.size()) {
    direct_.solve(coarse.b, coarse.x);
    return;
  }
  Coarse& next = coarse_[level + 1];
  const BlockMatrix& matrix = coarse.level.stiffness();
  coarse.x.setZero();
  for (int k = 0; k < coarse_sweeps; ++k) matrix.smooth(coarse.b, true, coarse.x);
  matrix.residual(coarse.b, coarse.x, coarse.r);
  restrict_to(next.finer, coarse.r, next.b);
  cycle(level + 1);
  add_from(next.finer, next.x, coarse.x);
  for (int k = 0; k < coarse_sweeps; ++k) matrix.smooth(coarse.b, false, coarse.x);
}

void Multigrid::solve(const Vector& r, Vector& z) {
  scale(r, z);
  z *= jump / largest_;
  apply(z, image_);
  residual_ = r - image_;
  Coarse& coarse = coarse_.front();
  restrict_to(coarse.finer, residual_, coarse.b);
  cycle(0);
  correction_.setZero(z.size());
  add_from(coarse.finer, coarse.x, correction_);
  z += free_.cwiseProduct(correction_);
  apply(z, image_);
  residual_ = r - image_;
  scale(residual_, scaled_);
  z += jump / largest_ * scaled_;
}

}  // namespace phymul
