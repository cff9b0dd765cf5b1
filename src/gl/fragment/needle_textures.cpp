// SPDX-License-Identifier: MIT
#include "fragment_needles.h"

#include <algorithm>

namespace phymul::gl {
namespace {

Texture target(std::int64_t rows, const char* name = "what passes write of a needle") {
  return Texture::target(rows, TexelFormat::rgba32f, name);
}

/// `beside`: drawn with the first of them.
std::vector<NeedleTextures::Level> levels_of(int terms, const Texture* beside) {
  std::vector<NeedleTextures::Level> levels;
  int rows = std::max(terms, 1);  // without terms a row says so
  do {
    rows = (rows + NeedleTextures::branch - 1) / NeedleTextures::branch;
    NeedleTextures::Level& level = levels.emplace_back();
    level.count = rows;
    std::vector<Attachment> attachments;
    for (Texture& texture : level.rows) {
      texture = target(rows);
      attachments.push_back({&texture});
    }
    if (beside && levels.size() == 1) attachments.push_back({beside});
    level.target = Framebuffer(attachments);
  } while (rows > 1);
  return levels;
}

}  // namespace

NeedleTextures::NeedleTextures(const FloatNeedles::One& law, int particles, int facet_count) {
  const std::int64_t nodes = law.nodes;
  lists = Texture::target(nodes * law.particles, TexelFormat::rg32i, "a needle's hole");
  lists_target = Framebuffer({{&lists}});
  for (std::size_t k = 0; k < 3; ++k) {
    parts[k] = target(nodes * team);
    means[k] = target(nodes);
  }
  parts_target = Framebuffer({{&parts[0]}, {&parts[1]}, {&parts[2]}});
  means_target = Framebuffer({{&means[0]}, {&means[1]}, {&means[2]}});
  who = Texture::target((particles + branch - 1) / branch, TexelFormat::r32i, "who is around a needle's tip");
  facets = levels_of(facet_count, nullptr);
  around = levels_of(particles, &who);
  found = Texture::target(law.particles, TexelFormat::r32i, "who is around a needle's tip");
  found_target = Framebuffer({{&found}});
  coupling = target(nodes * nodes);
  coupling_target = Framebuffer({{&coupling}});
  marks = Texture::target(particles, TexelFormat::rg32i, "who is around a needle");
  marks_target = Framebuffer({{&marks}});
  impulses = target(nodes);
  node_ends = target(nodes);
  for (std::size_t k = 0; k < 2; ++k) {
    turn_parts[k] = target(nodes * team);
    twists[k] = target(nodes);
  }
  turn_parts_target = Framebuffer({{&turn_parts[0]}, {&turn_parts[1]}});
  twists_target = Framebuffer({{&twists[0]}, {&twists[1]}});
  for (std::size_t turn = 0; law.bends() && turn < 2; ++turn) {
    stiffness[turn] = Texture::target(nodes * nodes + nodes, TexelFormat::rg32f, "how a needle's shaft gives way");
    stiffness_targets[turn] = Framebuffer({{&stiffness[turn]}});
  }
  if (law.bends()) {
    panel = Texture::target(nodes * pivots, TexelFormat::rg32f, "how a needle's shaft gives way");
    panel_target = Framebuffer({{&panel}});
    holds = target(nodes);
    holds_target = Framebuffer({{&holds}});
  }
  for (std::size_t turn = 0; turn < 2; ++turn) {
    state[turn] = target(8 + 2 * nodes, "a needle's hole");
    state_targets[turn] = Framebuffer({{&state[turn]}});
    for (Texture& texture : weights[turn]) texture = target((law.particles + branch - 1) / branch);
    weight_targets[turn] = Framebuffer({{&weights[turn][0]}, {&weights[turn][1]}});
    for (Texture& texture : settled[turn]) texture = target(nodes);
    settled_targets[turn] = Framebuffer({{&settled[turn][0]}, {&settled[turn][1]}, {&impulses}, {&node_ends}});
  }
}

}  // namespace phymul::gl
