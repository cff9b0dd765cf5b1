// SPDX-License-Identifier: MIT
//
// Static experiments on bodies: what a testing machine or a beam table would measure. Shared by tests and benches. How
// fast a body whose reaction takes no energy into account grows by itself: predicted by its eigenvalues, and measured
// by running it.
#pragma once

#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "dense_operator.h"

namespace phymul::test {

/// Answers the static problem f(x) + load = 0 on free coordinates by Newton's method; each linear system by conjugate
/// gradients, K v by a difference of forces along v. For conservative bodies near a stable rest.
class StaticSolve {
 public:
  StaticSolve(const TopologyTextures& topology, std::vector<std::uint8_t> fixed, VecList load)
      : topology_(topology),
        fixed_(std::move(fixed)),
        load_(std::move(load)),
        moved_(load_.size()),
        force_(load_.size()),
        base_(load_.size()) {}

  /// `x` holds the imposed coordinates already. Returns the number of force evaluations.
  int run(VecList& x, double tolerance = 1e-6, int newton_steps = 20) {
    evaluations_ = 0;
    double first = 0.0;
    for (int step = 0; step < newton_steps; ++step) {
      VecList residual = net_force(x);
      const double size = std::sqrt(dot(residual, residual));
      if (step == 0) first = size;
      if (size <= tolerance * first || size == 0.0) break;
      const VecList dx = conjugate_gradients(x, residual, std::max(0.1 * tolerance * first / size, 1e-8));
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += dx[i];
    }
    return evaluations_;
  }

  /// One linear step from x, without iteration: the small-strain answer.
  VecList linear(const VecList& x, double tolerance = 1e-6) { return conjugate_gradients(x, net_force(x), tolerance); }

 private:
  VecList net_force(const VecList& x) {
    VecList f(x.size());
    elastic_forces(topology_, x, f);
    ++evaluations_;
    for (std::size_t i = 0; i < f.size(); ++i) f[i] += load_[i];
    return masked(std::move(f));
  }

  VecList masked(VecList f) const {
    for (std::size_t i = 0; i < f.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        if (fixed_[i] >> axis & 1) f[i][axis] = 0.0;
      }
    }
    return f;
  }

  VecList stiffness_times(const VecList& x, const VecList& v) {
    double largest = 0.0;
    for (const Vec3& p : v) largest = std::max(largest, p.norm());
    if (spacing_ == 0.0) spacing_ = spacing();
    const double step = 1e-5 * spacing_ / largest;
    for (std::size_t i = 0; i < x.size(); ++i) moved_[i] = x[i] + step * v[i];
    elastic_forces(topology_, moved_, force_);
    for (std::size_t i = 0; i < x.size(); ++i) moved_[i] = x[i] - step * v[i];
    elastic_forces(topology_, moved_, base_);
    evaluations_ += 2;
    VecList result(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) result[i] = (base_[i] - force_[i]) / (2.0 * step);
    return masked(std::move(result));
  }

  double spacing() const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < topology_.rest.size(); ++i) {
      least = std::min(least, (topology_.rest[i] - topology_.rest[0]).norm());
    }
    return least;
  }

  VecList conjugate_gradients(const VecList& x, VecList residual, double tolerance) {
    VecList solution(x.size(), Vec3::Zero()), direction = residual;
    double rr = dot(residual, residual);
    const double target = rr * tolerance * tolerance;
    for (int k = 0; k < 20000 && rr > target; ++k) {
      const VecList image = stiffness_times(x, direction);
      const double step = rr / dot(direction, image);
      for (std::size_t i = 0; i < x.size(); ++i) {
        solution[i] += step * direction[i];
        residual[i] -= step * image[i];
      }
      const double next = dot(residual, residual);
      for (std::size_t i = 0; i < x.size(); ++i) direction[i] = residual[i] + next / rr * direction[i];
      rr = next;
    }
    return solution;
  }

  static double dot(const VecList& a, const VecList& b) {
    double total = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) total += a[i].dot(b[i]);
    return total;
  }

  const TopologyTextures& topology_;
  std::vector<std::uint8_t> fixed_;
  VecList load_, moved_, force_, base_;
  double spacing_ = 0.0;
  int evaluations_ = 0;
};

