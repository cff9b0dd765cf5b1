// SPDX-License-Identifier: MIT
//
// The springs of a scene's joints in textures.
#pragma once

#include "device/float_joints.h"
#include "fragment_layers.h"
#include "gl/objects/pass.h"

namespace phymul::gl {

class FragmentJoints {
 public:
  static_assert(FragmentLayers::host_texels == FloatJoints::state_rows);

  /// The scene must outlive it.
  explicit FragmentJoints(FloatJoints joints);

  int count() const { return joints_.count(); }
  bool any_tool() const { return joints_.any_tool(); }
  /// Takes over changed constants of the scene.
  void follow();
  /// A pass that finds the forces of springs.
  void bind(Pass& pass) const;
  /// A pass that gathers them.
  void bind_gathering(Pass& pass) const;

  FragmentLayers state;

 private:
  FloatJoints joints_;
  Texture laws_;
  NamedTables springs_, ends_;
};

}  // namespace phymul::gl
