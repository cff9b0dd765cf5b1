// SPDX-License-Identifier: MIT
#include "fragment_joints.h"

#include <span>
#include <utility>

namespace phymul::gl {

FragmentJoints::FragmentJoints(FloatJoints joints)
    : state(joints.count(), static_cast<int>(FragmentLayers::host_texels), "forces of joints"),
      joints_(std::move(joints)),
      springs_(Texture::table(std::span<const Int4>(joints_.springs()), "joint_springs")),
      anchors_(Texture::table(std::span<const Int4>(joints_.anchors()), "joint_anchors")),
      places_(Texture::table(std::span<const Float4>(joints_.places()), "joint_places")),
      laws_(Texture::table(std::span<const Float4>(joints_.laws()), "joint_laws")),
      ranges_(Texture::table(std::span<const Int4>(joints_.ranges()), "joint_ranges")),
      ends_(Texture::table(std::span<const Int4>(joints_.ends()), "joint_ends")) {}

void FragmentJoints::follow() {
  if (joints_.follow()) laws_.upload(std::span<const Float4>(joints_.laws()));
}

void FragmentJoints::bind(Pass& pass) const {
  pass.input("joint_springs", springs_);
  pass.input("joint_anchors", anchors_);
  pass.input("joint_places", places_);
  pass.input("joint_laws", laws_);
}

void FragmentJoints::bind_gathering(Pass& pass) const {
  pass.input("joint_ranges", ranges_);
  pass.input("joint_ends", ends_);
  pass.input("joint_state", state.texture(0));
}

}  // namespace phymul::gl
