// SPDX-License-Identifier: MIT
//
// The threads of a scene as one solver moves them: what holds their tips and nodes step by step. In double precision
// whatever the backend's own is.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "interaction/predicted_step.h"
#include "thread_contacts.h"
#include "thread_crossings.h"
#include "thread_path.h"
#include "thread_rod.h"

namespace phymul {

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
