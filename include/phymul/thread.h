// SPDX-License-Identifier: MIT
//
// Threads: sutures. Scene::add_thread() adds a free thread, a chain of nodes with tension, bending and weight.
// Scene::sew() adds a thread that passes through the body: straight, massless segments between passages, where it
// sticks or slides; a needle makes them where Scene::swage() joins the thread to one. Both are integrated implicitly
// and do not shorten the stable step. The algorithms are in src/interaction/thread/.
#pragma once

#include <phymul/joint.h>

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace phymul {

/// Constants of a thread. The defaults are those of a polypropylene monofilament, USP 3-0. Scene::add_thread() and
/// Scene::sew() throw Error for a value out of its range or not finite.
struct Thread {
  double length = 0.3;      ///< m, > 0. Of a sewn thread: with both tails
  double radius = 0.15e-3;  ///< m, > 0
  double young = 2e9;       ///< Pa, > 0. The axial stiffness EA is young * pi radius^2
  /// N m^2, >= 0; below 0: that of a solid round section, young * pi radius^4 / 4. A braid bends far more easily. A
  /// sewn thread has none.
  double bending_stiffness = -1.0;
  double density = 920.0;  ///< kg/m^3, > 0. A sewn thread has no mass
  double segment = 3e-3;   ///< m, > 0: largest distance of nodes of a free thread
  double damping = 0.0;    ///< 1/s, >= 0: rate at which a free thread loses speed, besides what implicit Euler takes
  /// A free thread lies on tools, but for needles, blades and those that its tips are joined to, and on the surface of
  /// tissue: its nodes stay a radius away. Its segments do not pass through each other, nor through those of other free
  /// threads that touch.
  bool touches = false;
  /// Coulomb coefficient, >= 0: on what a free thread lies on, where it is the geometric mean of two threads; at a
  /// passage, where tensions differ by exp(friction * angle).
  double friction = 0.1;

  // Of a sewn thread.
  double channel_friction = 0.0;  ///< N, >= 0: further difference of tensions at each passage

  // Infinite by default: never.
  double breaking_force = std::numeric_limits<double>::infinity();  ///< N, > 0: tension at which a segment breaks
  double passage_limit = std::numeric_limits<double>::infinity();   ///< N, > 0: force at which the tissue tears
  /// N, > 0: force that each throw of a knot holds before thread slips through it. A round number: measure yours.
  double throw_holding = 1.0;
  bool operator==(const Thread&) const = default;
};

double axial_stiffness(const Thread& thread);    ///< N: young * pi radius^2
double bending_stiffness(const Thread& thread);  ///< N m^2, never below 0

enum class ThreadTip : std::uint8_t { first, last };

/// What holds a tip.
enum class TipHold : std::uint8_t {
  pulled,    ///< a force, ThreadEnd::force; 0: the tip is free
  fixed,     ///< of a sewn thread: a stop at its first or last passage, through which it does not slide
  anchored,  ///< particles, a tool or a point of the world
  clamped    ///< of a sewn thread: as fixed, up to a force, above which the thread slips through
};

struct ThreadEnd {
  TipHold hold = TipHold::pulled;
  Vec3 force{0, 0, 0};  ///< N
  Anchor anchor{};
  double holding = 0.0;    ///< N, of a tip that is clamped
  double gap = -1.0;       ///< m, likewise: the segment next to it is drawn to this length; below 0: it stays
  std::uint64_t call = 0;  ///< SceneThread::changes of ThreadHandle::clamp(): each call draws anew
  bool operator==(const ThreadEnd&) const = default;
};

/// What pinches two walls of tissue together and stays, Scene::add_clip(): a piece of thread between them, clamped at
/// both ends.
struct Clip {
  double gap = 0.5e-3;    ///< m, >= 0: between the walls, once it is closed
  double holding = 1.0;   ///< N, > 0: force with which it closes, and above which it opens
  double opening = 0.01;  ///< m, > 0: a clip that has opened by so much more than at first has come off
};

/// A node of a free thread that is held at a place, m.
struct HeldNode {
  Index node = 0;
  Vec3 position{0, 0, 0};
  bool operator==(const HeldNode&) const = default;
};

/// Two passages of a sewn thread are tied to each other, and the thread slides through neither.
struct Knot {
  Index a = 0, b = 0;      ///< rows of passages, a < b: first SceneThread::passages, then ThreadState::sewn
  int throws = 0;          ///< >= 1
  std::uint64_t call = 0;  ///< SceneThread::changes of ThreadHandle::tie(): each call replaces a knot that broke
  bool operator==(const Knot&) const = default;
};

/// What a ThreadHandle changes.
struct ThreadControl {
  std::array<ThreadEnd, 2> ends{};
  std::vector<HeldNode> held{};  ///< by node
  std::vector<Knot> knots{};
  bool operator==(const ThreadControl&) const = default;
};

/// Part of a Scene.
struct SceneThread {
  std::uint64_t id = 0;  ///< unique in its scene, also after threads were removed
  std::string name{};
  Thread thread{};
  /// m and unit vector: the free thread's first shape. No direction: a sewn thread whose passages a needle makes.
  Vec3 start{0, 0, 0}, direction{1, 0, 0};
  std::vector<Anchor> passages{};  ///< of a sewn thread, in its order
  ThreadControl control{};
  std::uint64_t changes = 0;  ///< of `control`

  bool is_sewn() const { return !passages.empty() || direction == Vec3::Zero(); }
  Index nodes() const;  ///< of a free thread: ceil(length / segment) + 1
};

struct KnotState {
  Index a = 0, b = 0;        ///< as Knot
  double rest_length = 0.0;  ///< m, of thread between both
  double tension = 0.0;      ///< N
  double slip = 0.0;         ///< m of thread that went through the knot
  bool broken = false;       ///< by Thread::breaking_force, or a passage has let go
  bool operator==(const KnotState&) const = default;
};

/// A thread after a step. Part of a State, in which it determines all further steps. A sewn thread has no segments
/// before its first step, in which rest lengths become the distances.
struct ThreadState {
  std::string name{};
  VecList position{};                  ///< m: nodes [N]; of a sewn thread: tips and passages [passages + 2]
  VecList velocity{};                  ///< m/s [N] of nodes; empty for a sewn thread
  std::vector<double> rest_length{};   ///< m [N - 1]; of a sewn thread [passages + 1], where the outer ones are tails
  std::vector<double> tension{};       ///< N, likewise; a slack segment has none
  std::vector<std::uint8_t> broken{};  ///< likewise; 1: the segment has no force
  std::vector<Anchor> sewn{};          ///< passages that a needle has made
  std::vector<Index> passages{};       ///< rows, as Knot has them, of those that the thread still goes through
  std::vector<std::int8_t> slides{};   ///< [passages] 0: sticks; 1 or -1: slides toward the last or first tip
  std::vector<KnotState> knots{};
  VecList touch{};                 ///< N: what a free thread touches pushes its nodes with [N]; empty: nothing does
  std::array<bool, 2> anchored{};  ///< of a sewn thread: a tail is a segment to an anchor, or a clamp has been closed
  std::array<Vec3, 2> force{Vec3(0, 0, 0), Vec3(0, 0, 0)};  ///< N, of the thread on what its tips are anchored to
  int torn = 0;                                             ///< passages at which the tissue gave way
  int pulled_out = 0;                                       ///< passages that a tip has slipped through
  bool operator==(const ThreadState&) const = default;
};

}  // namespace phymul
