// SPDX-License-Identifier: MIT
//
// Counts allocations of the whole test program, for what promises to make none.
#include "support/allocation_count.h"

#include <gtest/gtest.h>
#include <phymul/load_frame.h>
#include <phymul/phymul.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <new>

#include "support/bodies.h"

#if defined(_WIN32)
#include <malloc.h>
#endif

namespace {

std::atomic<std::size_t> allocations{0};
std::atomic<std::ptrdiff_t> live{0};
std::atomic<std::size_t> failing{0};  // the allocation that fails; 0: none

void* allocated(std::size_t size, std::size_t alignment) noexcept {
  if (++allocations == failing) return nullptr;
  ++live;
  const std::size_t rounded = (size + alignment - 1) / alignment * alignment;
#if defined(_WIN32)
  return _aligned_malloc(rounded, alignment);
#else
  return std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded);
#endif
}

void* counted(std::size_t size, std::size_t alignment) {
  void* memory = allocated(size, alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void freed(void* memory) noexcept {
  if (memory != nullptr) --live;
#if defined(_WIN32)
  _aligned_free(memory);
#else
  std::free(memory);
#endif
}

}  // namespace

// All forms: a sanitizer brings its own of each, and must not free what another one allocated. Not inlined: a compiler
// that sees new in one place and free in another takes them for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  return counted(size, alignof(std::max_align_t));
}
[[gnu::noinline]] void* operator new[](std::size_t size) {
  return counted(size, alignof(std::max_align_t));
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void* operator new[](std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocated(size, alignof(std::max_align_t));
}
[[gnu::noinline]] void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return allocated(size, alignof(std::max_align_t));
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocated(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void* operator new[](std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocated(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete[](void* memory) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete[](void* memory, std::size_t) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete[](void* memory, std::align_val_t) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete(void* memory, const std::nothrow_t&) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete[](void* memory, const std::nothrow_t&) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  freed(memory);
}
[[gnu::noinline]] void operator delete[](void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  freed(memory);
}

namespace phymul {

std::size_t allocation_count() {
  return allocations;
}

std::ptrdiff_t live_allocations() {
  return live;
}

FailingAllocation::FailingAllocation(std::size_t k) : last_(allocations + k) {
  failing = last_;
}

FailingAllocation::~FailingAllocation() {
  failing = 0;
}

bool FailingAllocation::has_failed() const {
  return allocations >= last_;
}

namespace {

TEST(AllocationCount, SeesAllocations) {
  const std::size_t before = allocation_count();
  void* const memory = ::operator new(800);  // by name: a compiler may leave out a new-expression
  EXPECT_GT(allocation_count(), before);
  ::operator delete(memory);
}

TEST(AllocationCount, EvaluatingASceneAllocatesNothing) {
  const Model model = make_block({1, 1, 1}, 4, 4, 4);
  Scene scene = Scene(model).gravity({0, 0, -9.81}).fix("x0");
  for (const LoadType type :
       {LoadType::translation, LoadType::rotation, LoadType::force, LoadType::pressure, LoadType::acceleration}) {
    scene.add({.type = type,
               .particles = model.group("z1"),
               .events = {{0.0, 0.0}, {0.5, 1.0}, {1.0, -1.0}},
               .direction = Vec3(0, 0, 1)});
  }
  LoadFrame frame;
  scene.prepare(frame);
  const std::size_t before = allocation_count();
  for (int k = 0; k < 100; ++k) scene.evaluate(0.013 * k, frame);
  EXPECT_EQ(allocation_count(), before);
}

Model small_cube(int cells) {
  return test::with_material(make_block({0.02, 0.02, 0.02}, cells, cells, cells));
}

TEST(AllocationCount, SteppingAllocatesNothingEvenWhenLoadsAreReplaced) {
  const Model model = small_cube(3);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  Load pull{.type = LoadType::translation,
            .particles = model.group("x1"),
            .events = {{0.0, 0.0}},
            .direction = Vec3(1, 0, 0)};
  scene.add(pull);
  Load push = pull;
  push.type = LoadType::force;
  scene.add(push);
  const auto solver = make_solver("reference", model, scene);
  const double dt = 0.5 * solver->stable_step();
  State state = solver->read();
  ASSERT_TRUE(solver->step(1, dt).ok());
  for (int k = 0; k < 10; ++k) {
    pull.events[0].value = 1e-5 * k;
    scene.replace(1, pull);
    const std::size_t before = allocation_count();
    const StepReport report = solver->step(3, dt);
    solver->read(state);
    EXPECT_EQ(allocation_count(), before);
    ASSERT_TRUE(report.ok()) << report.message();
  }
}

TEST(AllocationCount, JointsAllocateNothingInSteps) {
  const Model model = small_cube(4);
  for (const char* backend : {"reference", "cpu"}) {
    SCOPED_TRACE(backend);
    Scene scene(model);
    const ToolHandle tool = scene.add_tool({.shape = Sphere{0.001}, .pose = {.position = {0.01, 0.01, 0.04}}});
    scene.attach(model.group("z0"), World{}, {.stiffness = 1e5});
    const JointHandle rope = scene.attach(model.group("z1"), tool, {.stiffness = 1e4, .breaking_stress = 10.0});
    const auto solver = make_solver(backend, model, scene, {}, {.threads = 1});
    const double dt = 0.2 * solver->stable_step();
    ASSERT_TRUE(solver->step(1, dt).ok());
    const std::size_t before = allocation_count();
    for (int k = 0; k < 20; ++k) {
      tool.move_to({.position = {0.01, 0.01, 0.04 + 2e-4 * k}});
      rope.set_stiffness(1e4 + k, 1.0);
      ASSERT_TRUE(solver->step(4, dt).ok());
    }
    EXPECT_EQ(allocation_count(), before);
    EXPECT_GT(solver->joint_report(rope).broken, 0);
  }
}

/// From the first step after a reset on.
TEST(AllocationCount, DissipationAllocatesNothingInSteps) {
  Model model = make_block({0.02, 0.02, 0.02}, 4, 4, 4);
  set_material(model, {.young = 1e4,
                       .poisson = 0.3,
                       .density = 1000,
                       .retardation_time = 1e-3,
                       .relaxation_strength = 0.5,
                       .relaxation_time = 0.01});
  for (const char* backend : {"reference", "cpu"}) {
    SCOPED_TRACE(backend);
    const Scene scene(model);
    const auto solver = make_solver(backend, model, scene, {}, {.threads = 1});
    const double dt = 0.5 * solver->stable_step();
    for (int k = 0; k < 2; ++k) {
      solver->reset();
      const std::size_t before = allocation_count();
      for (int step = 0; step < 4; ++step) ASSERT_TRUE(solver->step(1, dt).ok());
      EXPECT_EQ(allocation_count(), before);
    }
  }
}

/// A tool moved along all three axes each millisecond.
TEST(AllocationCount, DrivingAGroupAllocatesNothing) {
  const Model model = small_cube(12);
  for (const char* backend : {"reference", "cpu"}) {
    SCOPED_TRACE(backend);
    Scene scene = Scene(model).fix("x0");
    for (int axis = 0; axis < 3; ++axis) {
      Load move{.type = LoadType::translation, .particles = model.group("x1")};
      move.axes.fill(Axis::free);
      move.axes[axis] = Axis::driven;
      move.direction = Vec3::Unit(axis);
      move.events = {{0.0, 0.0}, {1.0, 0.0}};
      scene.add(move);
    }
    const auto solver = make_solver(backend, model, scene, {}, {.threads = 2});
    const double dt = 0.5 * solver->stable_step();
    ASSERT_TRUE(solver->step(1, dt).ok());
    State state = solver->read();
    const std::size_t before = allocation_count();
    for (int k = 0; k < 10; ++k) {
      for (std::size_t row = 1; row <= 3; ++row) {
        const std::array<ValueEvent, 2> events{{{state.time, 1e-6 * k}, {state.time + 4 * dt, 1e-6 * (k + 1)}}};
        scene.set_events(row, events);
      }
      const StepReport report = solver->step(4, dt);
      solver->read(state);
      ASSERT_TRUE(report.ok()) << report.message();
    }
    EXPECT_EQ(allocation_count(), before);
  }
}

}  // namespace
}  // namespace phymul
