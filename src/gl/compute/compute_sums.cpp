// SPDX-License-Identifier: MIT
#include "compute_sums.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <utility>

namespace phymul::gl {
namespace {

constexpr int largest_group = 256, most_groups = 256;

}  // namespace

Kernel ComputeSums::compiled(ShaderRequest request, const char* pass, const char* what,
                             const ComputeState& state) const {
  request.files.insert(request.files.end(), {pass, "report/sum_kernel.glsl"});
  request.defines.emplace_back(what, 1);
  const auto group = std::bit_floor(static_cast<unsigned>(std::min(limits_.invocations, largest_group)));
  return passes_->placed(std::move(request), static_cast<int>(group), state);
}

Kernel& ComputeSums::energy_of_particles(const LoadKind& loads, const ComputeState& state) {
  for (ParticleEnergy& energy : energies_) {
    if (energy.loads == loads) return energy.kernel;
  }
  energies_.push_back(
      {loads, compiled(passes_->gathering(loads), "report/energy_pass.glsl", "ENERGY_OF_PARTICLES", state)});
  return energies_.back().kernel;
}

ComputeSums::Sums ComputeSums::total(Kernel& kernel, int rows, const ComputeState& state) const {
  // Each group leaves two of the rows that hold what was measured, of which there are as many as places.
  const int groups = std::clamp(kernel.groups_for(rows), 1, std::min(most_groups, passes_->tables().places() / 2));
  kernel.set("pair", state.current());
  kernel.set("source_count", rows);
  kernel.set("partial_place", state.spare_row());
  kernel.dispatch(groups);
  std::vector<Float4> partial(static_cast<std::size_t>(2 * groups));
  state.rows().read(state.spare_row(), 2 * groups, partial.data());
  Sums sums{};
  for (std::size_t k = 0; k < partial.size(); ++k) {
    for (std::size_t lane = 0; lane < 4; ++lane) sums[k % 2][lane] += static_cast<double>(partial[k][lane]);
  }
  return sums;
}

Energy ComputeSums::energy(const ComputeState& state, const ComputeLoads& loads, double dt) {
  const BodyKind& kind = passes_->tables().kind();
  passes_->evaluate(state);
  Kernel& own = energy_of_particles(loads.kind(), state);
  loads.place(own);
  own.set("dt", static_cast<float>(dt));
  const auto sum = total(own, kind.particles, state)[0];
  Energy energy{.elastic = sum[0], .kinetic = sum[1], .gravity = sum[2]};
  // Of terms that particles share, and which no particle's row can hold.
  const auto add = [&](Kernel& kernel, int rows, const ShaderFiles& files, const char* pass, const char* what) {
    if (rows == 0) return;
    if (!kernel) {
      ShaderRequest request{
          .files =
              joined({{"dialect/dialect_compute.glsl", "step/tables.glsl", "dialect/kernel_language.glsl"}, files}),
          .defines = {{"ENERGY", 1}}};
      passes_->tables().define(request);
      kernel = compiled(std::move(request), pass, what, state);
    }
    energy.elastic += total(kernel, rows, state)[0][0];
  };
  add(volumes_, kind.volumes, volume_kernel(), "step/volumes_pass.glsl", "ENERGY_OF_VOLUMES");
  add(domains_, kind.domains, energy_kernel(kind), "step/domains_pass.glsl", "ENERGY_OF_DOMAINS");
  return energy;
}

/// Rest places stand where loads do, which no momentum asks for.
void ComputeSums::compile_momenta(const VecList& rest, const ComputeState& state) {
  middle_ = Vec3::Zero();
  for (const Vec3& X : rest) middle_ += X / static_cast<double>(rest.size());
  std::vector<Float4> from_middle(static_cast<std::size_t>(passes_->tables().places()), Float4{});
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Eigen::Vector3f r = (rest[i] - middle_).cast<float>();
    from_middle[static_cast<std::size_t>(state.place_of()[i])] = {r.x(), r.y(), r.z(), 0.0f};
  }
  rest_ = StorageBuffer(static_cast<std::int64_t>(from_middle.size()), "the rest places", limits_);
  rest_.write(0, from_middle.data(), static_cast<std::int64_t>(16 * from_middle.size()));
  ShaderRequest request{.files = {"dialect/dialect_compute.glsl", "step/tables.glsl", "dialect/kernel_language.glsl"},
                        .defines = {}};
  passes_->tables().define(request);
  momenta_ = compiled(std::move(request), "report/momentum_pass.glsl", "MOMENTA", state);
}

Momentum ComputeSums::momentum(const ComputeState& state, const VecList& rest, const Vec3& about) {
  if (!momenta_) compile_momenta(rest, state);
  rest_.bind(loads_binding);
  const auto [linear, turning] = total(momenta_, static_cast<int>(rest.size()), state);
  Momentum momentum{{linear[0], linear[1], linear[2]}, {turning[0], turning[1], turning[2]}};
  momentum.angular += (middle_ - about).cross(momentum.linear);
  return momentum;
}

}  // namespace phymul::gl