struct Moduli {
  double young = 0.0;
  double poisson = 0.0;
};

/// Stretches a block made with groups x0 ... z1 by `strain` along x between frictionless plates; what force and
/// narrowing say of its material. The sides y0, z0 slide in their planes.
inline Moduli stretch_block(const Model& model, const TopologyTextures& topology, double strain) {
  const auto n = model.rest.size();
  std::vector<std::uint8_t> fixed(n, 0);
  VecList x = model.rest;
  Vec3 size = Vec3::Zero();
  for (const Vec3& p : model.rest) size = size.cwiseMax(p);
  for (Vec3& p : x) p.x() *= 1.0 + strain;
  for (Index i : model.group("x0")) fixed[i] |= 1;
  for (Index i : model.group("x1")) fixed[i] |= 1;
  for (Index i : model.group("y0")) fixed[i] |= 2;
  for (Index i : model.group("z0")) fixed[i] |= 4;
  StaticSolve(topology, fixed, VecList(n, Vec3::Zero())).run(x);

  VecList force(n);
  elastic_forces(topology, x, force);
  double pull = 0.0, narrowing = 0.0;
  for (Index i : model.group("x1")) pull -= force[i].x();
  const auto mean_move = [&](const char* group, int axis) {
    double total = 0.0;
    const std::vector<Index> members = model.group(group);
    for (Index i : members) total += x[i][axis] - model.rest[i][axis];
    return total / static_cast<double>(members.size());
  };
  narrowing = -0.5 * (mean_move("y1", 1) / size.y() + mean_move("z1", 2) / size.z());
  return {pull / (size.y() * size.z()) / strain, narrowing / strain};
}

enum class Root {
  clamped,  ///< every particle of the root face held: stiffer than beam theory by the narrowing it prevents
  beam      ///< held along the beam only, its shear as a load: what Timoshenko's theory assumes
};

/// Deflection of a cantilever L x H x H under a small weight over Timoshenko's
///   q L^4 / (8 E I) + q L^2 / (2 kappa G A), kappa = 10 (1 + nu) / (12 + 11 nu)   (Cowper 1966).
/// `model` is a block with groups x0, x1 along x; `material` what its tables were built for.
inline double cantilever_ratio(const Model& model, const TopologyTextures& topology, const Material& material,
                               Root root) {
  const auto n = model.rest.size();
  Vec3 size = Vec3::Zero();
  for (const Vec3& p : model.rest) size = size.cwiseMax(p);
  const double length = size.x(), side = size.z(), area = size.y() * size.z();
  const double inertia = size.y() * side * side * side / 12.0;
  const double g = 1e-3;  // m/s^2; the answer is linear in it
  const double q = material.density * g * area;
  const double shear = material.young / (2.0 * (1.0 + material.poisson));
  const double cowper = 10.0 * (1.0 + material.poisson) / (12.0 + 11.0 * material.poisson);
  const double expected =
      q * std::pow(length, 4) / (8.0 * material.young * inertia) + q * length * length / (2.0 * cowper * shear * area);

  std::vector<std::uint8_t> fixed(n, 0);
  VecList load(n, Vec3::Zero());
  double weight = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    load[i].z() = -topology.mass[i] * g;
    weight += topology.mass[i] * g;
  }
  const std::vector<Index> root_face = model.group("x0");
  double root_mass = 0.0;
  for (Index i : root_face) root_mass += topology.mass[i];
  Index centre = root_face.front();
  for (Index i : root_face) {
    fixed[i] = root == Root::clamped ? 7 : 1;
    if (root == Root::beam) load[i].z() += weight * topology.mass[i] / root_mass;
    const Vec3 middle(0, size.y() / 2, size.z() / 2);
    if ((model.rest[i] - middle).norm() < (model.rest[centre] - middle).norm()) centre = i;
  }
  if (root == Root::beam) {
    // The load is in balance; these hold the body in place and carry nothing.
    fixed[centre] = 7;
    for (Index i : root_face) {
      if (i != centre && std::abs(model.rest[i].y() - model.rest[centre].y()) < 1e-6 * side) fixed[i] |= 2;
    }
  }
  const VecList u = StaticSolve(topology, fixed, load).linear(model.rest);
  const auto mean_drop = [&](const std::vector<Index>& face) {
    double total = 0.0;
    for (Index i : face) total -= u[i].z();
    return total / static_cast<double>(face.size());
  };
  return (mean_drop(model.group("x1")) - mean_drop(root_face)) / expected;
}

