// SPDX-License-Identifier: MIT
//
// The threads of a scene: what is accepted, and the handles that change them.
#include <phymul/error.h>
#include <phymul/scene.h>
#include <phymul/skin.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "anchor_place.h"
#include "base/decimal.h"
#include "base/files.h"
#include "scene_items.h"
#include "tool_state.h"

namespace phymul {
namespace {

constexpr double most_nodes = 1e5, node_rounding = 1e-9;
constexpr std::size_t most_passages = 100;  // a step solves them together

std::string thread_label(std::string_view thread) {
  return "thread \"" + std::string(thread) + "\": ";
}

void require_constants(const std::string& label, const Thread& of) {
  const auto require = [&](const char* what, double value, bool fits) {
    if (!fits) throw Error(label + "expected a " + what + ", got " + to_decimal(value));
  };
  for (const auto& [what, value] : {std::pair{"length (m) above 0", of.length},
                                    {"radius (m) above 0", of.radius},
                                    {"Young's modulus (Pa) above 0", of.young},
                                    {"density (kg/m^3) above 0", of.density},
                                    {"segment (m) above 0", of.segment},
                                    {"holding force of a throw (N) above 0", of.throw_holding}}) {
    require(what, value, value > 0.0 && std::isfinite(value));
  }
  require("finite bending stiffness (N m^2)", of.bending_stiffness, std::isfinite(of.bending_stiffness));
  require("breaking force (N) above 0", of.breaking_force, of.breaking_force > 0.0);
  require("passage limit (N) above 0", of.passage_limit, of.passage_limit > 0.0);
  require_not_negative(label, "damping (1/s)", of.damping);
  require_not_negative(label, "friction", of.friction);
  require_not_negative(label, "channel friction (N)", of.channel_friction);
  require("segment (m) for at most 100,000 nodes", of.segment,
          of.length / of.segment * (1.0 - node_rounding) <= most_nodes - 1.0);
}

void require_finite(const SceneThread& thread, const char* what, const Vec3& value) {
  if (!value.allFinite()) throw Error(thread_label(thread.name) + "expected a finite " + what);
}

/// Throws Error unless the way between neighbours is above 0 and the thread is as long as all of it.
void require_way(const SceneThread& thread, const VecList& rest) {
  double way = 0.0;
  for (std::size_t k = 1; k < thread.passages.size(); ++k) {
    const double piece =
        (anchor_place(thread.passages[k], rest, {}) - anchor_place(thread.passages[k - 1], rest, {})).norm();
    if (!(piece > 0.0)) {
      throw Error(thread_label(thread.name) + "expected places that differ, got the same for passages " +
                  std::to_string(k - 1) + " and " + std::to_string(k));
    }
    way += piece;
  }
  if (way <= thread.thread.length) return;
  throw Error(thread_label(thread.name) + "expected a thread as long as its way through the body, " + to_decimal(way) +
              " m; got a length of " + to_decimal(thread.thread.length) + " m");
}

/// Sorted rows of a knot, of passages that a needle makes, too; throws Error.
Knot knot_of(const SceneThread& thread, Index a, Index b, int throws) {
  const std::string label = thread_label(thread.name);
  const bool by_needle = thread.direction == Vec3::Zero();
  require_indices(std::array{a, b}, by_needle ? most_passages : thread.passages.size(), "passages",
                  [&] { return label; });
  if (a == b) throw Error(label + "expected two passages to tie to each other, got " + std::to_string(a) + " twice");
  if (throws < 1) throw Error(label + "expected 1 throw of a knot or more, got " + std::to_string(throws));
  return {std::min(a, b), std::max(a, b), throws};
}

}  // namespace

double axial_stiffness(const Thread& thread) {
  return thread.young * std::numbers::pi * thread.radius * thread.radius;
}

double bending_stiffness(const Thread& thread) {
  if (thread.bending_stiffness >= 0.0) return thread.bending_stiffness;
  return axial_stiffness(thread) * thread.radius * thread.radius / 4.0;
}

Index SceneThread::nodes() const {
  return static_cast<Index>(std::max(1.0, std::ceil(thread.length / thread.segment * (1.0 - node_rounding)))) + 1;
}

void Scene::require_new_thread(const SceneThread& thread) const {
  if (thread.name.empty()) throw Error("add_thread: expected a name, got an empty one");
  if (std::ranges::find(threads_, thread.name, &SceneThread::name) != threads_.end()) {
    throw Error(thread_label(thread.name) + "there is one of that name; remove_thread it first, or take another name");
  }
  if (model_->dimension == 2) throw Error(thread_label(thread.name) + "expected a body in three dimensions");
  require_constants(thread_label(thread.name), thread.thread);
}

ThreadHandle Scene::add_thread(std::string name, const Thread& thread, const Vec3& start, const Vec3& direction) & {
  SceneThread added{.id = next_thread_, .name = std::move(name), .thread = thread, .start = start};
  require_new_thread(added);
  require_finite(added, "start", start);
  require_finite(added, "direction", direction);
  const double length = direction.norm();
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw Error(thread_label(added.name) + "expected a direction whose length is not 0");
  }
  // One of length 1 stays as it is, bit for bit: the scene is compared with snapshots of it.
  added.direction = std::abs(length - 1.0) > 1e-15 ? Vec3(direction / length) : direction;
  threads_.push_back(std::move(added));
  ++version_;
  return {*this, next_thread_++};
}

