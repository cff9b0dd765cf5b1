// SPDX-License-Identifier: MIT
//
// Runs that tests of saved states and recordings share. Bodies that rest, and everything that can wake them.
#pragma once

#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <cstring>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "base/checked_file.h"
#include "bodies.h"
#include "message_of.h"

namespace phymul::test {

/// A calibrated block, 1,000 particles and so more than one cluster, wherever it is asked to stand.
inline Model block_at(const Vec3& origin) {
  return with_material(moved(make_block({0.06, 0.03, 0.03}, 15, 8, 8), origin));
}

inline Load pull(const Model& model, const char* group, const Vec3& direction, std::vector<ValueEvent> events,
                 LoadType type = LoadType::translation) {
  return {.type = type,
          .particles = model.group(group),
          .events = std::move(events),
          .direction = direction,
          .applied_to = group};
}

struct BackendCase {
  const char* name;
  int threads;
};
inline constexpr BackendCase cpu_backends[] = {{"reference", 0}, {"cpu", 1}, {"cpu", 2}};

inline SolverOptions options_for(const BackendCase& backend, double damping = 5.0) {
  return {.damping = {.rate = damping}, .threads = backend.threads};
}

inline std::string path_for(const char* name) {
  return testing::TempDir() + "phymul_" + name;
}

/// Bits, not values: 0 and -0 differ.
inline bool same_bits(const VecList& a, const VecList& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), sizeof(Vec3) * a.size()) == 0;
}
inline bool same_bits(const State& a, const State& b) {
  return a.time == b.time && same_bits(a.position, b.position) && same_bits(a.velocity, b.velocity);
}

/// A file's bytes are read as they are, but not cut at any byte nor with any bit turned.
inline void expect_damage_is_refused(const std::string& good, const std::function<void(const std::string&)>& read) {
  ASSERT_EQ(message_of([&] { read(good); }), "(no error)");
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_NE(message_of([&] { read(good.substr(0, length)); }), "(no error)") << length;
  }
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string bad = good;
    bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ 1 << bit % 8);
    EXPECT_NE(message_of([&] { read(bad); }), "(no error)") << bit;
  }
}

/// Erases, inserts or turns a few of some bytes, as a program with a mistake would write them.
inline void hurt(std::string& bytes, std::mt19937& bits) {
  for (std::size_t times = 1 + bits() % 3; times > 0 && !bytes.empty(); --times) {
    const std::size_t at = bits() % bytes.size();
    const unsigned way = bits() % 4;
    if (way == 0) bytes.erase(at, 1 + bits() % 9);
    if (way == 1) bytes.insert(at, 1 + bits() % 9, '\xff');
    if (way > 1) bytes[at] = static_cast<char>(bytes[at] ^ 1 << bits() % 8);
  }
}

/// Damage behind right checksums, in any section but the first: `use` takes a file or throws an Error.
inline void expect_mutants_are_harmless(const FileKind& kind, std::initializer_list<std::string_view> tags,
                                        const std::string& good, const std::function<void(const std::string&)>& use) {
  const std::vector<FileSection> sections = read_sections("good", good, kind, tags);
  std::mt19937 bits(5);
  int taken = 0, refused = 0;
  for (int k = 0; k < 4000; ++k) {
    SectionWriter file(kind);
    const std::size_t hurt_one = 1 + bits() % (sections.size() - 1);
    for (std::size_t s = 0; s < sections.size(); ++s) {
      std::string bytes(sections[s].payload);
      if (s == hurt_one) hurt(bytes, bits);
      ByteWriter payload;
      payload.raw(bytes);
      file.add(sections[s].tag, payload);
    }
    ++(message_of([&] { use(file.finish()); }) == "(no error)" ? taken : refused);
  }
  EXPECT_GT(taken, 100);
  EXPECT_GT(refused, 1000);
}

struct SleepingScene {
  std::string name;
  Model model;
  std::function<void(Scene&)> set_up;
  /// Before each call of some steps, of which there are `calls`.
  std::function<void(Scene&, int call)> drive = [](Scene&, int) {};
};

inline constexpr int sleeping_calls = 30, steps_a_call = 8;
inline constexpr int woken_at = 6;  ///< the call that something new comes with

/// Enough particles for some twenty blocks, few of which are near each other.
inline Model wide_block() {
  return with_material(make_block({0.12, 0.12, 0.03}, 24, 24, 6));
}
inline Model long_tetrahedra() {
  return with_material(make_tetrahedral_block({0.24, 0.03, 0.03}, 48, 6, 6, 0.2, 7));
}
/// They meet near the end that is pushed, so that what is far from it still sleeps when their boundary moves.
inline Model two_materials() {
  Model model = make_tetrahedral_block({0.24, 0.03, 0.03}, 48, 6, 6, 0.2, 7);
  model.add_group("left", model.particles_in([](const Vec3& X) { return X.x() < 0.225; }));
  set_material(model, soft_tissue());
  set_material(model, {50e3, 0.3, 1000.0}, "left");
  return model;
}
inline Model long_organ() {
  Model model = make_body(solid_ellipsoid({0.12, 0.015, 0.015}, {0.12, 0.03, 0.025}), {.spacing = 0.0075});
  model.add_group("x0", model.particles_in([](const Vec3& X) { return X.x() < 0.02; }));
  model.add_group("x1", model.particles_in([](const Vec3& X) { return X.x() > 0.22; }));
  return with_material(std::move(model));
}
/// Two blocks, one over the edge of the other.
inline Model two_blocks() {
  const Model lower = wide_block(), upper = moved(wide_block(), {0.1, 0.0021, 0.033});
  return merged({{"low", &lower}, {"high", &upper}});
}

