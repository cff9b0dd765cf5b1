// SPDX-License-Identifier: MIT
#include "fragment_surfaces.h"

namespace phymul::gl {

FragmentSurfaces::FragmentSurfaces(const FloatSurfaces& surfaces, const FloatTools& tools)
    : SurfaceTools(surfaces.law_of),
      patches_(surfaces.patches()),
      particles_(static_cast<int>(surfaces.ranges.size())),
      load_(Texture::target(patches_, "loads of patches")),
      push_(Texture::target(std::int64_t{2} * patches_, "impulses on patches", 3)),
      open_{OpenStep(particles_), OpenStep(particles_)},
      given_(Texture::target(particles_, "impulses of tools", tools.count())) {
  tables_.add("patch_corners", surfaces.corners);
  tables_.add("patch_laws", surfaces.laws);
  tables_.add("patch_points", surfaces.points);
  tables_.add("patch_ranges", surfaces.ranges);
  tables_.add("patch_around", surfaces.around);
  for (Texture& texture : first_) texture = Texture::target(particles_, "corners of patches");
  first_target = Framebuffer({{&first_[0]}, {&first_[1]}});
  load_target = Framebuffer({{&load_}});
  push_target = Framebuffer({{&push_, 0}, {&push_, 1}, {&push_, 2}});
  for (std::size_t turn = 0; turn < rounds_.size(); ++turn) {
    auto& own = rounds_[turn];
    for (Texture& texture : own) texture = Texture::target(particles_, "corners of patches");
    round_targets_[turn] = Framebuffer({{&own[0]}, {&own[1]}, {&own[2]}, {&own[3]}});
    const OpenStep& open = open_[turn];
    for (int tool = 0; tool < tools.count(); ++tool) {
      acted_[turn].push_back(Framebuffer({{&open.force}, {&open.velocity}, {&open.shift}, {&given_, tool}}));
    }
  }
  open_target_ = Framebuffer({{&open_[0].force}, {&open_[0].velocity}, {&open_[0].shift}});
}

void FragmentSurfaces::bind(Pass& pass) const {
  tables_.bind(pass);
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

const Framebuffer& FragmentSurfaces::next_open(int tool) {
  open_turn_ = 1 - open_turn_;
  return acted_[open_turn_][static_cast<std::size_t>(tool)];
}

}  // namespace phymul::gl
