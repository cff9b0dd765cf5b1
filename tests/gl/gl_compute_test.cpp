// SPDX-License-Identifier: MIT
//
// The backend "gl-compute" by itself: its buffer's rows that are nobody's, the driver's limits, what it
// tells of its steps and hands out.
#include "gl/compute/compute_device.h"
#include "gl/solver/body_kind.h"
#include "support/gl_twins.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

class GlComputeDevice : public OnCompute {
 protected:
  void set_up() override {
    context_ = gl::Context::open({.debug = true}, GlBackend::compute);
    context_->run([this] { limits_ = gl::ComputeLimits::of_context(); });
  }
  bool same_bits_expected() const { return context_->info().renderer.starts_with("llvmpipe"); }

  std::shared_ptr<gl::Context> context_;
  gl::ComputeLimits limits_;
};

SolverOptions options_of_tests() {
  return {.damping = {.factor = 0.99}, .on_unstable = UnstableStep::allow, .gl = {.debug = true}};
}

TEST_F(GlComputeDevice, HasTheBitsOfTheFragmentBackend) {
  for (const Variant& variant : all_variants()) {
    for (const Body& body :
         {Body{"block", make_block({0.03, 0.02, 0.02}, 3, 2, 2, 14)}, Body{"strip", make_strip(0.04, 0.02, 4, 2)}}) {
      SCOPED_TRACE(body.name + ", " + variant.name);
      const Model model = prepared(variant, body);
      Scene scene = Scene(model).fix("x0").gravity({0, -9.81, 0});
      const auto tables = tables_of(model, variant.options);
      SolverOptions options = options_of_tests();
      options.spectrum = estimate_spectrum(*tables, tables->rest);
      gl::DeviceSolver drawn(GlBackend::fragment, tables, scene, options);
      const State start = random_state(model, 0.05, 0.0, 3);
      const double dt = 0.2 * drawn.stable_step();
      drawn.reset(start);
      const StepReport expected = drawn.step(20, dt);  // some run away: the quadratic volume law
      gl::DeviceSolver dispatched(GlBackend::compute, tables, scene, options);
      dispatched.reset(start);
      const StepReport report = dispatched.step(20, dt);
      EXPECT_EQ(report.steps, expected.steps);
      if (same_bits_expected()) {
        EXPECT_EQ(difference(dispatched.read(), drawn.read()), "");
        EXPECT_EQ(report.residual, expected.residual);
      }
      EXPECT_LE(largest_distance(dispatched.read().position, drawn.read().position), 1e-5 * body_size(model));
    }
  }
}

/// A device over a body, in a context of the test's own.
struct OwnDevice {
  OwnDevice(const Model& model, const Scene& scene, const TopologyOptions& topology, const gl::ComputeLimits& limits) {
    const auto tables = tables_of(model, topology);
    slices = pack_slices(pack_floats(*tables), *tables);
    device =
        std::make_unique<gl::ComputeDevice>(slices, scene, no_tools, false, gl::ShaderLibrary("", is_es()), limits);
    dt = 0.2 * stable_step(estimate_spectrum(*tables, tables->rest), 1.0);
  }
  static bool is_es() { return gl::read_context_info().es; }
  void begin(int steps) const {
    std::vector<double> instants(1, 0.0);
    for (int k = 0; k < steps; ++k) instants.push_back(instants.back() + dt);
    device->begin_batch({.dt = dt, .largest_acceleration = 1e30, .runaway_speed = 1e30}, instants, no_tools);
  }
  State read(const Model& model) const {
    State state;
    device->read(model.rest, state);
    return state;
  }

  const FloatTools no_tools{gl::Device::most_steps};
  SliceTables slices;
  std::unique_ptr<gl::ComputeDevice> device;
  double dt = 0.0;
};