ThreadHandle Scene::add_thread(const Thread& thread, const Vec3& start, const Vec3& direction) & {
  return add_thread(default_name("thread", next_thread_, threads_), thread, start, direction);
}

ThreadHandle Scene::sew(std::string name, const Thread& thread, std::vector<Anchor> passages) & {
  SceneThread added{.id = next_thread_, .name = std::move(name), .thread = thread, .passages = std::move(passages)};
  require_new_thread(added);
  if (added.passages.size() < 2 || added.passages.size() > most_passages) {
    throw Error(thread_label(added.name) + "expected 2 to " + std::to_string(most_passages) +
                " places to sew through, got " + std::to_string(added.passages.size()) +
                "; swage it to a needle that makes them");
  }
  for (std::size_t row = 0; row < added.passages.size(); ++row) {
    const std::string label = thread_label(added.name) + "passage " + std::to_string(row) + ": ";
    if (added.passages[row].particles.empty()) throw Error(label + "expected particles, got none");
    AnchorCheck{label, *model_, tools_}(added.passages[row]);
  }
  require_way(added, model_->rest);
  for (ThreadEnd& end : added.control.ends) end.hold = TipHold::fixed;
  threads_.push_back(std::move(added));
  ++version_;
  return {*this, next_thread_++};
}

ThreadHandle Scene::sew(std::string name, const Thread& thread, std::span<const Vec3> places) & {
  std::vector<Anchor> passages;
  try {
    const Skin skin(*model_, places);
    for (std::size_t k = 0; k < skin.size(); ++k) {
      const std::span<const Index> particles = skin.particles(k);
      const std::span<const double> weights = skin.weights(k);
      passages.push_back(
          {.particles = {particles.begin(), particles.end()}, .weights = {weights.begin(), weights.end()}});
    }
  } catch (const Error& error) {
    throw with_prefix(thread_label(name) + "the places to sew through: ", error);
  }
  return sew(std::move(name), thread, std::move(passages));
}

ThreadHandle Scene::sew(const Thread& thread, std::span<const Vec3> places) & {
  return sew(default_name("thread", next_thread_, threads_), thread, places);
}

ThreadHandle Scene::swage(std::string name, const Thread& thread, std::string_view needle) & {
  SceneThread added{.id = next_thread_, .name = std::move(name), .thread = thread, .direction = Vec3::Zero()};
  require_new_thread(added);
  if (!needle.empty()) {
    const auto* const shape = std::get_if<Needle>(&item_named(tools_, "tool", needle).tool.shape);
    if (!shape) {
      throw Error(thread_label(added.name) + "expected a needle to swage to; the tool \"" + std::string(needle) +
                  "\" has another shape");
    }
    added.control.ends[1] = {.hold = TipHold::anchored,
                             .anchor = at_tool(std::string(needle), shaft_place(*shape, shape->length))};
  }
  threads_.push_back(std::move(added));
  ++version_;
  return {*this, next_thread_++};
}

ThreadHandle Scene::swage(const Thread& thread, std::string_view needle) & {
  return swage(default_name("thread", next_thread_, threads_), thread, needle);
}

ThreadHandle Scene::add_clip(std::string name, const Clip& clip, const Anchor& one, const Anchor& other) & {
  const std::string label = "clip \"" + name + "\": ";
  require_not_negative(label, "gap (m)", clip.gap);
  for (const auto& [what, value] : {std::pair{"holding force (N)", clip.holding}, {"opening (m)", clip.opening}}) {
    if (!(value > 0.0) || !std::isfinite(value)) {
      throw Error(label + "expected a finite " + what + " above 0, got " + to_decimal(value));
    }
  }
  for (const Anchor& anchor : {one, other}) {
    if (anchor.particles.empty()) throw Error(label + "expected particles, got none");
    AnchorCheck{label, *model_, tools_}(anchor);
  }
  const double apart = (anchor_place(one, model_->rest, {}) - anchor_place(other, model_->rest, {})).norm();
  // Of clamps of one force the first lets thread through. The tail behind each is as long as the opening.
  Thread thread{.length = apart + 2.0 * clip.opening, .friction = 0.0};
  thread.segment = std::max(thread.segment, 1e-3 * thread.length);  // which a sewn thread does not have
  const ThreadHandle added = sew(std::move(name), thread, std::vector<Anchor>{one, other});
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) added.clamp(tip, clip.holding, clip.gap);
  return added;
}

