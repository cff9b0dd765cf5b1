// SPDX-License-Identifier: MIT
//
// A simulator's host in small: a device's loop moves a tool and steps the tissue once a millisecond, pictures are made
// from copies in a thread of their own, a region gets softer while all goes on, and the last half second is undone.
// The hand is a formula here. docs/guide/hosting.md goes through it.
//   host [seconds]
#include <phymul/phymul.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <thread>

#include "ellipsoid_body.h"

namespace {

using namespace phymul;
using Clock = std::chrono::steady_clock;

constexpr double tick = 1e-3;  // s, of the device
constexpr Material organ_tissue{.young = 6e3, .poisson = 0.45, .density = 1060};
constexpr Material tumour{.young = 3e4, .poisson = 0.45, .density = 1060};

/// What pictures are made of. Only positions cross from one thread to the other, and by copy: a solver, its scene and
/// handles belong to the thread that steps.
class Frames {
 public:
  void give(const VecList& position) {
    const std::lock_guard lock(mutex_);
    position_ = position;
  }
  void take(VecList& position) {
    const std::lock_guard lock(mutex_);
    position = position_;
  }

 private:
  std::mutex mutex_;
  VecList position_;
};

Simulation make_tissue() {
  Model model = make_ellipsoid({.semi_axes = {0.08, 0.06, 0.04}, .organ_layers = 3});
  const auto near = [&](const Vec3& place, double reach) {
    std::vector<Index> rows;
    for (Index i = 0; i < model.particle_count(); ++i) {
      if ((model.rest[i] - place).norm() < reach) rows.push_back(i);
    }
    return rows;
  };
  model.add_group("ligament", near({-0.08, 0, 0}, 0.03));
  model.add_group("tumour", near({0.02, 0, 0.02}, 0.02));
  Simulation sim(std::move(model), {.material = organ_tissue,
                                    .materials = {{"tumour", tumour}},
                                    .backend = "cpu",
                                    .damping = {.rate = 20},  // 1/s
                                    .solver = {.threads = 1}});
  sim.scene().fix("ligament");
  return sim;
}

/// Goes down on the organ, up with what it holds, and down again.
Vec3 hand_at(double time) {
  const double way = time < 0.4 ? -0.025 * time / 0.4 : -0.025 + 0.015 * std::sin((time - 0.4) * 2.0);
  return {0.02, 0, 0.06 + way};
}

void draw_until(const std::atomic<bool>& over, Frames& frames, const Model& model, int& drawn) {
  const auto triangles = surface_triangles(model);
  VecList position, normal;
  while (!over) {
    frames.take(position);
    if (!position.empty()) {
      surface_normals(triangles, position, normal);  // and here triangles, positions and normals go to the screen
      ++drawn;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
  }
}

int run(double seconds) {
  Simulation tissue = make_tissue();
  const Model drawn_model = tissue.model();  // the thread that draws has a copy of its own
  const ToolHandle gripper =
      tissue.scene().add_tool({.shape = Sphere{0.008}, .pose = {.position = hand_at(0)}, .friction = 0.3});
  VirtualCoupling coupling({}, gripper.target_pose());
  tissue.keep_history(100);  // a state every 100 steps, at most 64 MB of them

  Frames frames;
  std::atomic<bool> over{false};
  int drawn = 0;
  std::thread pictures([&] { draw_until(over, frames, drawn_model, drawn); });
  const auto stop = [&] {
    over = true;
    pictures.join();
  };

  State state;
  double largest = 0.0;
  const int ticks = static_cast<int>(seconds / tick);
  auto due = Clock::now();
  for (int k = 0; k < ticks; ++k) {
    const double time = k * tick;
    const ToolPose hand{.position = hand_at(time), .velocity = (hand_at(time + tick) - hand_at(time)) / tick};
    gripper.move_to(coupling.follow(hand, tissue.force_on(gripper), tick));
    if (k == ticks / 3) gripper.grasp(0.003);
    if (k == 5 * ticks / 6) gripper.release();
    if (k == ticks / 2) tissue.scene().scale_stiffness(tumour, 0.1);

    const StepReport report = tissue.advance(tick);
    if (!report.ok()) {  // the last good state is kept
      stop();
      std::puts(report.message().c_str());
      return 1;
    }
    largest = std::max(largest, coupling.force().norm());  // which goes to the device
    state = tissue.state();
    frames.give(state.position);

    due += std::chrono::milliseconds(1);
    std::this_thread::sleep_until(due);
  }
  stop();

  const double end = state.time;
  const bool undone = tissue.rewind(end - 0.1);
  coupling.reset(tissue.pose_of(gripper));  // or the hand would be pulled to where the tool was
  std::printf("%d particles, %.3f s, %d pictures; at most %.2f N on the hand\n", tissue.model().particle_count(), end,
              drawn, largest);
  std::printf("%s to %.3f s\n", undone ? "gone back" : "could not go back", tissue.time());
  return undone && largest > 0.0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  return run(argc > 1 ? std::atof(argv[1]) : 3.0);
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
