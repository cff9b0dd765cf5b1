// SPDX-License-Identifier: MIT
#include "scaled_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/side_by_side.h"
#include "base/symmetric_modes.h"
#include "domain_forces.h"
#include "energy_density.h"
#include "topology/energies.h"

namespace phymul {

bool AveragedStiffness::is_all_of(const TopologyTextures& t) {
  return !t.domains.empty() && t.base_count == 0 && t.springs.empty() && t.volumes.empty() && t.walls.empty();
}

AveragedStiffness::AveragedStiffness(const TopologyTextures& topology) : topology_(topology) {
  particle_.reserve(topology.domains.size());
  for (const DomainTexel& domain : topology.domains) particle_.push_back(domain.particle);
}

void AveragedStiffness::apply(const Eigen::VectorXd& u, Eigen::VectorXd& result) {
  in_halves(static_cast<Index>(topology_.domains.size()), topology_.options.runner.get(),
            [&](int part, Index first, Index last) { apply(first, last, u, part == 0 ? result : other_); });
  result += other_;
}

/// The change of mean_stress (domain_forces.h) with u.
Mat3 AveragedStiffness::stress(Index d, const Eigen::VectorXd& u) const {
  const TopologyTextures& t = topology_;
  const DomainTexel& domain = t.domains[d];
  const Vec3 own = u.segment<3>(3 * domain.particle);
  Mat3 H = Mat3::Zero();
  for_each_area(t, d, [&](Index e, const Vec3& area) {
    const Vec3 difference = u.segment<3>(3 * particle_[e]) - own;
    // An outer product takes twice as long.
    for (int axis = 0; axis < 3; ++axis) H.col(axis) += difference * area[axis];
  });
  H *= domain.inverse_volume;
  const Mat3 P = stress_near_rest<double>(t.options.strain_energy, t.energy_of(d), H) - domain.spread_stiffness * H;
  return P;
}

void AveragedStiffness::apply(Index first, Index last, const Eigen::VectorXd& u, Eigen::VectorXd& result) const {
  const TopologyTextures& t = topology_;
  result.setZero(u.size());
  for (Index d = first; d < last; ++d) {
    const Mat3 Q = stress(d, u);
    const Index i = particle_[d];
    const Vec3 own = u.segment<3>(3 * i);
    Vec3 sum = Vec3::Zero();
    for (const LinkTexel& link : t.links_of(d)) {
      const Index j = particle_[d + link.offset];
      const Vec3 pull = Q * link.area;
      result.segment<3>(3 * j) += pull;
      sum += pull + link.stiffness * (u.segment<3>(3 * j) - own);
    }
    for (const SurfaceLinkTexel& link : t.surface_links_of(d)) {
      const Vec3 pull = Q * link.area;
      result.segment<3>(3 * particle_[d + link.offset]) += pull;
      sum += pull;
    }
    result.segment<3>(3 * i) -= sum;
  }
}

namespace {

using Vector = Eigen::VectorXd;

constexpr int lanczos_steps = 400;

double rest_spacing(const TopologyTextures& topology) {
  double sum = 0.0;
  std::size_t count = 0;
  const auto add = [&](Index a, Index b) {
    sum += (topology.rest[a] - topology.rest[b]).norm();
    ++count;
  };
  for (Index i = 0; i < topology.particle_count; ++i) {
    const IndexTexel& at = topology.index[i];
    for (Index r = at.first_neighbour; r < at.first_neighbour + at.neighbour_count; ++r) add(i, topology.neighbours[r]);
  }
  for (const SpringTexel& spring : topology.springs) add(spring.end[0], spring.end[1]);
  for (const VolumeTexel& term : topology.volumes) add(term.vertex[0], term.vertex[1]);
  for (const WallTexel& wall : topology.walls) add(wall.vertex[0], wall.vertex[1]);
  if (count > 0) return sum / static_cast<double>(count);
  // Law::particle_averaged.
  for (Index d = 0; d < static_cast<Index>(topology.domains.size()); ++d) {
    for (const LinkTexel& link : topology.links_of(d)) {
      add(topology.domains[d].particle, topology.domains[d + link.offset].particle);
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

}  // namespace

ScaledStiffness::ScaledStiffness(const TopologyTextures& topology, std::span<const Vec3> position,
                                 std::span<const std::uint8_t> fixed)
    : topology_(topology),
      position_(position),
      spacing_(rest_spacing(topology)),
      scale_(Vector::Zero(3 * topology.particle_count)) {
  if (AveragedStiffness::is_all_of(topology) && std::ranges::equal(position, topology.rest)) {
    at_rest_.emplace(topology);
  } else {
    plus_.resize(position.size());
    minus_.resize(position.size());
  }
  for (Index i = 0; i < topology.particle_count; ++i) {
    for (int axis = 0; axis < topology.dimension; ++axis) {
      const bool free = fixed.empty() || (fixed[i] >> axis & 1) == 0;
      if (free && topology.mass[i] > 0.0) scale_[3 * i + axis] = 1.0 / std::sqrt(topology.mass[i]);
    }
  }
}

Vector ScaledStiffness::start_vector() const {
  std::mt19937 bits(20071);  // its bits alone are the same everywhere
  Vector q(scale_.size());
  for (Eigen::Index k = 0; k < q.size(); ++k) q[k] = static_cast<double>(bits()) / 4294967296.0 - 0.5;
  q = (scale_.array() > 0).select(q, 0.0);
  const double length = q.norm();
  return length > 0.0 ? Vector(q / length) : q;
}

void ScaledStiffness::apply(const Vector& q, Vector& result) {
  const Vector direction = scale_.cwiseProduct(q);
  if (at_rest_) {
    at_rest_->apply(direction, result);
    result.array() *= scale_.array();
  } else {
    apply_differences(direction, result);
  }
}

void ScaledStiffness::apply_differences(const Vector& direction, Vector& result) {
  const double largest = direction.cwiseAbs().maxCoeff();
  result.setZero(direction.size());
  if (largest == 0.0) return;
  // Truncation falls as step^2, rounding grows as 1/step: 1e-4 of the spacing keeps both near 1e-8.
  const double step = 1e-4 * spacing_ / largest;
  side_by_side(
      topology_.particle_count, topology_.options.runner.get(), [&] { force_at(direction, step, plus_); },
      [&] { force_at(direction, -step, minus_); });
  for (Index i = 0; i < topology_.particle_count; ++i) {
    const Vec3 stiffness = (minus_.force[i] - plus_.force[i]) / (2.0 * step);
    result.segment<3>(3 * i) = scale_.segment<3>(3 * i).cwiseProduct(stiffness);
  }
}

void ScaledStiffness::force_at(const Vector& direction, double step, Side& side) const {
  for (Index i = 0; i < topology_.particle_count; ++i) {
    side.moved[i] = position_[i] + step * direction.segment<3>(3 * i);
  }
  elastic_forces(topology_, side.moved, side.force);
}

Lanczos lanczos(ScaledStiffness& A, const Vector& start) {
  Lanczos found;
  Vector q = start, before = Vector::Zero(q.size()), image(q.size());
  for (int step = 0; step < lanczos_steps; ++step) {
    A.apply(q, image);
    found.diagonal.push_back(q.dot(image));
    image -= found.diagonal.back() * q;
    if (step > 0) image -= found.off.back() * before;
    const double beta = image.norm();
    if (!std::isfinite(beta)) {
      found.spectrum = {.largest = std::numeric_limits<double>::infinity()};
      break;
    }
    const bool look = step % 5 == 4 || step + 1 == lanczos_steps || beta == 0.0;
    if (look) {
      const SymmetricModes ritz = tridiagonal_modes(found.diagonal, found.off);
      const Vector& values = ritz.values;
      const Eigen::Index highest = values.size() - 1;
      const Eigen::Index top = std::abs(values[0]) > std::abs(values[highest]) ? 0 : highest;
      found.spectrum.largest = std::abs(values[top]);
      found.spectrum.most_negative = values[0];
      found.top = ritz.vectors.col(top);
      // A negative end must settle as well. Where none shows, waiting for one would cost a body at rest thrice the
      // steps.
      const auto last = ritz.vectors.row(highest);
      const bool grows = values[0] < -rigid_motion * found.spectrum.largest;
      const double residual = beta * std::max(std::abs(last[top]), grows ? std::abs(last[0]) : 0.0);
      if (residual <= ritz_accuracy * found.spectrum.largest) break;
    }
    found.off.push_back(beta);
    before.swap(q);
    q = image / beta;
  }
  if (found.spectrum.most_negative > -rigid_motion * found.spectrum.largest) found.spectrum.most_negative = 0.0;
  return found;
}

Vector fastest_vibration(ScaledStiffness& A, const Vector& start, const Lanczos& found) {
  Vector q = start, before = Vector::Zero(q.size()), image(q.size()), sum = found.top[0] * q;
  for (Eigen::Index step = 1; step < found.top.size(); ++step) {
    A.apply(q, image);
    image -= found.diagonal[step - 1] * q;
    if (step > 1) image -= found.off[step - 2] * before;
    before.swap(q);
    q = image / found.off[step - 1];
    sum += found.top[step] * q;
  }
  return sum.normalized();
}

const TopologyTextures& ScaledTables::of(const TopologyTextures& topology, std::span<const double> factors) {
  if (factors.empty()) return topology;
  const bool same_body = scaled_ && scaled_->edits == topology.edits;
  if (same_body && std::ranges::equal(factors, factors_)) return *scaled_;
  if (!same_body) scaled_ = topology;
  const std::size_t moduli = kind_of(topology.options.strain_energy).moduli;
  for (std::size_t d = 0; d < topology.domains.size(); ++d) {
    const DomainTexel& own = topology.domains[d];
    DomainTexel& domain = scaled_->domains[d];
    // Tables of a model that was given more materials since have rows that the scene does not know.
    const auto material = static_cast<std::size_t>(own.material);
    const double factor = material < factors.size() ? factors[material] : 1.0;
    domain.spread_stiffness = factor * own.spread_stiffness;
    for (std::size_t k = 0; k < moduli; ++k) {
      scaled_->energies[own.energy][k] = factor * topology.energies[own.energy][k];
    }
    if (!topology.dissipation.empty()) {
      scaled_->dissipation[d].mu = factor * topology.dissipation[d].mu;
      scaled_->dissipation[d].lambda = factor * topology.dissipation[d].lambda;
    }
    // Links join domains of one material, and domains that share their rows are of one.
    for (Index row = own.first_link; row < own.first_link + own.link_count; ++row) {
      scaled_->links[row].stiffness = factor * topology.links[row].stiffness;
    }
  }
  factors_.assign(factors.begin(), factors.end());
  return *scaled_;
}

}  // namespace phymul
