// SPDX-License-Identifier: MIT
#include "thread_set.h"

#include <algorithm>

namespace phymul {
namespace {

constexpr Index nodes_in_tissue = 3;  // of a thread at a tip that is joined to particles: tissue does not push them out

const ThreadState& state_of(const std::variant<ThreadRod, ThreadPath>& body) {
  return std::visit([](const auto& own) -> const ThreadState& { return own.state(); }, body);
}

/// About the tool's position at the step's end; `at`: where the thread's force acts, m, at its start.
void pull(const ThreadSet::AtTool& tool, const Vec3& at, const Vec3& force) {
  tool.force->force += force;
  tool.force->torque += (at - tool.end->position).cross(force);
}

}  // namespace

ThreadSet::Moving ThreadSet::made(const SceneThread& thread) {
  Moving made{.id = thread.id, .control = thread.control, .body = ThreadRod(thread)};
  if (thread.is_sewn()) made.body.emplace<ThreadPath>(thread);
  return made;
}

void ThreadSet::look(Moving& thread, const SceneThread& wanted, std::span<const double> mass) {
  thread.seen = wanted.changes;
  thread.control = wanted.control;
  for (ThreadEnd& end : thread.control.ends) {
    if (!has_tissue(end.anchor, mass)) end = {};  // lets go
  }
  if (auto* const path = std::get_if<ThreadPath>(&thread.body)) path->follow(thread.control, mass);
}

void ThreadSet::follow(const Scene& scene, FollowedSurface& surface) {
  std::vector<Moving> now;
  now.reserve(scene.threads().size());
  for (const SceneThread& thread : scene.threads()) {
    const auto known = std::ranges::find(threads_, thread.id, &Moving::id);
    now.push_back(known != threads_.end() ? *known : made(thread));
    look(now.back(), thread, scene.model().mass);
    if (!thread.is_sewn() && thread.thread.touches) {
      now.back().contacts.emplace(thread.thread, surface.of(scene), scene.model().mass.size());
    }
  }
  threads_ = std::move(now);
  gravity_ = scene.gravity();
  find_together();
}

void ThreadSet::reset(const Scene& scene, const State& state) {
  for (std::size_t row = 0; row < threads_.size(); ++row) {
    const SceneThread& wanted = scene.threads()[row];
    std::optional<ThreadContacts> contacts = std::move(threads_[row].contacts);
    threads_[row] = made(wanted);
    if (contacts) contacts->forget();
    const auto known = std::ranges::find(state.threads, wanted.name, &ThreadState::name);
    if (known != state.threads.end()) std::visit([&](auto& own) { own.restore(*known); }, threads_[row].body);
    look(threads_[row], wanted, scene.model().mass);
    threads_[row].contacts = std::move(contacts);
  }
  steps_left_ = 1;
  find_together();
}

void ThreadSet::read(const Scene& scene, State& state) const {
  state.threads.resize(threads_.size());
  std::size_t count = 0;
  for (const Moving& thread : threads_) {
    const auto own = std::ranges::find(scene.threads(), thread.id, &SceneThread::id);
    if (own == scene.threads().end()) continue;  // there may be another of that name by now
    ThreadState& now = state.threads[count++] = state_of(thread.body);
    if (thread.seen == own->changes) continue;
    Moving next{.id = thread.id, .control = thread.control, .body = thread.body};
    look(next, *own, scene.model().mass);
    now = state_of(next.body);
  }
  state.threads.resize(count);
}

const ThreadState& ThreadSet::state(const SceneThread& wanted) const {
  const auto known = std::ranges::find(threads_, wanted.id, &Moving::id);
  if (known != threads_.end()) return state_of(known->body);
  unseen_ = state_of(made(wanted).body);
  return unseen_;
}

void ThreadSet::begin_call(const Scene& scene, int steps, bool at_once) {
  if (steps == 0) return;
  steps_left_ = at_once ? 1 : steps;
  for (std::size_t row = 0; row < threads_.size(); ++row) {
    const SceneThread& wanted = scene.threads()[row];
    if (threads_[row].seen == wanted.changes) continue;
    look(threads_[row], wanted, scene.model().mass);
    find_together();
  }
}

/// A tip at `at`, m, that is elsewhere goes to the anchor in the steps that are left; null: it is there.
ThreadSet::Tip ThreadSet::tip_of(const ThreadEnd& end, const Vec3* at, TouchedParticles& touched,
                                 const FindTool& find_tool) const {
  const Anchor& anchor = end.anchor;
  Tip tip;
  if (!anchor.particles.empty()) {
    tip.in_body = true;
    for (std::size_t k = 0; k < anchor.particles.size(); ++k) {
      const TouchedParticles::Touched& particle = touched[touched.slot(anchor.particles[k])];
      tip.place += anchor.weights[k] * particle.position;
      tip.way += anchor.weights[k] * touched.dt() * particle.velocity;
    }
  } else {
    Vec3 next = tip.place = anchor.point;
    if (!anchor.tool.empty()) {
      tip.tool = find_tool(anchor.tool);
      tip.place = tip.tool.start->position + tip.tool.start->orientation * anchor.point;
      next = tip.tool.end->position + tip.tool.end->orientation * anchor.point;
    }
    tip.way = next - tip.place;
  }
  if (at == nullptr) return tip;
  const Vec3 apart = *at - tip.place, nearer = apart / steps_left_;
  if (tip.in_body) {
    tip.place = *at - nearer;
  } else {
    tip.place = *at;
    tip.way -= nearer;
  }
  return tip;
}

/// `together`: rows of the threads that are solved with it.
ThreadSet::Begun ThreadSet::begun(Moving& thread, TouchedParticles& touched, const FindTool& find_tool,
                                  std::span<const std::size_t> together) const {
  ThreadRod& rod = std::get<ThreadRod>(thread.body);
  const ThreadControl& control = thread.control;
  Begun now{.thread = &thread};
  rod.begin(touched.dt(), gravity_);
  const std::array ends{Index{0}, rod.last()};
  for (const std::size_t t : {0, 1}) {
    const ThreadEnd& end = control.ends[t];
    Tip& tip = now.tips[t];
    if (end.hold == TipHold::anchored) tip = tip_of(end, &rod.state().position[ends[t]], touched, find_tool);
    now.joined[t] = end.hold == TipHold::anchored && !tip.tool.is_free;
    if (!now.joined[t]) {
      rod.load(ends[t], end.force);
      continue;
    }
    if (!tip.in_body) {
      rod.give(ends[t], tip.way);
      continue;
    }
    // What several tips share moves all of them: by no less than this, so that none is pushed too far.
    now.mobility[t] = mobility_between(touched, end.anchor, end.anchor);
    now.mobility[t] += mobility_between(touched, end.anchor, control.ends[1 - t].anchor).cwiseAbs();
    for (const std::size_t row : together) {
      if (&threads_[row] == &thread) continue;
      for (const ThreadEnd& other : threads_[row].control.ends) {
        now.mobility[t] += mobility_between(touched, end.anchor, other.anchor).cwiseAbs();
      }
    }
    rod.attach(ends[t], tip.place, tip.way, now.mobility[t]);
  }
  for (const HeldNode& held : control.held) {
    rod.give(held.node, (held.position - rod.state().position[held.node]) / steps_left_);
  }
  return now;
}

void ThreadSet::lie(const Begun& begun, std::span<const ThreadSupport> supports, ThreadContacts::Lying& lying) {
  Moving& thread = *begun.thread;
  ThreadRod& rod = std::get<ThreadRod>(thread.body);
  const auto spared = [&](std::size_t t) { return begun.joined[t] && begun.tips[t].in_body ? nodes_in_tissue : 0; };
  lying.rod = &rod;
  lying.contacts = &*thread.contacts;
  lying.first = spared(0);
  lying.last = rod.last() - spared(1);
  lying.tools.clear();
  for (const ThreadSupport& support : supports) {
    const auto is_own = [&](std::size_t t) {
      return begun.joined[t] && thread.control.ends[t].anchor.tool == support.tool;
    };
    if (!is_own(0) && !is_own(1)) lying.tools.push_back(support);
  }
}

void ThreadSet::finish(const Begun& begun, TouchedParticles& touched) {
  ThreadRod& rod = std::get<ThreadRod>(begun.thread->body);
  const double dt = touched.dt();
  for (const std::size_t t : {0, 1}) {
    const ThreadTip tip = t == 0 ? ThreadTip::first : ThreadTip::last;
    const Anchor& anchor = begun.thread->control.ends[t].anchor;
    if (!begun.joined[t]) continue;
    Vec3 force = rod.force_at(tip);
    if (begun.tips[t].in_body) {
      const Vec3 way = rod.way(t == 0 ? 0 : rod.last());
      for (int a = 0; a < 3; ++a) {
        const double mobility = begun.mobility[t][a];
        if (mobility > 0.0) force[a] = (way[a] - begun.tips[t].way[a]) / (dt * dt * mobility);
      }
      for (std::size_t k = 0; k < anchor.particles.size(); ++k) {
        TouchedParticles::pull(touched[touched.slot(anchor.particles[k])], dt * anchor.weights[k] * force);
      }
    } else if (begun.tips[t].tool.force != nullptr) {
      pull(begun.tips[t].tool, begun.tips[t].place, force);
    }
    rod.report(tip, force);
  }
}

void ThreadSet::find_crossings(TouchedParticles& touched, const FindTool& find_tool) {
  const double dt = touched.dt();
  crossings_.start(dt);
  strands_.clear();
  for (std::size_t row = 0; row < threads_.size(); ++row) {
    Moving& thread = threads_[row];
    if (!thread.contacts) continue;
    ThreadRod& rod = std::get<ThreadRod>(thread.body);
    const VecList& position = rod.state().position;
    strands_.push_back(row);
    crossings_.add(thread.contacts->strand(rod), dt * dt * gravity_.norm());
    for (const std::size_t t : {0, 1}) {
      const ThreadEnd& end = thread.control.ends[t];
      if (end.hold != TipHold::anchored || !end.anchor.particles.empty()) continue;
      const Index node = t == 0 ? 0 : rod.last();
      crossings_.give(node, tip_of(end, &position[node], touched, find_tool).way);
    }
    for (const HeldNode& held : thread.control.held) {
      crossings_.give(held.node, (held.position - position[held.node]) / steps_left_);
    }
  }
  crossings_.find();
}

/// Free threads in order, with what may touch the first one in the step.
void ThreadSet::act_free(TouchedParticles& touched, const FindTool& find_tool,
                         std::span<const ThreadSupport> supports) {
  find_crossings(touched, find_tool);
  for (std::size_t row = 0, strand = 0; row < threads_.size(); ++row) {
    if (!std::holds_alternative<ThreadRod>(threads_[row].body)) continue;
    begun_.clear();
    if (!threads_[row].contacts) {
      rows_.assign(1, row);
      begun_.push_back(begun(threads_[row], touched, find_tool, rows_));
      std::get<ThreadRod>(threads_[row].body).solve();
    } else {
      const std::size_t first = strand++;
      if (crossings_.first_of(first) != first) continue;
      rows_.clear();
      for (std::size_t s = first; s < strands_.size(); ++s) {
        if (crossings_.first_of(s) != first) continue;
        if (rows_.size() == lying_.size()) lying_.emplace_back();
        lying_[rows_.size()].strand = s;
        rows_.push_back(strands_[s]);
      }
      for (std::size_t k = 0; k < rows_.size(); ++k) {
        begun_.push_back(begun(threads_[rows_[k]], touched, find_tool, rows_));
        lie(begun_.back(), supports, lying_[k]);
      }
      crossings_.begin(first);
      ThreadContacts::solve(std::span(lying_).first(rows_.size()), crossings_, touched);
    }
    for (const Begun& begun : begun_) finish(begun, touched);
  }
}

void ThreadSet::act(Together& together, TouchedParticles& touched, const FindTool& find_tool) {
  ThreadTensions& all = together.tensions;
  all.clear();
  const auto path = [&](std::size_t row) -> ThreadPath& { return std::get<ThreadPath>(threads_[row].body); };
  for (const std::size_t row : together.rows) {
    const ThreadControl& control = threads_[row].control;
    const ThreadState& state = path(row).state();
    std::array<ThreadPath::Outside, 2> outside;
    for (const std::size_t t : {0, 1}) {
      tips_[row][t] = {};
      if (control.ends[t].hold != TipHold::anchored || !control.ends[t].anchor.particles.empty()) continue;
      const Vec3* const at = state.anchored[t] ? &state.position[t == 0 ? 0 : state.position.size() - 1] : nullptr;
      Tip& tip = tips_[row][t] = tip_of(control.ends[t], at, touched, find_tool);
      outside[t] = {tip.place, tip.place + tip.way, tip.tool.is_free};
    }
    path(row).begin(touched, outside, steps_left_);
    path(row).put_segments(all);
  }
  for (const std::size_t row : together.rows) path(row).put_knots(all);
  if (!all.pieces.empty()) all.solve(touched);
  for (const std::size_t row : together.rows) {
    path(row).take(touched, all);
    for (const std::size_t t : {0, 1}) {
      const Tip& tip = tips_[row][t];
      if (tip.tool.force == nullptr) continue;
      pull(tip.tool, tip.place, path(row).force_at(t == 0 ? ThreadTip::first : ThreadTip::last));
    }
  }
}

void ThreadSet::find_together() {
  sewn_.clear();
  tips_.resize(threads_.size());
  std::vector<std::vector<Index>> particles;  // of each, with multiples
  for (std::size_t row = 0; row < threads_.size(); ++row) {
    const auto* const path = std::get_if<ThreadPath>(&threads_[row].body);
    if (path == nullptr) continue;
    Together own{.rows = {row}, .tensions = {}};
    std::vector<Index> at = path->particles();
    for (std::size_t known = 0; known < sewn_.size();) {
      const bool shares = std::ranges::any_of(at, [&](Index i) { return std::ranges::count(particles[known], i) > 0; });
      if (!shares) {
        ++known;
        continue;
      }
      own.rows.insert(own.rows.end(), sewn_[known].rows.begin(), sewn_[known].rows.end());
      at.insert(at.end(), particles[known].begin(), particles[known].end());
      sewn_.erase(sewn_.begin() + static_cast<std::ptrdiff_t>(known));
      particles.erase(particles.begin() + static_cast<std::ptrdiff_t>(known));
    }
    std::ranges::sort(own.rows);
    sewn_.push_back(std::move(own));
    particles.push_back(std::move(at));
  }
}

void ThreadSet::act(TouchedParticles& touched, const FindTool& find_tool, std::span<const ThreadSupport> supports) {
  act_free(touched, find_tool, supports);
  for (Together& together : sewn_) act(together, touched, find_tool);
}

void ThreadSet::follow_needle(std::string_view needle, std::span<const std::pair<Anchor, Vec3>> passed,
                              const ToolPose& pose) {
  if (passed.empty()) return;
  for (Moving& thread : threads_) {
    auto* const path = std::get_if<ThreadPath>(&thread.body);
    const Anchor& tail = thread.control.ends[1].anchor;
    if (path == nullptr || thread.control.ends[1].hold != TipHold::anchored || tail.tool != needle) continue;
    const Vec3 tip = pose.position + pose.orientation * tail.point;
    for (const auto& [anchor, place] : passed) path->append(anchor, place, tip);
  }
  find_together();
}

bool ThreadSet::is_finite() const {
  return std::ranges::all_of(threads_, [](const Moving& thread) {
    return std::visit([](const auto& own) { return own.is_finite(); }, thread.body);
  });
}

void ThreadSet::drop() {
  bool any = false;
  for (Moving& thread : threads_) {
    if (auto* const path = std::get_if<ThreadPath>(&thread.body)) any = path->drop() || any;
  }
  if (any) find_together();
}

void ThreadSet::accept() {
  for (Moving& thread : threads_) std::visit([](auto& own) { own.accept(); }, thread.body);
  steps_left_ = std::max(1, steps_left_ - 1);
}

}  // namespace phymul
