// SPDX-License-Identifier: MIT
//
// The tools, joints and threads of a scene in a snapshot.
#include <phymul/distance_grid.h>
#include <phymul/scene.h>
#include <phymul/state.h>

#include <algorithm>

namespace phymul {
namespace {

bool same(const Tool& a, const Tool& b) {
  using Grid = std::shared_ptr<const DistanceGrid>;
  const auto *of_a = std::get_if<Grid>(&a.shape), *of_b = std::get_if<Grid>(&b.shape);
  const bool same_shape = of_a && of_b ? **of_a == **of_b : a.shape == b.shape;
  return same_shape && a.friction == b.friction && a.compliance == b.compliance && a.margin == b.margin &&
         a.contact == b.contact && a.suction == b.suction && a.suction_reach == b.suction_reach;
}

bool same(const Joint& a, const Joint& b) {
  return a == b;
}

/// But for what a JointHandle changes.
bool same_springs(Joint a, const Joint& b) {
  if (a.springs.size() != b.springs.size()) return false;
  a.stiffness = b.stiffness;
  a.damping = b.damping;
  for (std::size_t row = 0; row < a.springs.size(); ++row) a.springs[row].rest_length = b.springs[row].rest_length;
  return a == b;
}

bool same(const SceneThread& a, const SceneThread& b) {
  return a.name == b.name && a.thread == b.thread && a.start == b.start && a.passages == b.passages &&
         (!a.passages.empty() || a.direction == b.direction);
}

/// The first that differs; empty: none.
template <class Items>
std::string difference(const std::string& kind, const Items& a, const Items& b) {
  for (std::size_t row = 0; row < std::max(a.size(), b.size()); ++row) {
    if (row < a.size() && row < b.size() && a[row].first == b[row].first && same(a[row].second, b[row].second))
      continue;
    return kind + " \"" + (row < a.size() ? a : b)[row].first + '"';
  }
  return {};
}

}  // namespace

std::string difference(const SceneParts& a, const SceneParts& b) {
  const std::string tool = difference("tool", a.tools, b.tools);
  if (!tool.empty()) return tool;
  if (const std::string joint = difference("joint", a.joints, b.joints); !joint.empty()) return joint;
  for (std::size_t row = 0; row < std::max(a.threads.size(), b.threads.size()); ++row) {
    if (row < std::min(a.threads.size(), b.threads.size()) && same(a.threads[row], b.threads[row])) continue;
    return "thread \"" + (row < a.threads.size() ? a : b).threads[row].name + '"';
  }
  return {};
}

SceneParts Scene::parts() const {
  SceneParts parts;
  for (const SceneTool& tool : tools_) parts.tools.emplace_back(tool.name, tool.tool);
  for (const SceneJoint& joint : joints_) parts.joints.emplace_back(joint.name, joint.joint);
  parts.threads = threads_;
  return parts;
}

ThreadHandle Scene::add_thread(const SceneThread& thread) & {
  if (!thread.is_sewn()) return add_thread(thread.name, thread.thread, thread.start, thread.direction);
  if (thread.passages.empty()) return swage(thread.name, thread.thread, {});
  const ThreadHandle added = sew(thread.name, thread.thread, thread.passages);
  added.own().direction = thread.direction;
  return added;
}

/// A thread that stays keeps its id.
void Scene::bring_back_threads(const std::vector<SceneThread>& wanted) {
  const std::vector<SceneThread> before = std::exchange(threads_, {});
  for (const SceneThread& thread : wanted) {
    add_thread(thread).set(thread.control);
    const auto own = std::ranges::find_if(before, [&](const SceneThread& known) { return same(known, thread); });
    if (own == before.end()) continue;
    threads_.back().id = own->id;
    threads_.back().changes = std::max(own->changes, threads_.back().changes) + 1;
    --next_thread_;
  }
}

Scene& Scene::bring_back(const SceneParts& wanted) {
  if (parts() == wanted) {
    for (const SceneThread& thread : wanted.threads) {
      const ThreadHandle own = this->thread(thread.name);
      own.own().direction = thread.direction;  // whether a needle may have made passages, so that knots have their rows
      own.set(thread.control);
    }
    return *this;
  }
  Scene next = copy();  // add_tool() and add_joint() check what is added
  next.tools_.clear();
  next.joints_.clear();
  for (const auto& [name, tool] : wanted.tools) {
    next.add_tool(name, tool);
    const auto own = std::ranges::find(tools_, name, &SceneTool::name);
    if (own == tools_.end() || !same(own->tool, tool)) continue;
    next.tools_.back() = *own;
    --next.next_tool_;
  }
  for (const auto& [name, joint] : wanted.joints) {
    next.add_joint(name, joint);
    const auto own = std::ranges::find(joints_, name, &SceneJoint::name);
    if (own == joints_.end() || !same_springs(own->joint, joint)) continue;
    next.joints_.back().id = own->id;
    --next.next_joint_;
  }
  next.bring_back_threads(wanted.threads);
  tools_ = std::move(next.tools_);
  joints_ = std::move(next.joints_);
  threads_ = std::move(next.threads_);
  next_thread_ = next.next_thread_;
  next_tool_ = next.next_tool_;
  next_joint_ = next.next_joint_;
  ++version_;
  return *this;
}

}  // namespace phymul
