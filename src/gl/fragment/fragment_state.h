// SPDX-License-Identifier: MIT
//
// Where the particles are, on the device: three pairs of textures, displacement (m) and velocity (m/s).
#pragma once

#include <phymul/state.h>

#include <array>
#include <span>
#include <vector>

#include "device/float_domains.h"
#include "gl/objects/pass.h"
#include "gl/solver/body_kind.h"
#include "gl/solver/state_copies.h"

namespace phymul::gl {

/// The constants of a body on the device: FloatTables, a texture each, under the same names.
class FragmentTables {
 public:
  explicit FragmentTables(const FloatTables& tables);

  const BodyKind& kind() const { return kind_; }
  const std::vector<Index>& materials() const { return materials_; }  ///< of domains, by row

  /// Gives a pass every table it reads.
  void bind(Pass& pass) const;

 private:
  BodyKind kind_;
  std::vector<Index> materials_;
  NamedTables tables_;
  // Of FloatEntries.
  int volume_start_ = 0, spring_start_ = 0, wall_start_ = 0;
};

/// Rows of up to four texels that a step reads and writes, with each pair of FragmentState: a layer per
/// texel. Rows on the host have four.
class FragmentLayers {
 public:
  static constexpr std::size_t host_texels = 4;

  FragmentLayers(std::int64_t rows, int layers, const char* name);

  const Texture& texture(int pair) const { return textures_[pair]; }
  const Framebuffer& target(int pair) const { return targets_[pair]; }
  void write(std::span<const Float4> rows, int pair);
  std::vector<Float4> read(int pair) const;  ///< waits for the device

 private:
  int layers_;
  std::array<Texture, StatePairs::pairs> textures_;
  std::array<Framebuffer, StatePairs::pairs> targets_;
};

/// The strains that the domains of a body keep whose material dissipates, and the constants of its material: rows of
/// FloatDissipation.
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

class FragmentState : public StatePairs {
 public:
  explicit FragmentState(Index particles);

  const Texture& displacement() const { return displacement_[current()]; }
  const Texture& velocity() const { return velocity_[current()]; }
  const Texture& measured() const { return measured_; }  ///< written by steps that are drawn with `measuring`

  // Of the free pair.
  const Framebuffer& next(bool measuring) const { return (measuring ? measuring_ : plain_)[free_pair()]; }
  const Texture& next_displacement() const { return displacement_[free_pair()]; }
  const Texture& next_velocity() const { return velocity_[free_pair()]; }

  /// Framebuffer of the current state, to be read: displacement at 0, velocity at 1.
  const Framebuffer& framebuffer() const { return plain_[current()]; }

  void request_copy(StateCopies& copies, const State& header) const;
  void read(const VecList& rest, State& state) const;
  void write(const VecList& rest, const State& state);

 private:
  std::array<Texture, pairs> displacement_, velocity_;
  Texture measured_;  // speed, acceleration, force, displacement
  std::array<Framebuffer, pairs> plain_, measuring_;
};

}  // namespace phymul::gl
