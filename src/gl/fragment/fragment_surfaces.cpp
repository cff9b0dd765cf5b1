// SPDX-License-Identifier: MIT
#include "fragment_surfaces.h"

#include <span>

namespace phymul::gl {
namespace {

Texture floats(std::int64_t rows, const char* name, int layers = 0) {
  return Texture::target(rows, TexelFormat::rgba32f, name, layers);
}

}  // namespace

FragmentSurfaces::FragmentSurfaces(const FloatSurfaces& surfaces, const FloatTools& tools)
    : patches_(surfaces.patches()),
      particles_(static_cast<int>(surfaces.ranges.size())),
      law_of_(surfaces.law_of),
      corners_(Texture::table(std::span<const Int4>(surfaces.corners), "patch_corners")),
      laws_(Texture::table(std::span<const Int4>(surfaces.laws), "patch_laws")),
      points_(Texture::table(std::span<const Float4>(surfaces.points), "patch_points")),
      ranges_(Texture::table(std::span<const Int4>(surfaces.ranges), "patch_ranges")),
      around_(Texture::table(std::span<const Int4>(surfaces.around), "patch_around")),
      load_(floats(patches_, "loads of patches")),
      push_(floats(std::int64_t{2} * patches_, "impulses on patches", 3)),
      given_(floats(particles_, "impulses of tools", tools.count())) {
  for (Texture& texture : first_) texture = floats(particles_, "corners of patches");
  first_target = Framebuffer({{&first_[0]}, {&first_[1]}});
  load_target = Framebuffer({{&load_}});
  push_target = Framebuffer({{&push_, 0}, {&push_, 1}, {&push_, 2}});
  for (std::size_t turn = 0; turn < rounds_.size(); ++turn) {
    auto& own = rounds_[turn];
    for (Texture& texture : own) texture = floats(particles_, "corners of patches");
    round_targets_[turn] = Framebuffer({{&own[0]}, {&own[1]}, {&own[2]}, {&own[3]}});
    for (Texture& texture : open_[turn]) texture = floats(particles_, "a step before its motion");
  }
  open_target_ = Framebuffer({{&open_[0][0]}, {&open_[0][1]}, {&open_[0][2]}});
  for (std::size_t turn = 0; turn < open_.size(); ++turn) {
    for (int tool = 0; tool < tools.count(); ++tool) {
      acted_[turn].push_back(Framebuffer({{&open_[turn][0]}, {&open_[turn][1]}, {&open_[turn][2]}, {&given_, tool}}));
    }
  }
}

void FragmentSurfaces::bind(Pass& pass) const {
  pass.input("patch_corners", corners_);
  pass.input("patch_laws", laws_);
  pass.input("patch_points", points_);
  pass.input("patch_ranges", ranges_);
  pass.input("patch_around", around_);
  pass.input("first_end", first_[0]);
  pass.input("first_way", first_[1]);
  pass.input("patch_load", load_);
  pass.input("patch_push", push_);
  pass.set("patch_count", patches_);
}

void FragmentSurfaces::bind_corners(Pass& pass) const {
  const auto& newest = rounds_[round_turn_];
  pass.input("corner_end", newest[0]);
  pass.input("corner_way", newest[1]);
  pass.input("corner_given", newest[2]);
  pass.input("corner_shift", newest[3]);
}

const Framebuffer& FragmentSurfaces::next_corners() {
  round_turn_ = 1 - round_turn_;
  return round_targets_[round_turn_];
}

const Framebuffer& FragmentSurfaces::open_target() {
  open_turn_ = 0;
  return open_target_;
}

void FragmentSurfaces::bind_open(Pass& pass) const {
  const auto& newest = open_[open_turn_];
  pass.input("pushed_force", newest[0]);
  pass.input("free_velocity", newest[1]);
  pass.input("pushed_shift", newest[2]);
}

const Framebuffer& FragmentSurfaces::next_open(int tool) {
  open_turn_ = 1 - open_turn_;
  return acted_[open_turn_][static_cast<std::size_t>(tool)];
}

}  // namespace phymul::gl
