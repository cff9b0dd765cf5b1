// SPDX-License-Identifier: MIT
//
// The threads of a scene as one solver moves them: what holds their tips and nodes step by step. In double precision
// whatever the backend's own is.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "interaction/contact_surface.h"
#include "interaction/contact_tool.h"
#include "interaction/predicted_step.h"
#include "interaction/tool_frame.h"
#include "thread_crossings.h"
#include "thread_path.h"
#include "thread_rod.h"

namespace phymul {

// A free thread that lies on tools and on the surface of tissue (Thread::touches), in one step. Its nodes stay a radius
// away. What a node touches pushes it by k (need - n . dx), where dx is its way in the step, and by as much against its
// sliding, up to Coulomb's limit. Under a tool k is far above that of the thread's segments. Tissue that is pushed with
// a force f over dt goes dt^2 W f farther, so that 1 / (dt^2 W) is its k, without iterating between both: W is that of
// the particles, each split among the nodes that share it (surface_press.h). Which nodes touch, and which slide, is
// found in rounds, each with an iteration of Newton's method of the rod. Threads that touch each other
// (thread_crossings.h) go through the rounds together.

/// A tool in a step, as what threads lie on.
struct ThreadSupport {
  std::string_view tool;
  const ShapeIn<double>* shape = nullptr;
  ToolFrame start, end;
  ToolForce* force = nullptr;  ///< takes what the thread does
};

class ThreadContacts {
 public:
  /// `particles`: of the body that has the surface.
  ThreadContacts(const Thread& thread, std::shared_ptr<const ContactSurface> surface, std::size_t particles);
  void forget() { gone_ = NAN; }  ///< places changed otherwise than step by step

  /// A thread in a step that it has begun. Tissue does not touch nodes before `first` and after `last`.
  struct Lying {
    ThreadRod* rod = nullptr;
    ThreadContacts* contacts = nullptr;
    std::size_t strand = 0;  ///< of ThreadCrossings
    std::vector<ThreadSupport> tools{};
    Index first = 0, last = 0;
  };
  /// What ThreadRod::solve() does for a thread that touches nothing, for all threads of a group of `crossings`.
  static void solve(std::span<const Lying> threads, ThreadCrossings& crossings, TouchedParticles& touched);

  ThreadCrossings::Strand strand(ThreadRod& rod) const {
    return {.rod = &rod, .radius = radius_, .friction = friction_, .stiffest = stiffest_};
  }

 private:
  struct Touch {
    Index node = 0;
    int tool = -1;                  // -1: tissue
    std::array<Index, 3> corner{};  // rows of ContactSurface::particles
    Vec3 share{0, 0, 0};            // of them
    Vec3 normal{0, 0, 0};           // toward the node
    Vec3 slide{0, 0, 0};            // m: the way of the place that it touches
    double need = 0.0;              // m, of the node's way along the normal
    double stiffness = 0.0;         // N/m
    double press = 0.0;             // N
    double rubbing = 0.0;           // N/m, of what acts against sliding
  };

  struct Near {
    Index triangle = -1;
    double apart = 0.0;  // m
  };
  struct Faced {
    Index triangle = -1;
    double apart = 0.0, facing = 0.0, gap = 0.0;  // m, cosine, m
    Vec3 share{0, 0, 0}, normal{0, 0, 0};
  };

  Vec3 corner_place(Index corner, const PredictedStep& step) const;
  template <class Visit>
  void each_particle(const Touch& touch, Visit visit) const;
  bool knows_near(const ThreadRod& rod, double reach, const TouchedParticles& touched);
  void find_near(const ThreadRod& rod, double reach, const TouchedParticles& touched);
  std::optional<Touch> facing(Index node, const Vec3& place, double reach, const TouchedParticles& touched);
  void find_facing(const ThreadRod& rod, Index first, Index last, const TouchedParticles& touched);
  bool measure(Touch& touch, const ThreadSupport& tool, const ThreadRod& rod) const;
  bool rub(Touch& touch, const ThreadRod& rod) const;
  bool update(const Lying& own, const ThreadCrossings& crossings);
  static void find_stiffness(std::span<const Lying> threads, TouchedParticles& touched);
  void give_forces(const Lying& own, TouchedParticles& touched) const;
  void find_pushes();

  double radius_, segment_, friction_, stiffest_;  // m, m, Coulomb's, N/m
  std::shared_ptr<const ContactSurface> surface_;
  std::vector<Touch> touches_, before_;  // of this round and the one before, by node and tool
  std::vector<Faced> faced_;             // by the node at hand
  std::vector<Touch> facing_;            // of the step, by node: tissue that it may touch
  std::vector<ThreadRod::Push> pushes_;  // [touches_]
  std::vector<double> crowd_;            // [N] of the body; 0 between steps