TEST_F(GlComputeDevice, NobodysPlacesAreUntouchedAndUnread) {
  const auto compare = [&](const Model& model, const TopologyOptions& topology) {
    Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
    context_->run([&] {
      const OwnDevice plain(model, scene, topology, limits_);
      const OwnDevice spoilt(model, scene, topology, limits_);
      const std::int64_t places = spoilt.slices.place_count(), particles = model.particle_count();
      ASSERT_GT(places, particles) << "no place is nobody's";
      const State start = random_state(model, 0.05, 0.1, 9);
      for (const OwnDevice* own : {&plain, &spoilt}) own->device->write(model.rest, start);
      const std::vector<Float4> sentinels(static_cast<std::size_t>(places - particles), Float4{7e7f, 7e7f, 7e7f, 7e7f});
      const gl::StorageBuffer& rows = spoilt.device->state().rows();
      const auto tables_of_places = 2 * gl::ComputeState::pairs;
      glBindBuffer(GL_COPY_WRITE_BUFFER, rows.id());
      for (std::int64_t table = 0; table < tables_of_places; ++table) {
        glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(16 * (table * places + particles)),
                        static_cast<GLsizeiptr>(16 * sentinels.size()), sentinels.data());
      }
      glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
      for (const OwnDevice* own : {&plain, &spoilt}) {
        own->begin(5);
        own->device->run(5);
      }
      const gl::BatchReport a = plain.device->report(), b = spoilt.device->report();
      EXPECT_EQ(a.max_speed, b.max_speed);
      EXPECT_EQ(a.max_displacement, b.max_displacement);
      EXPECT_LT(b.max_displacement, 1e3);
      EXPECT_EQ(difference(plain.read(model), spoilt.read(model)), "");
      std::vector<Float4> found(sentinels.size());
      for (std::int64_t table = 0; table < tables_of_places; ++table) {
        rows.read(table * places + particles, places - particles, found.data());
        EXPECT_EQ(found, sentinels) << "table " << table;
      }
    });
  };
  compare(with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2)), {});
  compare(jittered_block(), {.volume_stiffness = 50.0});
}

TEST_F(GlComputeDevice, GroupsMayFormARectangle) {
  const Model model = make_block({0.05, 0.05, 0.05}, 7, 7, 7);
  Scene scene = Scene(model).gravity({0, 0, -9.81});
  gl::ComputeLimits narrow = limits_;
  narrow.groups_across = 3;
  context_->run([&] {
    const OwnDevice line(model, scene, {}, limits_);
    const OwnDevice rectangle(model, scene, {}, narrow);
    const State start = random_state(model, 0.05, 0.1, 9);
    for (const OwnDevice* own : {&line, &rectangle}) {
      own->device->write(model.rest, start);
      own->begin(3);
      own->device->run(3);
    }
    EXPECT_EQ(difference(line.read(model), rectangle.read(model)), "");
    EXPECT_GT(largest_distance(line.read(model).position, start.position), 0.0);
    EXPECT_EQ(line.device->report().max_force, rectangle.device->report().max_force);
  });
  narrow.groups_down = 1;
  EXPECT_TRUE(refuses([&] { context_->run([&] { OwnDevice(model, scene, {}, narrow); }); },
                      "is more than the 3 x 1 groups that this driver dispatches at a time"));
}

TEST_F(GlComputeDevice, MoreTurnsThanARendererTakesAreRefused) {
  const Model model = make_block({0.03, 0.02, 0.02}, 5, 4, 4, 26);
  const auto tables = tables_of(model, {.reaction = Reaction::shared, .bases = BaseSelection::all});
  const LoopTurns turns = pack_floats(*tables).turns;
  gl::ContextInfo info = context_->info();
  EXPECT_NO_THROW(gl::require_turns(info, turns));
  info.loop_turns = turns.own + turns.gathered - 1;
  EXPECT_TRUE(refuses([&] { gl::require_turns(info, turns); },
                      "expected at most " + std::to_string(info.loop_turns) + " turns of the loops of a shader"));
}

TEST_F(GlComputeDevice, BuffersBeyondTheDriversLimitAreRefusedWithSizes) {
  const Model model = make_block({0.05, 0.05, 0.05}, 7, 7, 7);
  const Scene scene(model);
  gl::ComputeLimits small = limits_;
  small.block_bytes = 1 << 16;
  EXPECT_TRUE(refuses([&] { context_->run([&] { OwnDevice(model, scene, {}, small); }); },
                      "MiB; a shader of this driver sees 1 MiB"));
}

/// What a failure or rest within a batch is answered by.
TEST_F(GlComputeDevice, StepsAreDoneAgainFromTheCheckpointBitForBit) {
  const Model model = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2));
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  context_->run([&] {
    const OwnDevice own(model, scene, {}, limits_);
    gl::ComputeDevice& device = *own.device;
    device.write(model.rest, random_state(model, 0.05, 0.1, 9));
    own.begin(9);
    device.run(4);
    const State after_four = own.read(model);
    const gl::BatchReport four = device.report();
    device.run(9);
    EXPECT_NE(difference(own.read(model), after_four), "");
    device.run(4);
    EXPECT_EQ(difference(own.read(model), after_four), "");
    const gl::BatchReport again = device.report();
    EXPECT_EQ(again.max_force, four.max_force);
    device.run(3);
    EXPECT_EQ(device.try_step(4).max_force, four.max_force);
    device.run(4);
    EXPECT_EQ(difference(own.read(model), after_four), "") << "try_step() moved the state";
  });
}

