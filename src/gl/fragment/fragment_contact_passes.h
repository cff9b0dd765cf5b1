// SPDX-License-Identifier: MIT
//
// The passes of a step in which bodies touch, between free_pass.glsl and the motion: trees, who meets whom, the order
// in which contacts are pressed, a draw for each phase of the sweeps, and what they come to. Made where a scene has
// contacts.
#pragma once

#include "fragment_contacts.h"

namespace phymul::gl {

class FragmentContactPasses {
 public:
  /// Compiles.
  explicit FragmentContactPasses(const ShaderLibrary& library);

  void set_contacts(FragmentContacts& contacts);
  void set_step(double dt);
  /// Where the next step stands open, in place of FragmentContacts::free.
  void set_free(const OpenStep& open);

  /// Of a step from places `displacement`, which has been opened in FragmentContacts::free_target. What it comes to is
  /// in pushed_force and pushed_shift there.
  void act(const Texture& displacement, int batch_step);
  /// Brings down what the steps of a batch told, up to this one.
  void sum(int last_step);

 private:
  void press(int batch_step);

  Pass surfaces_, mean_first_, mean_, fastest_first_, fastest_, triangle_boxes_, search_, corner_boxes_, next_, start_,
      phase_, part_, told_first_, told_;
  FragmentContacts* contacts_ = nullptr;
};

}  // namespace phymul::gl
