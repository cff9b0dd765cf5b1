// SPDX-License-Identifier: MIT
#include "fragment_sums.h"

#include <Eigen/Geometry>
#include <utility>

namespace phymul::gl {
namespace {

constexpr int rows_to_one = 16;

}  // namespace

FragmentSums::Terms::Terms(Pass writing, int row_count, int targets) : pass(std::move(writing)), rows(row_count) {
  for (int k = 0; k < targets; ++k) texels.push_back(Texture::target(rows, TexelFormat::rgba32f, "terms of a sum"));
  std::vector<Attachment> attachments;
  for (const Texture& texture : texels) attachments.push_back({&texture});
  target = Framebuffer(attachments);
  pass.set_rows(texels.front(), rows);
}

FragmentSums::Sum FragmentSums::total(const Texture& terms, int rows) {
  if (!added_)
    added_.emplace(*library_, ShaderRequest{.files = {"dialect/dialect_fragment.glsl", "report/sum_pass.glsl"},
                                            .defines = {{"ROWS_TO_ONE", rows_to_one}}});
  // Deleted below: sums are rare, and a driver keeps what a queued draw still needs.
  std::vector<Texture> levels;
  Framebuffer target;
  const Texture* source = &terms;
  levels.reserve(32);
  do {
    const int count = (rows + rows_to_one - 1) / rows_to_one;
    levels.push_back(Texture::target(count, TexelFormat::rgba32f, "a sum"));
    target = Framebuffer({{&levels.back()}});
    added_->input("terms", *source);
    added_->set("source_count", rows);
    added_->set_rows(levels.back(), count);
    added_->draw(target);
    source = &levels.back();
    rows = count;
  } while (rows > 1);
  Float4 sum{};
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  target.read(0, GL_RGBA, GL_FLOAT, sum.data());
  return {sum[0], sum[1], sum[2], sum[3]};
}

FragmentSums::Terms& FragmentSums::particle_energy(const LoadKind& loads) {
  for (ParticleEnergy& energy : particle_energies_) {
    if (energy.loads == loads) return energy.terms;
  }
  Pass pass(*library_, passes_->gathering(loads, "report/energy_pass.glsl"));
  passes_->tables().bind(pass);
  passes_->bind_terms(pass);
  particle_energies_.push_back({loads, Terms(std::move(pass), passes_->tables().kind().particles, 1)});
  return particle_energies_.back().terms;
}

/// Of terms that particles share, and which no particle's row can hold.
void FragmentSums::compile_shared_terms() {
  const BodyKind& kind = passes_->tables().kind();
  shared_.clear();  // of an attempt that failed half-way
  const auto add = [&](std::vector<std::string> files, int rows) {
    ShaderRequest request{
        .files = {"dialect/dialect_fragment.glsl", "step/tables.glsl", "dialect/kernel_language.glsl"},
        .defines = {{"ENERGY", 1}}};
    request.files.insert(request.files.end(), files.begin(), files.end());
    define_kernels(kind, request);
    Pass pass(*library_, std::move(request));
    passes_->tables().bind(pass);
    shared_.emplace_back(std::move(pass), rows, 1);
  };
  if (kind.volumes > 0) add(joined({volume_kernel(), {"step/volumes_pass.glsl"}}), kind.volumes);
  if (kind.domains > 0) {
    add(joined({energy_kernel(kind), {"step/domains_pass.glsl"}}), kind.domains);
  }
}

Energy FragmentSums::energy(const FragmentState& state, const FragmentLoads& loads, double dt) {
  if (particle_energies_.empty()) compile_shared_terms();
  passes_->evaluate(state);
  Terms& own = particle_energy(loads.kind());
  loads.bind(own.pass);
  own.pass.input("displacement", state.displacement());
  own.pass.input("velocity", state.velocity());
  own.pass.set("instant", 0);
  own.pass.set("gravity", loads.gravity(0));
  own.pass.set("dt", static_cast<float>(dt));
  own.pass.draw(own.target);
  const Sum sum = total(own.texels.front(), own.rows);
  Energy energy{.elastic = sum[0], .kinetic = sum[1], .gravity = sum[2]};
  for (Terms& terms : shared_) {
    terms.pass.input("displacement", state.displacement());
    terms.pass.draw(terms.target);
    energy.elastic += total(terms.texels.front(), terms.rows)[0];
  }
  return energy;
}

Momentum FragmentSums::momentum(const FragmentState& state, const VecList& rest, const Vec3& about) {
  if (!momentum_) {
    for (const Vec3& X : rest) middle_ += X / static_cast<double>(rest.size());
    std::vector<Float4> from_middle;
    for (const Vec3& X : rest) {
      const Eigen::Vector3f r = (X - middle_).cast<float>();
      from_middle.push_back({r.x(), r.y(), r.z(), 0.0f});
    }
    rest_ = Texture::table(std::span<const Float4>(from_middle), "rest places");
    Pass pass(*library_, {.files = {"dialect/dialect_fragment.glsl", "step/tables.glsl", "dialect/kernel_language.glsl",
                                    "report/momentum_pass.glsl"},
                          .defines = {}});
    passes_->tables().bind(pass);
    pass.input("rest", rest_);
    momentum_.emplace(std::move(pass), static_cast<int>(rest.size()), 2);
  }
  momentum_->pass.input("displacement", state.displacement());
  momentum_->pass.input("velocity", state.velocity());
  momentum_->pass.draw(momentum_->target);
  const Sum linear = total(momentum_->texels[0], momentum_->rows),
            turning = total(momentum_->texels[1], momentum_->rows);
  Momentum momentum{{linear[0], linear[1], linear[2]}, {turning[0], turning[1], turning[2]}};
  momentum.angular += (middle_ - about).cross(momentum.linear);
  return momentum;
}

}  // namespace phymul::gl