TEST_F(GlComputeDevice, TexturesHoldTheModelsOrder) {
  const Model model = make_block({0.03, 0.02, 0.02}, 5, 4, 3);
  const Scene scene(model);
  gl::DeviceSolver solver(GlBackend::compute, tables_of(model, {}), scene, options_of_tests());
  const auto compare = [&](const VecList& place) {
    const std::vector<Float4> texels = texels_of(*solver.context(), solver.position_buffer());
    for (std::size_t i = 0; i < place.size(); ++i) {
      const Vec3 u(texels[i][0], texels[i][1], texels[i][2]);
      EXPECT_LE((model.rest[i] + u - place[i]).norm(), 1e-6 * body_size(model)) << i;
    }
  };
  const State start = random_state(model, 0.1, 0.0, 8);
  solver.reset(start);
  compare(start.position);
  EXPECT_TRUE(is_ok(solver.step(3, 0.2 * solver.stable_step())));
  compare(solver.read().position);
}

TEST_F(GlComputeDevice, CulpritsAreRowsOfTheModel) {
  const Model model = make_block({0.03, 0.02, 0.02}, 5, 4, 3);
  const Scene scene(model);
  gl::DeviceSolver solver(GlBackend::compute, tables_of(model, {}), scene, options_of_tests());
  for (const Index culprit : {0, 17, 71}) {
    State start = rest_state(model);
    start.velocity[culprit] = Vec3(1e30, 0, 0);
    solver.reset(start);
    const StepReport report = solver.step(10, 0.2 * solver.stable_step());
    EXPECT_EQ(report.status, StepStatus::not_finite);
    EXPECT_EQ(report.particle, culprit);
  }
}

TEST_F(GlComputeDevice, ReportsOfManyGroupsAreThoseOfTheFragmentBackend) {
  const Model model = make_block({0.05, 0.05, 0.05}, 13, 13, 13);  // 2744 particles: two groups report
  Scene scene = Scene(model).gravity({0, 0, -9.81});
  const auto tables = tables_of(model, {.law = Law::springs});
  SolverOptions options = options_of_tests();
  options.spectrum = estimate_spectrum(*tables, tables->rest);
  gl::DeviceSolver a(GlBackend::fragment, tables, scene, options), b(GlBackend::compute, tables, scene, options);
  State start = random_state(model, 0.1, 0.2, 8);
  for (const bool fails : {false, true}) {
    if (fails) start.velocity[2000] = start.velocity[2600] = Vec3(1e30, 0, 0);
    a.reset(start);
    b.reset(start);
    const StepReport x = a.step(5, 0.2 * a.stable_step()), y = b.step(5, 0.2 * a.stable_step());
    EXPECT_EQ(x.status, fails ? StepStatus::not_finite : StepStatus::ok);
    EXPECT_EQ(x.status, y.status);
    EXPECT_EQ(x.particle, y.particle);
    EXPECT_EQ(x.steps, y.steps);
    if (!same_bits_expected()) continue;
    EXPECT_EQ(x.max_speed, y.max_speed);
    EXPECT_EQ(x.residual, y.residual);
    EXPECT_EQ(difference(a.read(), b.read()), "");
  }
}

TEST(GlComputeVersion, WhatIsTooOldIsNamedWithAWayOut) {
  const Environment dialect("PHYMUL_GL_DIALECT", "es"), version("MESA_GLES_VERSION_OVERRIDE", "3.0");
  const std::string why_not = why_unavailable("gl");
  if (!why_not.empty()) GTEST_SKIP() << "NOT TESTED: " << why_not;
  try {
    const auto context = gl::Context::open({}, GlBackend::compute);
    GTEST_SKIP() << "NOT TESTED: this driver cannot be made old: " << context->info().device();
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_TRUE(says(message, "no OpenGL 4.3 or OpenGL ES 3.1 context"));
    EXPECT_TRUE(says(message, "the backend \"gl\" needs OpenGL 3.3 or OpenGL ES 3.0 only"));
  }
  gl::ContextInfo old;
  old.major = 4;
  old.minor = 2;
  old.renderer = "Old Thing";
  EXPECT_TRUE(refuses([&] { gl::require_backend(old, GlBackend::compute); }, "got Old Thing, OpenGL 4.2",
                      "the backend \"gl\" runs there"));
  EXPECT_NO_THROW(gl::require_backend(old, GlBackend::fragment));
}

}  // namespace
}  // namespace phymul::test