/// The beam of the accuracy tables, n cells across, 4 n along.
inline Model cantilever(int n, const Material& material) {
  Model model = make_block({0.2, 0.05, 0.05}, 4 * n, n, n, 6);
  set_material(model, material);
  return model;
}

/// Tables with the energy of the averaged attractor and a stiffness of E times the spacing: a body that has no bulk
/// stiffness where neighbourhoods are symmetric.
inline TopologyTextures averaged_tables(Model model) {
  model.stiffness.assign(model.rest.size(), model.materials.front().young * mean_spacing(model));
  model.materials.clear();
  for (Cell& cell : model.cells) cell.material = -1;
  return build_topology(model, {.reaction = Reaction::averaged, .on_sparse = SparseParticle::free});
}

struct GrowthRate {
  double predicted = 0.0;  ///< 1/s
  double measured = 0.0;   ///< 1/s, of an undamped run; NaN where the body does not grow
  double frequency = 0.0;  ///< 1/s, angular frequency of the growing motion; 0: it grows without swinging
  double highest = 0.0;    ///< 1/s, highest angular frequency of the body
};

/// Below this share of the highest frequency a rate is the rounding of the eigenvalues: sqrt of 1e-8.
inline constexpr double least_growth = 1e-4;

inline State moving_in(const GrowingMode& mode, const Model& model, double amplitude) {
  State state = rest_state(model);
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    for (int axis = 0; axis < model.dimension; ++axis) {
      const std::complex<double> part = amplitude * mode.shape[static_cast<Eigen::Index>(3 * i) + axis];
      state.position[i][axis] += part.real();
      state.velocity[i][axis] = (mode.s * part).real();
    }
  }
  return state;
}

inline double amplitude_of(const GrowingMode& mode, const Model& model, const State& state) {
  Eigen::VectorXcd u(mode.shape.size());
  for (Eigen::Index k = 0; k < u.size(); ++k) {
    const auto i = static_cast<std::size_t>(k / 3);
    u[k] = state.position[i][k % 3] - model.rest[i][k % 3];
  }
  return std::abs((mode.picks * u)(0));
}

/// Starts in the fastest growing mode, small enough to stay linear, and lets it grow by e to the third.
inline GrowthRate growth_rate(const Model& model, std::shared_ptr<const TopologyTextures> topology) {
  const GrowingMode mode = fastest_growing_mode(*topology);
  GrowthRate rate{mode.s.real(), std::numeric_limits<double>::quiet_NaN(), 0.0, mode.highest_frequency};
  if (rate.predicted < least_growth * mode.highest_frequency) {
    rate.predicted = 0.0;
    return rate;
  }
  rate.frequency = std::abs(mode.s.imag());
  const Scene scene(model);
  const auto solver = make_solver("reference", std::move(topology), scene);
  const double dt = 0.1 / mode.highest_frequency;
  const int steps = std::max(20, static_cast<int>(3.0 / (rate.predicted * dt)));
  solver->start(moving_in(mode, model, 1e-6 * mean_spacing(model)), dt);
  const double before = amplitude_of(mode, model, solver->read());
  const StepReport report = solver->step(steps, dt);
  if (!report.ok()) return rate;
  rate.measured = std::log(amplitude_of(mode, model, solver->read()) / before) / report.time;
  return rate;
}

}  // namespace phymul::test