ThreadHandle Scene::add_clip(const Clip& clip, const Anchor& one, const Anchor& other) & {
  return add_clip(default_name("clip", next_thread_, threads_), clip, one, other);
}

Scene& Scene::remove_thread(std::string_view name) {
  const std::uint64_t id = thread(name).id_;
  std::erase_if(threads_, [&](const SceneThread& known) { return known.id == id; });
  ++version_;
  return *this;
}

ThreadHandle Scene::thread(std::string_view name) & {
  return {*this, item_named(threads_, "thread", name).id};
}

SceneThread& ThreadHandle::own() const {
  return item_with(scene_->threads_, "thread", id_);
}

const SceneThread& ThreadHandle::thread() const {
  return own();
}

void ThreadHandle::hold(Index node, const Vec3& position) const {
  SceneThread& thread = own();
  if (thread.is_sewn())
    throw Error(thread_label(thread.name) + "expected a free thread to hold; it is sewn: join tips");
  require_indices(std::array{node}, static_cast<std::size_t>(thread.nodes()), "nodes",
                  [&] { return thread_label(thread.name); });
  require_finite(thread, "position of a node", position);
  std::vector<HeldNode>& held = thread.control.held;
  const auto place = std::ranges::lower_bound(held, node, {}, &HeldNode::node);
  if (place != held.end() && place->node == node) {
    place->position = position;
  } else {
    held.insert(place, {node, position});
  }
  ++thread.changes;
}

void ThreadHandle::release(Index node) const {
  SceneThread& thread = own();
  std::erase_if(thread.control.held, [&](const HeldNode& held) { return held.node == node; });
  ++thread.changes;
}

void ThreadHandle::join(ThreadTip tip, const Anchor& anchor) const {
  SceneThread& thread = own();
  const std::string label = thread_label(thread.name);
  AnchorCheck{label, scene_->model(), scene_->tools()}(anchor);
  if (tip == ThreadTip::last && thread.is_sewn() && !anchor.tool.empty()) {
    const Tool& tool = item_named(scene_->tools_, "tool", anchor.tool).tool;
    if (std::holds_alternative<Needle>(tool.shape)) thread.direction = Vec3::Zero();  // it makes passages
  }
  thread.control.ends[static_cast<std::size_t>(tip)] = {.hold = TipHold::anchored, .anchor = anchor};
  ++thread.changes;
}

void ThreadHandle::pull(ThreadTip tip, const Vec3& force) const {
  SceneThread& thread = own();
  require_finite(thread, "force (N)", force);
  thread.control.ends[static_cast<std::size_t>(tip)] = {.hold = TipHold::pulled, .force = force};
  ++thread.changes;
}

void ThreadHandle::fix(ThreadTip tip) const {
  SceneThread& thread = own();
  if (!thread.is_sewn()) throw Error(thread_label(thread.name) + "expected a sewn thread to fix; hold a node, or join");
  thread.control.ends[static_cast<std::size_t>(tip)] = {.hold = TipHold::fixed};
  ++thread.changes;
}

void ThreadHandle::clamp(ThreadTip tip, double holding, double gap) const {
  SceneThread& thread = own();
  const std::string label = thread_label(thread.name);
  if (!thread.is_sewn()) throw Error(label + "expected a sewn thread to clamp; hold a node, or join");
  if (!(holding > 0.0) || !std::isfinite(holding) || !std::isfinite(gap)) {
    throw Error(label + "expected a finite holding force (N) above 0 and a finite gap (m), got " + to_decimal(holding) +
                " and " + to_decimal(gap));
  }
  thread.control.ends[static_cast<std::size_t>(tip)] = {
      .hold = TipHold::clamped, .holding = holding, .gap = gap < 0.0 ? -1.0 : gap, .call = ++thread.changes};
}

void ThreadHandle::tie(Index passage, Index other, int throws) const {
  SceneThread& thread = own();
  Knot knot = knot_of(thread, passage, other, throws);
  loosen(passage, other);
  knot.call = thread.changes;
  thread.control.knots.push_back(knot);
}

void ThreadHandle::loosen(Index passage, Index other) const {
  SceneThread& thread = own();
  std::erase_if(thread.control.knots, [&](const Knot& knot) {
    return knot.a == std::min(passage, other) && knot.b == std::max(passage, other);
  });
  ++thread.changes;
}

