// SPDX-License-Identifier: MIT
//
// A GL backend beside its float mirror, over the same tables and scene. On llvmpipe of Mesa 22 the two give the same
// bits; on another renderer they need not.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>

#include "bodies.h"
#include "gl/solver/device_solver.h"
#include "gl_fixture.h"
#include "mirror/mirror.h"

namespace phymul::test {

/// In 2-D a particle of a corner has too few neighbours for a base: it gets springs.
inline std::shared_ptr<const TopologyTextures> tables_of(const Model& model, TopologyOptions options) {
  options.on_sparse = SparseParticle::springs;
  return std::make_shared<const TopologyTextures>(build_topology(model, options));
}

/// Numbers below the least normal one of single precision as 0: a device may flush them where the processor does not.
inline State flushed(State state) {
  for (Vec3& v : state.velocity) v = (v.array().abs() < std::numeric_limits<float>::min()).select(0.0, v);
  return state;
}

/// Empty where the states are equal; else who differs, and how.
inline std::string difference(const State& a, const State& b) {
  if (a == b) return {};
  if (a.time != b.time) return "times " + std::to_string(a.time) + " and " + std::to_string(b.time);
  std::size_t differing = 0, first = a.position.size();
  for (std::size_t i = a.position.size(); i-- > 0;) {
    if (a.position[i] == b.position[i] && a.velocity[i] == b.velocity[i]) continue;
    ++differing;
    first = i;
  }
  if (differing == 0) return "tools or joints";
  std::array<char, 200> text{};
  const Vec3 dv = a.velocity[first] - b.velocity[first];
  std::snprintf(text.data(), text.size(),
                "%zu of %zu particles, first %zu: velocity %.9g %.9g %.9g, off by %.3g %.3g %.3g", differing,
                a.position.size(), first, a.velocity[first].x(), a.velocity[first].y(), a.velocity[first].z(), dv.x(),
                dv.y(), dv.z());
  return text.data();
}

/// Texels of a solver's buffer, row by row.
inline std::vector<Float4> texels_of(gl::Context& context, const ParticleBuffer& buffer) {
  std::vector<Float4> texels(static_cast<std::size_t>(buffer.width) * static_cast<std::size_t>(buffer.height));
  context.run([&] {
    GLuint framebuffer = 0;
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, buffer.texture, 0);
    glReadPixels(0, 0, buffer.width, buffer.height, GL_RGBA, GL_FLOAT, texels.data());
    glDeleteFramebuffers(1, &framebuffer);
  });
  return texels;
}

/// Whether shaders do what their text says, operation by operation. Mesa's llvmpipe does in version 22; in version 25
/// only outside functions, unless their numbers are precise too, which GLSL 3.3 has no word for.
inline bool keeps_to_the_text(const gl::ContextInfo& info) {
  const std::size_t mesa = info.version.find("Mesa ");
  return info.renderer.starts_with("llvmpipe") && mesa != std::string::npos &&
         std::atoi(info.version.c_str() + mesa + 5) <= 22;
}

class GlTwins {
 public:
  GlTwins(const std::shared_ptr<const TopologyTextures>& tables, const Scene& scene, SolverOptions options = {},
          GlBackend backend = GlBackend::fragment)
      : options_(std::move(options)) {
    options_.on_unstable = UnstableStep::allow;
    if (!options_.spectrum) options_.spectrum = estimate_spectrum(*tables, tables->rest);
    gl = std::make_unique<gl::DeviceSolver>(backend, tables, scene, options_);
    mirror = cpu::make_mirror_solver(tables, scene, options_,
                                     gl->enumerated() ? FloatLayout::enumerated : FloatLayout::table);
  }

  const SolverOptions& options() const { return options_; }
  bool same_bits_expected() const { return keeps_to_the_text(gl->context()->info()); }

  /// What the error of a sum over a body is a share of: where bits are the same the sum, else the largest that the run
  /// has seen. Terms are rounded as shares of themselves, and may cancel in a sum.
  double scale_of(double sum, double largest) const { return same_bits_expected() ? std::abs(sum) : largest; }

  void reset(const State& state) const {
    gl->reset(state);
    mirror->reset(state);
  }

  void expect_same_bits(const std::string& where) const {
    if (!same_bits_expected()) return;
    EXPECT_EQ(difference(flushed(gl->read()), flushed(mirror->read())), "") << where;
  }

  std::unique_ptr<gl::DeviceSolver> gl;
  std::unique_ptr<Solver> mirror;

 private:
  SolverOptions options_;
};

/// The device, its mirror and the double reference over one scene.
struct GlTrio {
  GlTrio(const std::shared_ptr<const TopologyTextures>& tables, const Scene& scene, const SolverOptions& options,
         GlBackend backend)
      : twins(tables, scene, options, backend), reference(make_solver("reference", tables, scene, twins.options())) {}
  void reset(const State& state) const {
    twins.reset(state);
    reference->reset(state);
  }
  void step(int steps, double dt, const std::string& where = "") const {
    for (Solver* const solver : {static_cast<Solver*>(twins.gl.get()), twins.mirror.get(), reference.get()}) {
      ASSERT_TRUE(is_ok(solver->step(steps, dt)));
    }
    twins.expect_same_bits(where.empty() ? "after " + std::to_string(steps) + " steps" : where);
  }
  double apart() const { return largest_distance(twins.gl->read().position, reference->read().position); }

  GlTwins twins;
  std::unique_ptr<Solver> reference;
};

class TwinsOnBothDevices : public OnBothDevices {
 protected:
  static GlTrio trio_of(const std::shared_ptr<const TopologyTextures>& tables, const Scene& scene,
                        const SolverOptions& options = {}) {
    return {tables, scene, options, GetParam()};
  }
  static GlTwins twins_of(const std::shared_ptr<const TopologyTextures>& tables, const Scene& scene,
                          SolverOptions options = {}) {
    return {tables, scene, std::move(options), GetParam()};
  }
};

/// A body off its rest place, and moving.
inline State random_state(const Model& model, double amount, double speed, std::uint32_t seed) {
  State state = displaced(model, amount, seed);
  std::mt19937 bits(seed + 1000);
  for (Vec3& v : state.velocity) v = speed * random_vector(bits, model.dimension);
  return state;
}

}  // namespace phymul::test
