// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/denormals.h"
#include "cpu/simd/instruction_set.h"
#include "elastic/energy_density.h"
#include "packed_body.h"
#include "statics/rest_term.h"
#include "topology/energies.h"

namespace phymul {
namespace {

using namespace cpu;

class PackedTangent final : public Tangent {
 public:
  explicit PackedTangent(const TopologyTextures& topology)
      : topology_(topology), kernels_(simd::chosen_kernels()), body_(make_packed_body(topology, kernels_.lanes)) {
    const PackedAverages& averages = body_->averages;
    u_.assign(4 * (static_cast<std::size_t>(std::max(body_->places, averages.slots)) + 1), 0.0f);
    force_.assign(4 * static_cast<std::size_t>(averages.slots), 0.0f);
    stress_.assign(averages.stress_floats(), 0.0f);
    own_ = kind_of(topology_.options.strain_energy).constants;
    linearise({});
  }

  void linearise(std::span<const Mat3> gradients) override {
    at_rest_ = gradients.empty();
    const std::vector<Index>& domains = body_->averages.domain_of_place;
    if (at_rest_) {
      copy_columns(2, 2 + simd::constants_near_rest);
    } else {
      copy_columns(2 + own_, 2 + own_ + 9);
    }
    for (std::size_t place = 0; place < domains.size(); ++place) {
      if (domains[place] == none) continue;
      if (at_rest_) {
        put_stress_near_rest(place, domains[place]);
      } else {
        const Mat3& H = gradients[domains[place]];
        for (std::size_t k = 0; k < 9; ++k) constant(place, 2 + own_ + k) = static_cast<float>(H(k % 3, k / 3));
      }
    }
  }

  void apply(const Eigen::VectorXd& d, Eigen::VectorXd& result) override {
    result.resize(d.size());
    const double largest = d.cwiseAbs().maxCoeff();
    if (!(largest > 0.0) || !std::isfinite(largest)) {
      result.setZero();
      return;
    }
    for (std::size_t place = 0; place < body_->order.size(); ++place) {
      displacement(place).head<3>() = (d.segment<3>(3 * body_->order[place]) / largest).cast<float>();
    }
    find_forces();
    for (std::size_t place = 0; place < body_->order.size(); ++place) {
      result.segment<3>(3 * body_->order[place]) = -largest * force(place).head<3>().cast<double>();
    }
  }

  void apply(std::span<const Eigen::Vector4f> d, std::span<Eigen::Vector4f> result) override {
    for (std::size_t place = 0; place < body_->order.size(); ++place) displacement(place) = d[body_->order[place]];
    find_forces();
    for (std::size_t place = 0; place < body_->order.size(); ++place) result[body_->order[place]] = -force(place);
  }

 private:
  using Quad = Eigen::Map<Eigen::Vector4f, Eigen::Aligned16>;
  Quad displacement(std::size_t place) { return Quad(&u_[4 * body_->quad_of(place)]); }
  Quad force(std::size_t place) { return Quad(&force_[4 * body_->quad_of(place)]); }

  /// From displacements to forces.
  void find_forces() {
    const DenormalsAreZero guard;
    const PackedAverages& averages = body_->averages;
    averages.copy_displacements(bytes(u_));
    simd::Averaged job = averages.job(bytes(u_), bytes(stress_), bytes(force_));
    job.constants = constants_.data();
    const bool runs = !averages.runs.empty();
    const int slices = averages.slices();
    if (runs) kernels_.spread_displacements(job, 0, slices);
    const auto energy = static_cast<int>(topology_.options.strain_energy);
    const auto stresses =
        at_rest_ ? kernels_.averaged_near_rest[runs] : kernels_.averaged_tangents[runs][energy][body_->bounded];
    stresses(job, 0, slices);
    kernels_.averaged_forces[runs](job, 0, slices);
    averages.gather_forces(bytes(force_));
  }

  /// Of the constants of a place.
  float& constant(std::size_t place, std::size_t column) {
    const auto lanes = static_cast<std::size_t>(body_->lanes);
    return constants_[(place / lanes * columns_ + column) * lanes + place % lanes];
  }

  /// Constants of so many columns, the first `kept` of which are the body's.
  void copy_columns(std::size_t kept, std::size_t columns) {
    if (columns_ == columns) return;
    columns_ = columns;
    const auto lanes = static_cast<std::size_t>(body_->lanes);
    const std::size_t slices = body_->averages.constants.size() / ((2 + own_) * lanes);
    constants_.assign(slices * columns * lanes, 0.0f);
    for (std::size_t slice = 0; slice < slices; ++slice) {
      std::copy_n(&body_->averages.constants[slice * (2 + own_) * lanes], kept * lanes,
                  &constants_[slice * columns * lanes]);
    }
  }

  void put_stress_near_rest(std::size_t place, Index domain) {
    const EnergyConstants& p = topology_.energy_of(domain);
    const auto [mu, lambda] = lame_at_rest(p);
    constant(place, 2) = static_cast<float>(mu);
    constant(place, 3) = static_cast<float>(lambda);
    if (topology_.options.strain_energy != StrainEnergy::fibres) return;
    for (std::size_t k = 2; k < own_; ++k) constant(place, 2 + k) = static_cast<float>(p[k]);
  }

  const TopologyTextures& topology_;
  const simd::Kernels& kernels_;
  std::unique_ptr<const PackedBody> body_;
  bool at_rest_ = true;
  std::size_t own_ = 0, columns_ = 0;  // constants of the energy, and with those of the state
  Floats constants_, u_, force_, stress_;
};

}  // namespace

std::unique_ptr<Tangent> make_tangent(const TopologyTextures& topology) {
  return std::make_unique<PackedTangent>(topology);
}

}  // namespace phymul
