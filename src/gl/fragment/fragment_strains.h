// SPDX-License-Identifier: MIT
//
// The strains that the domains of a body keep whose material dissipates, and the constants of its material: rows of
// FloatDissipation.
#pragma once

#include "device/float_dissipation.h"
#include "fragment_layers.h"
#include "gl/objects/pass.h"
#include "gl/solver/body_kind.h"

namespace phymul::gl {

class FragmentStrains {
 public:
  static_assert(FragmentLayers::host_texels == FloatDissipation::strain_texels);

  explicit FragmentStrains(const BodyKind& kind)
      : kept(kind.domains, kind.strain_texels(), "strains of domains"),
        constants_(Texture::target(std::int64_t{2} * kind.domains, "dissipation")) {}

  void set_constants(std::span<const Float4> constants) { constants_.upload(constants); }
  /// The constants, and the strains of a pair.
  void bind(Pass& pass, int pair) const {
    pass.input("dissipation", constants_);
    pass.input("strains", kept.texture(pair));
  }

  FragmentLayers kept;

 private:
  Texture constants_;
};

}  // namespace phymul::gl
