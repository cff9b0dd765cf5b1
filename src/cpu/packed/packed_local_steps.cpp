// SPDX-License-Identifier: MIT
#include "packed_local_steps.h"

#include <algorithm>
#include <cmath>

#include "packed_loads.h"
#include "statics/block_matrix.h"

namespace phymul::cpu {
namespace {

Eigen::VectorXf inverse_masses(const TopologyTextures& stiff) {
  Eigen::VectorXf result(4 * stiff.particle_count);
  for (Index i = 0; i < stiff.particle_count; ++i) {
    result.segment<4>(4 * i).setConstant(static_cast<float>(1.0 / stiff.mass[i]));
  }
  return result;
}

}  // namespace

PackedLocalSteps::PackedLocalSteps(const LocalSteps& steps, const PackedBody& body)
    : steps_(steps),
      stiffness_(steps.substeps.empty() ? nullptr : make_tangent(steps.stiff.tables)),
      still_(Eigen::VectorXf::Zero(4 * steps.stiff.tables.particle_count)),
      loop_(steps.substeps, inverse_masses(steps.stiff.tables),
            [this](const Eigen::VectorXf& w, Eigen::VectorXf& result) {
              stiffness_->apply(vectors_of(w), vectors_of(result));
            }),
      forces_(steps, [this](auto still, auto held, double dt, double factor,
                            auto sum) { run_loop(still, held, dt, factor, sum); }),
      x_(steps.stiff.particle.size()),
      acceleration_(x_.size()),
      fine_mass_(steps.fine.mass.begin(), steps.fine.mass.end()),
      fine_f_(fine_mass_.size()),
      fine_change_(fine_mass_.size()),
      fine_nodes_(steps.fine.nodes()) {
  const std::vector<std::size_t> place_of = places_of(body);
  for (const Index i : steps.particle) at_.push_back({body.quad_of(place_of[i]), place_of[i]});
}

void PackedLocalSteps::add_changes(const simd::Move& move, const ToolSet& tools, std::span<const double> factors,
                                   char* force) {
  auto* elastic = reinterpret_cast<float*>(force);
  for (std::size_t r = 0; r < at_.size(); ++r) {
    const bool held = tools.held_by_any(steps_.particle[r]);
    forces_.imposed()[r] = held ? 7 : move.fixed != nullptr ? move.fixed[at_[r].place] : 0;
  }
  if (!x_.empty()) add_substeps(move, factors, elastic);
  if (!fine_f_.empty()) add_fine_parts(move, elastic);
}

void PackedLocalSteps::add_substeps(const simd::Move& move, std::span<const double> factors, float* elastic) {
  const auto* u = reinterpret_cast<const float*>(move.u);
  const auto* load = reinterpret_cast<const float*>(move.load);
  for (std::size_t r = 0; r < x_.size(); ++r) {
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t at = 4 * at_[r].quad + a;
      x_[r][a] = steps_.rest[r][a] + static_cast<double>(u[at]);
      const double sum = static_cast<double>(elastic[at]) + (load != nullptr ? static_cast<double>(load[at]) : 0.0);
      acceleration_[r][a] = sum / steps_.mass[r] + static_cast<double>(move.gravity[a]);
    }
  }
  const std::span<const Vec3> change =
      forces_.changes(x_, acceleration_, static_cast<double>(move.dt), steps_.factor(factors));
  for (std::size_t r = 0; r < x_.size(); ++r) {
    for (std::size_t a = 0; a < 3; ++a) elastic[4 * at_[r].quad + a] += static_cast<float>(change[r][a]);
  }
}

void PackedLocalSteps::add_fine_parts(const simd::Move& move, float* elastic) {
  using Quad = Eigen::Vector4f;
  const auto* load = reinterpret_cast<const float*>(move.load);
  const Quad gravity(move.gravity[0], move.gravity[1], move.gravity[2], 0.0f);
  const std::span<const Place> at = std::span(at_).subspan(x_.size());
  const std::span<const Vec3> push = forces_.acting();
  for (std::size_t r = 0; r < at.size(); ++r) {
    Quad& f = fine_f_[r];
    f = Eigen::Map<const Quad>(elastic + 4 * at[r].quad) + fine_mass_[r] * gravity;
    if (load != nullptr) f += Eigen::Map<const Quad>(load + 4 * at[r].quad);
    if (!push.empty()) f.head<3>() += push[x_.size() + r].cast<float>();
    f[3] = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      if ((forces_.imposed()[x_.size() + r] >> axis & 1) != 0) f[axis] = 0.0f;
    }
  }
  steps_.fine.changes<Quad>(fine_f_, fine_change_, fine_nodes_);
  for (std::size_t r = 0; r < at.size(); ++r) Eigen::Map<Quad>(elastic + 4 * at[r].quad) += fine_change_[r];
}

void PackedLocalSteps::run_loop(std::span<const Vec3> still, std::span<const LocalForces::Held> held, double dt,
                                double factor, std::span<Vec3> sum) {
  double largest = 0.0;
  for (const Vec3& a : still) largest = std::max(largest, a.cwiseAbs().maxCoeff());
  // The step's own check names what is not a number.
  const bool moves = largest > 0.0 && std::isfinite(largest);
  if (moves) {
    for (std::size_t r = 0; r < still.size(); ++r) {
      still_.segment<3>(4 * static_cast<Eigen::Index>(r)) = (still[r] / largest).cast<float>();
    }
  }
  const Eigen::VectorXf* of_largest = moves ? &loop_.run(still_, dt, factor, held, 4) : nullptr;
  for (std::size_t r = 0; r < sum.size(); ++r) {
    sum[r] = moves ? Vec3(largest * of_largest->segment<3>(4 * static_cast<Eigen::Index>(r)).cast<double>())
                   : Vec3(Vec3::Zero());
  }
}

void PackedLocalSteps::keep_pushes(const simd::Move& move, const char* loads) {
  const auto* before = reinterpret_cast<const float*>(move.load);
  const auto* after = reinterpret_cast<const float*>(loads);
  const std::span<Vec3> pushes = forces_.pushes();
  for (std::size_t r = 0; r < at_.size(); ++r) {
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t at = 4 * at_[r].quad + a;
      const float push = after == nullptr ? 0.0f : after[at] - (before == nullptr ? 0.0f : before[at]);
      pushes[r][a] = static_cast<double>(push);
    }
  }
}

}  // namespace phymul::cpu