/// A pulse of force, or a pose, that begins with the call `woken_at`; `step`: s.
inline std::vector<SleepingScene> sleeping_scenes(double step) {
  const double at = woken_at * steps_a_call * step, later = at + 40 * step;
  const auto pulse = [=](Scene& scene) {
    scene.fix("x0").add(
        pull(scene.model(), "x1", {0, 1, -1}, {{at, 0.0}, {at + 20 * step, 1e-3}, {later, 0.0}}, LoadType::force));
  };
  const auto press = [](double depth) { return ToolPose{.position = {0.08, 0.0152, 0.03 + 0.0101 - depth}}; };
  std::vector<SleepingScene> scenes;
  scenes.push_back({"force, lattice", wide_block(), pulse});
  scenes.push_back({"force, tetrahedra", long_tetrahedra(), pulse});
  scenes.push_back({"force, two materials", two_materials(), pulse});
  scenes.push_back({"force, organ", long_organ(), pulse});
  scenes.push_back({"gravity", long_tetrahedra(), [](Scene& scene) { scene.fix("x0"); },
                    [](Scene& scene, int call) {
                      if (call == woken_at) scene.gravity({0, 0, -0.5});
                    }});
  scenes.push_back({"gravity in time", wide_block(), [=](Scene& scene) {
                      scene.fix("x0").add({.type = LoadType::acceleration,
                                           .particles = every_particle(scene.model()),
                                           .events = {{at, 0.0}, {at + 20 * step, 0.5}},
                                           .direction = {0, 0, -1}});
                    }});
  scenes.push_back({"imposed motion", wide_block(), [=](Scene& scene) {
                      scene.fix("x0").add(pull(scene.model(), "x1", {0, 0, 1}, {{at, 0.0}, {later, 0.002}}));
                    }});
  scenes.push_back({"another step and load", long_tetrahedra(), [](Scene& scene) { scene.fix("x0"); },
                    [](Scene& scene, int call) {
                      if (call != woken_at) return;
                      scene.add(pull(scene.model(), "x1", {0, 0, 1}, {{0.0, 1e-4}}, LoadType::force));
                    }});
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    scenes.push_back({contact == ToolContact::surface ? "tool on the surface" : "tool", wide_block(),
                      [=](Scene& scene) {
                        scene.fix("x0").add_tool(
                            "ball",
                            {.shape = Sphere{0.01}, .pose = press(-0.002), .friction = 0.2, .contact = contact});
                      },
                      [=](Scene& scene, int call) {
                        const int since = call - woken_at;
                        if (since >= 0 && since < 15) scene.tool("ball").move_to(press(-0.002 + 0.0003 * since));
                        if (call == 22) scene.tool("ball").teleport(press(-0.01));
                      }});
  }
  scenes.push_back(
      {"tool that appears inside", wide_block(),
       [=](Scene& scene) { scene.fix("x0").add_tool("ball", {.shape = Sphere{0.01}, .pose = press(-0.01)}); },
       [=](Scene& scene, int call) {
         if (call == woken_at) scene.tool("ball").teleport(press(0.001));
       }});
  scenes.push_back(
      {"grasp", long_tetrahedra(),
       [=](Scene& scene) { scene.fix("x0").add_tool("ball", {.shape = Sphere{0.01}, .pose = press(0.0)}); },
       [=](Scene& scene, int call) {
         if (call == woken_at) scene.tool("ball").grasp(0.004);
         if (call > woken_at && call < 18) scene.tool("ball").move_to(press(-0.0001 * (call - woken_at)));
         if (call == 22) scene.tool("ball").release();
       }});
  scenes.push_back({"joint", long_tetrahedra(),
                    [=](Scene& scene) {
                      const ToolPose apart{.position = {0.24, 0.015, 0.1}};
                      scene.fix("x0").add_tool("hook", {.shape = Sphere{0.001}, .pose = apart});
                      scene.add_joint({.a = at_mean(scene.model().group("x1")), .b = at_tool("hook")}, 5.0);
                    },
                    [](Scene& scene, int call) {
                      if (call < woken_at || call > 18) return;
                      scene.tool("hook").move_to({.position = {0.24, 0.015, 0.1 + 1e-4 * (call - woken_at)}});
                    }});
  scenes.push_back({"contact of two bodies", two_blocks(), [=](Scene& scene) {
                      scene.fix("low/x0").fix("high/x1").contacts({.friction = 0.2, .self = false});
                      scene.add(pull(scene.model(), "high/x0", {0, 0, -1}, {{at, 0.0}, {later, 0.006}}));
                    }});
  scenes.push_back({"kept volume", wide_block(), [=](Scene& scene) {
                      scene.constrain_volume();
                      pulse(scene);
                    }});
  return scenes;
}

}  // namespace phymul::test
