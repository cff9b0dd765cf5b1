// SPDX-License-Identifier: MIT
#include "haptic_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace phymul::bench {
namespace {

constexpr double reach = 0.25;  // of the spacing: how far the moved particles go
constexpr double probe_radius = 0.010, pressed = 0.004, rubbed = 0.003;  // m
constexpr double needle_above = 0.003, needle_deep = 0.050;              // m
constexpr double deepest_share = 0.6;                                    // of a body's height, for the needle

/// Puncture and cutting are not Needle's defaults, which are liver's with its capsule: a block of 10 kPa yields all of
/// the needle's way before it resists with 2 N, so that nothing would be pierced. These let the tip dent it by about a
/// centimetre first. Friction is the default's.
constexpr Needle thin_needle{.length = 0.12, .puncture = 0.4, .cutting = 0.15};

/// A warped body has no two cells alike, as one read from a mesh; its upper and lower face are the block's.
Model make_body(int particles, bool warped) {
  const int n = std::max(1, static_cast<int>(std::lround(std::cbrt(particles))) - 1);
  const int high = std::max(1, (particles + n * (n + 2)) / ((n + 1) * (n + 1)) - 1);
  Model model = make_block({n * haptic_spacing, n * haptic_spacing, high * haptic_spacing}, n, n, high, 6);
  if (warped) {
    const Vec3 corner = model.rest.back();
    for (Vec3& x : model.rest) {
      const double bulge = 0.3 * haptic_spacing * std::sin(std::numbers::pi * x.z() / corner.z());
      x.x() += bulge * (1.0 + x.x() / corner.x()) * (1.0 + x.y() / corner.y());
    }
  }
  set_material(model, {.young = 10e3, .poisson = 0.3, .density = 1000});
  return model;
}

/// A hand's motion: a few hertz, all axes, mostly pressing.
Vec3 hand(double time) {
  const double a = reach * haptic_spacing;
  return {a * std::sin(7.0 * time), a * std::sin(11.0 * time), -a * (1.0 - std::cos(5.0 * time))};
}

std::array<ValueEvent, 2> way(double date, int axis) {
  return {{{date, hand(date)[axis]}, {date + tick, hand(date + tick)[axis]}}};
}

}  // namespace

HapticScene::HapticScene(int particles, bool warped) : model_(make_body(particles, warped)), scene_(model_) {
  scene_.fix("z0");
}

Vec3 HapticScene::top(double x, double y) const {
  const Vec3& corner = model_.rest.back();
  return {x * corner.x(), y * corner.y(), corner.z()};
}

MovedParticles::MovedParticles(int particles, bool warped) : HapticScene(particles, warped) {
  std::vector<Index> moved;
  for (const Index i : model().group("z1")) {
    if ((model().rest[i] - top(0.5, 0.5)).norm() <= 2.5 * haptic_spacing) moved.push_back(i);
  }
  for (int axis = 0; axis < 3; ++axis) {
    Load load;
    load.type = LoadType::translation;
    load.particles = moved;
    load.axes.fill(Axis::free);
    load.axes[axis] = Axis::driven;
    load.direction = Vec3::Unit(axis);
    load.events = {{0.0, 0.0}, {tick, 0.0}};
    scene_.add(load);
  }
  count_ = moved.size();
}

void MovedParticles::drive(double date) {
  for (int axis = 0; axis < 3; ++axis) scene_.set_events(static_cast<std::size_t>(axis) + 1, way(date, axis));
}

void MovedParticles::drive_by_replacing(double date) {
  for (int axis = 0; axis < 3; ++axis) {
    Load load = scene_.loads()[static_cast<std::size_t>(axis) + 1];
    const auto events = way(date, axis);
    load.events.assign(events.begin(), events.end());
    scene_.replace(static_cast<std::size_t>(axis) + 1, std::move(load));
  }
}

std::string MovedParticles::what() const {
  return "a group of " + std::to_string(count_) + " particles";
}

ProbeAndNeedle::ProbeAndNeedle(int particles, bool warped)
    : HapticScene(particles, warped), needle_deep_(std::min(needle_deep, deepest_share * top(0.0, 0.0).z())) {
  scene_.add_tool("probe", {.shape = Sphere{probe_radius}, .pose = probe_at(0.0), .friction = 0.3});
  scene_.add_tool("needle", {.shape = thin_needle, .pose = needle_at(0.0), .friction = 0.3});
}

ToolPose ProbeAndNeedle::probe_at(double time) const {
  const Vec3 moved(rubbed * std::sin(7.0 * time), rubbed * std::sin(11.0 * time),
                   probe_radius - 0.5 * pressed * (1.0 - std::cos(5.0 * time)));
  return {.position = top(0.3, 0.5) + moved};
}

ToolPose ProbeAndNeedle::needle_at(double time) const {
  const double in = 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * time));
  return {.position = top(0.7, 0.5) + (needle_above - (needle_above + needle_deep_) * in) * Vec3::UnitZ()};
}

void ProbeAndNeedle::drive(double date) {
  scene_.tool("probe").move_to(probe_at(date + tick));
  scene_.tool("needle").move_to(needle_at(date + tick));
}

void ProbeAndNeedle::answer(const Solver& solver, const State& state) {
  const ToolForce &probe = solver.tool_force("probe"), &needle = solver.tool_force("needle");
  seen_.on_probe = std::max(seen_.on_probe, probe.mean_force.norm());
  seen_.pressed = std::max(seen_.pressed, probe.particles);
  seen_.on_needle = std::max(seen_.on_needle, needle.mean_force.z());
  seen_.pulled = std::min(seen_.pulled, needle.mean_force.z());
  ++seen_.answers;
  const NeedleState& now = state.tools.at(1).needle;
  const bool in = now.punctured;
  seen_.entered += in && !in_ ? 1 : 0;
  seen_.left += in_ && !in ? 1 : 0;
  in_ = in;
  if (!in) return;
  ++seen_.inserted;
  seen_.nodes = std::max(seen_.nodes, now.hole.size());
  double mouth = 0.0;  // z of the hole's
  for (std::size_t k = 0; k < now.hole[0].particles.size(); ++k) {
    mouth += now.hole[0].weights[k] * state.position[now.hole[0].particles[k]].z();
  }
  seen_.deepest = std::max(seen_.deepest, mouth - state.tools[1].pose.position.z());
}

std::string ProbeAndNeedle::found(double seconds) const {
  std::array<char, 300> text{};
  std::snprintf(text.data(), text.size(),
                "on the ball at most %.2f N, of %d particles; on the needle %.2f N in and %.2f N out; it entered %d "
                "times and left %d times; its hole was at most %.0f mm deep, of %zu nodes; it was in for %.0f %% of "
                "the ticks",
                seen_.on_probe, seen_.pressed, seen_.on_needle, seen_.pulled, seen_.entered, seen_.left,
                1e3 * seen_.deepest, seen_.nodes,
                100.0 * static_cast<double>(seen_.inserted) / static_cast<double>(std::max(1L, seen_.answers)));
  if (seconds >= 1.0 && (seen_.entered == 0 || seen_.deepest < 0.5 * needle_deep_ || !(seen_.pulled < 0.0))) {
    throw Error(std::string("haptic_loop: expected a needle that pierces the body, goes deep and is held back on its "
                            "way out; ") +
                text.data());
  }
  if (seconds >= 1.0 && !(seen_.on_probe > 0.0)) {
    throw Error(std::string("haptic_loop: expected a ball that presses the body; ") + text.data());
  }
  return text.data();
}

}  // namespace phymul::bench
