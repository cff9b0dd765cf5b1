// SPDX-License-Identifier: MIT
#include "joint_bytes.h"

namespace phymul {
namespace {

// What a thing is made of, for a ByteWriter and a thing that is const, or a ByteReader and one that is not.

template <class Bytes, class Any>
void anchor_fields(Bytes& bytes, Any& anchor) {
  bytes.field(anchor.particles, "an anchor's particles");
  bytes.list(anchor.weights, 8, "a number of weights", [&](auto& weight) { bytes.field(weight, "a weight"); });
  bytes.field(anchor.tool, "an anchor's tool");
  bytes.field(anchor.point, "an anchor's point");
}

template <class Bytes, class Any>
void joint_fields(Bytes& bytes, Any& joint) {
  bytes.list(joint.springs, 104, "a number of springs", [&](auto& spring) {
    anchor_fields(bytes, spring.a);
    anchor_fields(bytes, spring.b);
    bytes.field(spring.rest_length, "a rest length");
    bytes.field(spring.share, "a spring's share");
  });
  bytes.field(joint.stiffness, "a joint's stiffness");
  bytes.field(joint.damping, "a joint's damping");
  bytes.field(joint.slack, "whether a joint is slack");
  bytes.field(joint.breaking_force, "a breaking force");
}

}  // namespace

std::string joint_value_bytes(const Joint& joint) {
  ByteWriter out;
  out.real(joint.stiffness);
  out.real(joint.damping);
  out.u64(joint.springs.size());
  for (const JointSpring& spring : joint.springs) out.real(spring.rest_length);
  return out.bytes();
}

void change_joint_values(const JointHandle& joint, ByteReader& in) {
  const double stiffness = in.real("a joint's stiffness"), damping = in.real("a joint's damping");
  std::vector<double> lengths(in.count(8, "a number of rest lengths"));
  for (double& length : lengths) length = in.real("a rest length");
  joint.set_stiffness(stiffness, damping);
  joint.set_rest_lengths(lengths);
}

void put_joint(ByteWriter& out, const SceneJoint& joint) {
  out.text(joint.name);
  joint_fields(out, joint.joint);
}

void take_joint(ByteReader& in, Scene& scene) {
  std::string name = in.text("a joint's name");
  Joint joint;
  joint_fields(in, joint);
  scene.add_joint(std::move(name), std::move(joint));
}

}  // namespace phymul
