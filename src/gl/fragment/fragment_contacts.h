// SPDX-License-Identifier: MIT
//
// What of a scene touches, in textures: surfaces, trees over them, and what the passes of a step write of them. And how
// many phases a step's sweeps are given, which is a guess that follows what reports tell.
#pragma once

#include <array>

#include "base/box_tree.h"
#include "device/float_contacts.h"
#include "fragment_state.h"
#include "gl/solver/contact_constants.h"
#include "reduction.h"

namespace phymul::gl {

/// A BoxTree and its boxes, drawn level by level from one pair of textures to the other.
struct FragmentTree {
  FragmentTree(const BoxTree& tree, const char* name);

  void bind_tables(Pass& pass) const;
  void bind_boxes(Pass& pass) const;
  void measure(Pass& pass);

  int size, levels = 0;
  Texture nodes, items, roots;
  std::array<std::array<Texture, 2>, 2> boxes;  // [turn]: low, high
  std::array<Framebuffer, 2> targets;
  std::size_t turn = 0;  // of the newest
};

/// What of a scene with contacts touches, known to fit before anything of it is made on the device.
struct PlannedContacts {
  /// Throws Error where shaders have too few turns of loops, or textures no room. Needs a context.
  explicit PlannedContacts(const Scene& scene);

  FloatContacts contacts;
  BoxTree triangles, corners;  ///< over triangles; over particles
  int most_phases = 0;         ///< of sweeps: as many as any step may need
};

class FragmentContacts {
 public:
  FragmentContacts(const PlannedContacts& planned, Index model_rows);

  int particles() const { return constants.particles; }
  int meetings() const { return constants.particles * constants.bodies; }  ///< most contacts that a step can have

  const ContactConstants constants;
  void bind_surfaces(Pass& pass) const;
  void bind_meetings(Pass& pass) const;
  void bind_sweeps(Pass& pass) const;

  // What passes draw into, in their order.
  OpenStep free;
  Framebuffer free_target;
  Texture moved, velocity;
  static constexpr int branch = 64;  ///< of reductions
  Reduction mean, fastest;
  FragmentTree triangles, corners;
  Texture who, nearest, normal, next_entries;
  Framebuffer surface_target, meeting_target, next_target;
  /// The other one than bind_sweeps() binds; becomes that.
  const Framebuffer& next_sweeps();
  const Texture& sweep_rows() const { return sweeps_[0].pressing; }
  const Texture& surface_rows() const { return surface_rows_; }
  Reduction told;
  /// Force and shift with what contacts push.
  Texture pushed_force, pushed_shift;
  Framebuffer pushed_target;

  int phases() const { return phases_; }
  /// Before the steps of a batch.
  void begin_batch();
  /// See() found that phases were too few: four times as many from now on. Throws Error where they are as many as any
  /// step may need, which only a device that miscounts gets to.
  void give_more_phases();
  /// The texel of `told`, to `offset` in the buffer bound to GL_PIXEL_PACK_BUFFER.
  void copy_told(std::size_t offset) const;
  /// That texel on the host; runaway_step: the first in which a particle ran away, 0: none. What comes after it was not
  /// to be done. True where a step before that took more phases than it was given.
  bool see(const Float4& reported, int runaway_step);

 private:
  struct Sweeps {
    Texture pressing, pushing, turns;
    Framebuffer target;
  };

  NamedTables surfaces_;
  Texture surface_rows_;
  std::array<Sweeps, 2> sweeps_;
  std::size_t turn_ = 0;  // of the newest
  int phases_, most_phases_, needed_ = 0;
};

}  // namespace phymul::gl