void ThreadHandle::set(const ThreadControl& wanted) const {
  const SceneThread before = own();
  const ThreadControl& now = before.control;
  const auto take_call = [this](std::uint64_t& mine, std::uint64_t call) {
    mine = call;
    own().changes = std::max(own().changes, call);  // what comes later has other numbers
  };
  try {
    for (const std::size_t t : {0, 1}) {
      const ThreadTip tip = t == 0 ? ThreadTip::first : ThreadTip::last;
      const ThreadEnd& end = wanted.ends[t];
      if (end == now.ends[t]) continue;
      if (end.hold == TipHold::fixed) fix(tip);
      if (end.hold == TipHold::pulled) pull(tip, end.force);
      if (end.hold == TipHold::anchored) join(tip, end.anchor);
      if (end.hold == TipHold::clamped) clamp(tip, end.holding, end.gap);
      take_call(own().control.ends[t].call, end.call);
    }
    if (wanted.held != now.held) {
      for (const HeldNode& held : now.held) release(held.node);
      for (const HeldNode& held : wanted.held) hold(held.node, held.position);
    }
    if (wanted.knots != now.knots) {
      for (const Knot& knot : now.knots) loosen(knot.a, knot.b);
      for (const Knot& knot : wanted.knots) {
        tie(knot.a, knot.b, knot.throws);
        take_call(own().control.knots.back().call, knot.call);
      }
    }
  } catch (...) {
    own() = before;
    throw;
  }
}

void require_thread_states(const State& state, const std::vector<SceneThread>& threads) {
  const auto is_particle = [&](Index i) { return i >= 0 && static_cast<std::size_t>(i) < state.position.size(); };
  const auto is_place = [&](const Anchor& anchor) {
    return !anchor.particles.empty() && anchor.weights.size() == anchor.particles.size() &&
           std::ranges::all_of(anchor.particles, is_particle) &&
           std::ranges::all_of(anchor.weights, [](double w) { return std::isfinite(w); });
  };
  for (const ThreadState& own : state.threads) {
    const auto known = std::ranges::find(threads, own.name, &SceneThread::name);
    if (known == threads.end() || (fits(own, *known) && std::ranges::all_of(own.sewn, is_place))) continue;
    throw Error("Solver::reset: the state of thread \"" + own.name +
                "\" has lists of other lengths than the scene's thread of that name, passages that it does not have, "
                "or numbers that no thread has; give the scene the thread that the state was taken with, or take its "
                "entry out of State::threads");
  }
}

bool fits(const ThreadState& state, const SceneThread& thread) {
  const auto all = [](const auto& list, const auto& good) { return std::ranges::all_of(list, good); };
  const auto finite = [](const Vec3& v) { return v.allFinite(); };
  const auto size = [](double x) { return x >= 0.0 && std::isfinite(x); };
  const std::size_t segments = state.rest_length.size(), passages = state.passages.size();
  const bool good = all(state.position, finite) && all(state.velocity, finite) && all(state.rest_length, size) &&
                    state.tension.size() == segments && state.broken.size() == segments && state.torn >= 0 &&
                    state.pulled_out >= 0 && state.slides.size() == passages && all(state.touch, finite) &&
                    (state.touch.empty() || (!thread.is_sewn() && state.touch.size() == state.position.size()));
  if (!thread.is_sewn()) {
    const auto nodes = static_cast<std::size_t>(thread.nodes());
    return good && all(state.tension, [](double x) { return std::isfinite(x); }) && segments + 1 == nodes &&
           state.position.size() == nodes && state.velocity.size() == nodes && passages == 0 && state.knots.empty();
  }
  const std::size_t rows = thread.passages.size() + state.sewn.size();
  const auto has = [&](Index row) { return row >= 0 && static_cast<std::size_t>(row) < rows; };
  return good && all(state.tension, size) && state.velocity.empty() && all(state.passages, has) &&
         state.position.size() == (segments == 0 ? 0 : segments + 1) &&
         (segments > 0 || state.anchored == std::array<bool, 2>{}) &&
         segments == (passages == 0 && state.knots.empty() ? std::min<std::size_t>(segments, 1) : passages + 1) &&
         std::ranges::adjacent_find(state.passages, std::greater_equal()) == state.passages.end() &&
         all(state.slides, [](std::int8_t way) { return way >= -1 && way <= 1; }) &&
         all(state.knots, [&](const KnotState& knot) {
           return has(knot.a) && has(knot.b) && size(knot.rest_length) && size(knot.tension) && size(knot.slip);
         });
}

}  // namespace phymul
