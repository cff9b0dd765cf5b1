// SPDX-License-Identifier: MIT
#include "fragment_joints.h"

#include <span>
#include <utility>

namespace phymul::gl {

FragmentJoints::FragmentJoints(FloatJoints joints)
    : state(joints.count(), static_cast<int>(FragmentLayers::host_texels), "forces of joints"),
      joints_(std::move(joints)),
      laws_(Texture::table(std::span<const Float4>(joints_.laws()), "joint_laws")) {
  springs_.add("joint_springs", joints_.springs());
  springs_.add("joint_anchors", joints_.anchors());
  springs_.add("joint_places", joints_.places());
  ends_.add("joint_ranges", joints_.ranges());
  ends_.add("joint_ends", joints_.ends());
}

void FragmentJoints::follow() {
  if (joints_.follow()) laws_.upload(std::span<const Float4>(joints_.laws()));
}

void FragmentJoints::bind(Pass& pass) const {
  springs_.bind(pass);
  pass.input("joint_laws", laws_);
}

void FragmentJoints::bind_gathering(Pass& pass) const {
  ends_.bind(pass);
  pass.input("joint_state", state.texture(0));
}

}  // namespace phymul::gl