  // Of the last find_near().
  double listed_ = 0.0, used_ = 0.0;  // m: how far triangles are listed, and by how much all may have come nearer since
  double gone_ = NAN, going_ = 0.0;   // m, of its step
  VecList then_;                      // m, of the nodes
  std::vector<double> clear_;         // m [nodes]: no triangle is nearer
  std::vector<std::size_t> first_;    // [nodes + 1] in near_
  std::vector<Near> near_;            // of each node the nearest first
};

class ThreadSet {
 public:
  /// Takes over the scene's threads after a change; threads that stay keep their state. Allocates.
  void follow(const Scene& scene, FollowedSurface& surface);
  bool empty() const { return threads_.empty(); }

  void reset(const Scene& scene, const State& state);
  void read(const Scene& scene, State& state) const;  ///< of the threads that the scene has, as they are held by now
  /// A call of `steps` steps begins: looks for what holds the threads now. `at_once`: nodes go there in the first step.
  void begin_call(const Scene& scene, int steps, bool at_once);

  /// A tool in the step.
  struct AtTool {
    const ToolPose *start = nullptr, *end = nullptr;
    ToolForce* force = nullptr;  ///< takes what the thread does
    bool is_free = false;        ///< a needle that was let go: the thread does not pull it
  };
  using FindTool = std::function<AtTool(std::string_view name)>;
  /// `supports`: what threads may lie on, where any_touches().
  void act(TouchedParticles& touched, const FindTool& find_tool, std::span<const ThreadSupport> supports);
  bool any_touches() const {
    return std::ranges::any_of(threads_, [](const Moving& thread) { return thread.contacts.has_value(); });
  }
  /// What has passed the tail of a needle at a pose, in order, becomes passages of the threads joined to it there.
  void follow_needle(std::string_view needle, std::span<const std::pair<Anchor, Vec3>> passed, const ToolPose& pose);
  bool is_finite() const;  ///< at the end of the step in question
  void accept();           ///< the step counts
  void drop();             ///< it does not: the next act() does it over

  /// Of a thread of the scene as it is now. Good until the next call of a function of this class.
  const ThreadState& state(const SceneThread& wanted) const;

 private:
  struct Moving {
    std::uint64_t id = 0, seen = 0;  // SceneThread's id and changes
    ThreadControl control;
    std::variant<ThreadRod, ThreadPath> body;
    std::optional<ThreadContacts> contacts{};
  };
  /// Where a tip is to be in the step: the place at its start and the way of what it is anchored to.
  struct Tip {
    bool in_body = false;
    Vec3 place{0, 0, 0}, way{0, 0, 0};  // m
    AtTool tool;
  };

  static Moving made(const SceneThread& thread);
  static void look(Moving& thread, const SceneThread& wanted, std::span<const double> mass);
  Tip tip_of(const ThreadEnd& end, const Vec3* at, TouchedParticles& touched, const FindTool& find_tool) const;
  /// A free thread in the step.
  struct Begun {
    Moving* thread = nullptr;
    std::array<Tip, 2> tips{};
    std::array<bool, 2> joined{};  // not to a needle that was let go
    std::array<Vec3, 2> mobility{Vec3(0, 0, 0), Vec3(0, 0, 0)};
  };
  Begun begun(Moving& thread, TouchedParticles& touched, const FindTool& find_tool,
              std::span<const std::size_t> together) const;
  static void lie(const Begun& begun, std::span<const ThreadSupport> supports, ThreadContacts::Lying& lying);
  static void finish(const Begun& begun, TouchedParticles& touched);
  void find_crossings(TouchedParticles& touched, const FindTool& find_tool);
  void act_free(TouchedParticles& touched, const FindTool& find_tool, std::span<const ThreadSupport> supports);
  /// Sewn threads that share particles, or one alone.
  struct Together {
    std::vector<std::size_t> rows;
    ThreadTensions tensions;
  };
  void act(Together& together, TouchedParticles& touched, const FindTool& find_tool);
  void find_together();

  std::vector<Moving> threads_;
  ThreadCrossings crossings_;
  // Of the step: rows of the free threads that touch; of those that go through it together, rows and what they lie on.
  std::vector<std::size_t> strands_, rows_;
  std::vector<Begun> begun_;
  std::vector<ThreadContacts::Lying> lying_;  // as many as there ever were together, for their memory
  std::vector<Together> sewn_;
  std::vector<std::array<Tip, 2>> tips_;  // of the step
  Vec3 gravity_{0, 0, 0};                 // m/s^2
  int steps_left_ = 1;                    // of the call
  mutable ThreadState unseen_;
};

}  // namespace phymul
