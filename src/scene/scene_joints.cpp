// SPDX-License-Identifier: MIT
//
// The joints of a scene: what is accepted, and the handles that change them.
#include <phymul/error.h>
#include <phymul/scene.h>

#include <algorithm>
#include <cmath>

#include "anchor_place.h"
#include "base/decimal.h"
#include "scene_items.h"

namespace phymul {
namespace {

std::string joint_label(std::string_view joint) {
  return "joint \"" + std::string(joint) + "\": ";
}

constexpr const char* of_handle = "joint of this handle: ";

/// Infinite is allowed.
void require_positive(std::string_view joint, const char* what, double value) {
  if (value > 0.0) return;
  throw Error(joint_label(joint) + "expected a " + what + " above 0, got " + to_decimal(value));
}

}  // namespace

Anchor at_particle(Index particle) {
  return {.particles = {particle}, .weights = {1.0}};
}

Anchor at_mean(std::vector<Index> particles) {
  Anchor anchor;
  anchor.weights.assign(particles.size(), 1.0 / static_cast<double>(particles.size()));
  anchor.particles = std::move(particles);
  if (anchor.particles.empty()) throw Error("at_mean: expected at least one particle, got none");
  return anchor;
}

Anchor at_world(const Vec3& point) {
  return {.point = point};
}

Anchor at_tool(std::string tool, const Vec3& point) {
  if (tool.empty()) throw Error("at_tool: expected a tool's name, got an empty one");
  return {.tool = std::move(tool), .point = point};
}

void Scene::require(const SceneJoint& joint, std::span<const Vec3> position) const {
  if (joint.name.empty()) throw Error("add_joint: expected a name, got an empty one");
  if (std::ranges::find(joints_, joint.name, &SceneJoint::name) != joints_.end()) {
    throw Error(joint_label(joint.name) + "there is one of that name; remove_joint it first, or take another name");
  }
  if (!position.empty() && position.size() != model_->rest.size()) {
    throw Error(joint_label(joint.name) + "expected " + std::to_string(model_->rest.size()) +
                " positions, or none; got " + std::to_string(position.size()));
  }
  for (std::size_t i = 0; i < position.size(); ++i) {
    if (!position[i].allFinite()) {
      throw Error(joint_label(joint.name) + "expected finite positions, but that of particle " + std::to_string(i) +
                  " is not");
    }
  }
  require_not_negative(joint_label(joint.name), "stiffness", joint.joint.stiffness);
  require_not_negative(joint_label(joint.name), "damping", joint.joint.damping);
  require_positive(joint.name, "breaking force", joint.joint.breaking_force);
  if (joint.joint.springs.empty()) throw Error(joint_label(joint.name) + "expected at least one spring, got none");
  for (std::size_t row = 0; row < joint.joint.springs.size(); ++row) {
    const JointSpring& spring = joint.joint.springs[row];
    const std::string own = joint_label(joint.name) + "spring " + std::to_string(row) + ": ";
    const AnchorCheck check{own, *model_, tools_};
    check(spring.a);
    check(spring.b);
    if (spring.a.particles.empty() && spring.b.particles.empty()) {
      throw Error(own + "expected an anchor at particles, got two at the world or at tools, which no spring moves");
    }
    if (spring.a == spring.b) throw Error(own + "expected two different anchors, got the same one twice");
    if (!std::isfinite(spring.rest_length)) throw Error(own + "expected a finite rest length in m");
    if (!(spring.share > 0.0) || !std::isfinite(spring.share)) {
      throw Error(own + "expected a finite share above 0, got " + to_decimal(spring.share));
    }
  }
}

JointHandle Scene::add_joint(std::string name, Joint joint, std::span<const Vec3> position) & {
  SceneJoint added{next_joint_, std::move(name), std::move(joint)};
  require(added, position);
  const std::span<const Vec3> where = position.empty() ? std::span<const Vec3>(model_->rest) : position;
  for (JointSpring& spring : added.joint.springs) {
    if (spring.rest_length >= 0.0) continue;
    Vec3 way = anchor_place(spring.b, where, tools_) - anchor_place(spring.a, where, tools_);
    if (model_->dimension == 2) way.z() = 0.0;  // tools move in space, and springs in the plane
    spring.rest_length = way.norm();
  }
  joints_.push_back(std::move(added));
  ++next_joint_;
  ++version_;
  return {*this, joints_.back().id};
}

JointHandle Scene::add_joint(Joint joint, std::span<const Vec3> position) & {
  return add_joint(default_name("joint", next_joint_, joints_), std::move(joint), position);
}

JointHandle Scene::add_joint(JointSpring spring, double stiffness, double damping, std::span<const Vec3> position) & {
  return add_joint(Joint{.springs = {std::move(spring)}, .stiffness = stiffness, .damping = damping}, position);
}

Scene& Scene::remove_joint(std::string_view name) {
  const std::uint64_t id = joint(name).id_;
  std::erase_if(joints_, [&](const SceneJoint& known) { return known.id == id; });
  ++version_;
  return *this;
}

JointHandle Scene::joint(std::string_view name) & {
  return {*this, item_named(joints_, "joint", name).id};
}

Joint& JointHandle::own() const {
  return item_with(scene_->joints_, "joint", id_).joint;
}

const Joint& JointHandle::joint() const {
  return own();
}

void JointHandle::set_stiffness(double stiffness, double damping) const {
  Joint& joint = own();
  require_not_negative(of_handle, "stiffness", stiffness);
  require_not_negative(of_handle, "damping", damping);
  joint.stiffness = stiffness;
  joint.damping = damping;
  ++scene_->values_version_;
}

void JointHandle::set_rest_length(double length) const {
  require_not_negative(of_handle, "rest length (m)", length);
  for (JointSpring& spring : own().springs) spring.rest_length = length;
  ++scene_->values_version_;
}

void JointHandle::set_rest_lengths(std::span<const double> lengths) const {
  std::vector<JointSpring>& springs = own().springs;
  if (lengths.size() != springs.size()) {
    throw Error("set_rest_lengths: expected a rest length for each of " + std::to_string(springs.size()) +
                " springs, got " + std::to_string(lengths.size()));
  }
  for (const double length : lengths) require_not_negative(of_handle, "rest length (m)", length);
  for (std::size_t row = 0; row < springs.size(); ++row) springs[row].rest_length = lengths[row];
  ++scene_->values_version_;
}

}  // namespace phymul
