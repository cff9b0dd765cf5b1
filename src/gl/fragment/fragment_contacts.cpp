// SPDX-License-Identifier: MIT
#include "fragment_contacts.h"

#include <phymul/error.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <span>
#include <string>

#include "gl/context/context_info.h"

namespace phymul::gl {
namespace {

constexpr int first_phases = 8;            // of a scene that has told nothing yet
constexpr std::int64_t counted = 1 << 24;  // what shaders count in floats

/// Few levels, as each is a draw; small leaves, as fragments look at all items of one.
constexpr BoxTree::Shape shallow{.leaf_size = 2, .halvings = 3};

BoxTree triangle_tree(const FloatContacts& contacts) {
  VecList middles;
  std::vector<Index> body;
  for (const Int4& own : contacts.triangle) {
    Vec3 middle = Vec3::Zero();
    for (int c = 0; c < 3; ++c) {
      const Float4& X = contacts.rest[2 * static_cast<std::size_t>(own[c])];
      middle += Vec3(X[0], X[1], X[2]) / 3.0;
    }
    middles.push_back(middle);
    body.push_back(own[3] >> 1);
  }
  return {middles, body, contacts.bodies, shallow};
}

/// Bodies without triangles are a group of their own: their particles meet others.
BoxTree particle_tree(const FloatContacts& contacts) {
  VecList places;
  std::vector<Index> body;
  for (std::size_t k = 0; k < contacts.particle.size(); ++k) {
    const Float4& X = contacts.rest[2 * k];
    places.push_back({X[0], X[1], X[2]});
    body.push_back(contacts.particle[k][1] + 1);
  }
  return {places, body, contacts.bodies + 1, shallow};
}

/// As contact_tree.glsl has them; level 1 are leaves, others one above their highest child.
std::vector<Int4> node_rows(const BoxTree& tree) {
  std::vector<Int4> rows(tree.nodes.size());
  for (std::size_t own = rows.size(); own-- > 0;) {  // children stand behind their parents
    const BoxTree::Node& node = tree.nodes[own];
    rows[own] = {node.first, node.end, node.next, 1};
    if (node.is_leaf) continue;
    for (auto child = static_cast<Index>(own) + 1; child < node.next; child = tree.nodes[child].next) {
      rows[own][3] = std::max(rows[own][3], rows[static_cast<std::size_t>(child)][3] + 1);
    }
  }
  return rows;
}

/// First node and end of each group's.
std::vector<Int2> root_rows(const BoxTree& tree) {
  std::vector<Int2> rows;
  for (std::size_t group = 0; group + 1 < tree.groups.size(); ++group) {
    rows.push_back({tree.groups[group], tree.groups[group + 1]});
  }
  return rows;
}

/// Renderers that break off a shader's loops: half of the turns are left to what is not counted, the last look of every
/// loop and lanes that go different ways.
void require_turns(const PlannedContacts& planned, std::int64_t loop_turns) {
  const FloatContacts& contacts = planned.contacts;
  // A fragment may look at every item of a tree, at every node, and begin anew behind every leaf.
  const auto triangles = static_cast<std::int64_t>(contacts.triangle.size() + 2 * planned.triangles.nodes.size()),
             particles = static_cast<std::int64_t>(contacts.particle.size() + 2 * planned.corners.nodes.size());
  const std::int64_t turns =
      std::max(triangles, particles + contacts.bodies + shallow.leaf_size * (contacts.bodies + 1));
  if (turns <= loop_turns / 2) return;
  throw Error(ErrorCode::not_supported,
              "expected contacts that take at most " + std::to_string(loop_turns / 2) +
                  " turns of a shader's loops, half of where this renderer breaks off, got up to " +
                  std::to_string(turns) + " for surfaces of " + std::to_string(contacts.particle.size()) +
                  " particles and " + std::to_string(contacts.triangle.size()) + " triangles; use the backend \"cpu\"");
}

/// Each phase presses at least one contact, so that no step takes more.
int phases_that_suffice(const FloatContacts& contacts) {
  const std::int64_t meetings = static_cast<std::int64_t>(contacts.particle.size()) * contacts.bodies;
  if (meetings * contacts.options.rounds < counted) return static_cast<int>(meetings * contacts.options.rounds);
  throw Error(ErrorCode::not_supported, "expected contacts times rounds of less than " + std::to_string(counted) +
                                            ", got up to " + std::to_string(meetings) + " contacts in " +
                                            std::to_string(contacts.options.rounds) +
                                            " rounds; use fewer rounds, \"gl-compute\" or \"cpu\"");
}

}  // namespace

FragmentTree::FragmentTree(const BoxTree& tree, const char* name)
    : size(static_cast<int>(tree.nodes.size())),
      items(Texture::table(std::span<const std::int32_t>(tree.items), name)),
      roots(Texture::table(std::span<const Int2>(root_rows(tree)), name)) {
  const std::vector<Int4> rows = node_rows(tree);
  for (const Int4& node : rows) levels = std::max(levels, node[3]);
  nodes = Texture::table(std::span<const Int4>(rows), name);
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    for (Texture& side : boxes[k]) side = Texture::target(size, name);
    targets[k] = Framebuffer({{&boxes[k][0]}, {&boxes[k][1]}});
  }
}

void FragmentTree::bind_tables(Pass& pass) const {
  pass.input("tree_nodes", nodes);
  pass.input("tree_items", items);
  pass.input("tree_roots", roots);
  pass.set("tree_size", size);
}

void FragmentTree::bind_boxes(Pass& pass) const {
  pass.input("tree_low", boxes[turn][0]);
  pass.input("tree_high", boxes[turn][1]);
}

void FragmentTree::measure(Pass& pass) {
  pass.set_rows(boxes[0][0], size);
  for (int level = 1; level <= levels; ++level) {
    bind_boxes(pass);
    turn = 1 - turn;
    pass.set("tree_level", level);
    pass.draw(targets[turn]);
  }
}

PlannedContacts::PlannedContacts(const Scene& scene)
    : contacts(scene), triangles(triangle_tree(contacts)), corners(particle_tree(contacts)) {
  if (contacts.empty()) return;
  most_phases = phases_that_suffice(contacts);
  require_turns(*this, read_context_info().loop_turns);
  // Of all tables and targets that with the most rows.
  fit_texture(4 * static_cast<std::int64_t>(contacts.particle.size()) * contacts.bodies, largest_side(),
              "lists of contacts");
}

FragmentContacts::FragmentContacts(const PlannedContacts& planned, Index model_rows)
    : constants(planned.contacts),
      free(model_rows),
      free_target({{&free.force}, {&free.velocity}, {&free.shift}}),
      moved(Texture::target(static_cast<std::int64_t>(planned.contacts.particle.size()), "places of surfaces")),
      velocity(Texture::target(moved.rows(), "velocities of surfaces")),
      mean(static_cast<int>(moved.rows()), branch, {{"speeds"}}, "mean velocity of surfaces"),
      fastest(static_cast<int>(moved.rows()), branch, {{"speeds"}}, "largest speed of surfaces"),
      triangles(planned.triangles, "trees of triangles"),
      corners(planned.corners, "trees of contacts"),
      told(static_cast<int>(moved.rows()), branch, {{"told"}}, "phases of sweeps"),
      most_phases_(planned.most_phases) {
  surfaces_.add("surface", planned.contacts.particle);
  surfaces_.add("surface_rest", planned.contacts.rest);
  surfaces_.add("triangle", planned.contacts.triangle);
  surfaces_.add("triangle_law", planned.contacts.triangle_law);
  phases_ = std::min(first_phases, most_phases_);
  std::vector<std::int32_t> rows(static_cast<std::size_t>(model_rows), -1);
  for (int k = 0; k < particles(); ++k) rows[static_cast<std::size_t>(planned.contacts.particle[k][0])] = k;
  surface_rows_ = Texture::table(std::span<const std::int32_t>(rows), "surface_rows");
  surface_target = Framebuffer({{&moved}, {&velocity}});
  const std::int64_t most = meetings();
  who = Texture::target(most, TexelFormat::rgba32i, "contacts");
  nearest = Texture::target(most, "nearest points");
  normal = Texture::target(most, "normals of contacts");
  meeting_target = Framebuffer({{&who}, {&nearest}, {&normal}});
  next_entries = Texture::target(4 * most, TexelFormat::r32i, "lists of contacts");
  next_target = Framebuffer({{&next_entries}});
  for (Sweeps& sweeps : sweeps_) {
    sweeps.pressing = Texture::target(particles() + most, "velocities in sweeps");
    sweeps.pushing = Texture::target(particles() + most, "impulses of sweeps");
    sweeps.turns = Texture::target(particles() + most, TexelFormat::rgba32i, "turns of sweeps");
    sweeps.target = Framebuffer({{&sweeps.pressing}, {&sweeps.pushing}, {&sweeps.turns}});
  }
  pushed_force = Texture::target(model_rows, "forces with contacts");
  pushed_shift = Texture::target(model_rows, "shifts with contacts");
  pushed_target = Framebuffer({{&pushed_force}, {&pushed_shift}});
}

void FragmentContacts::bind_surfaces(Pass& pass) const {
  surfaces_.bind(pass);
  pass.input("surface_moved", moved);
  pass.input("surface_velocity", velocity);
}

void FragmentContacts::bind_meetings(Pass& pass) const {
  pass.input("meeting_who", who);
  pass.input("meeting_nearest", nearest);
  pass.input("meeting_normal", normal);
  pass.input("next_entries", next_entries);
}

void FragmentContacts::bind_sweeps(Pass& pass) const {
  pass.input("pressing", sweeps_[turn_].pressing);
  pass.input("pushing", sweeps_[turn_].pushing);
  pass.input("turns", sweeps_[turn_].turns);
}

const Framebuffer& FragmentContacts::next_sweeps() {
  turn_ = 1 - turn_;
  return sweeps_[turn_].target;
}

/// A quarter more than the last batch needed, at once where that is more than before, else in quarters of the way.
void FragmentContacts::begin_batch() {
  const int wanted = std::min(needed_ + needed_ / 4 + 2, most_phases_);
  phases_ = std::max(wanted, phases_ - (phases_ + 3) / 4);
}

void FragmentContacts::give_more_phases() {
  if (phases_ == most_phases_) {
    throw Error(ErrorCode::not_supported,
                "expected the sweeps over contacts to end within " + std::to_string(most_phases_) +
                    " phases, one for each contact and round, got some that did not; use \"gl-compute\" or \"cpu\"");
  }
  phases_ = static_cast<int>(std::min<std::int64_t>(4 * std::int64_t{phases_}, most_phases_));
}

void FragmentContacts::copy_told(std::size_t offset) const {
  told.target().read(0, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(offset));  // an offset in the buffer
}

bool FragmentContacts::see(const Float4& reported, int runaway_step) {
  const int step = static_cast<int>(reported[0]);
  const bool unfinished = step > 0 && (runaway_step == 0 || step <= runaway_step);
  if (!unfinished) needed_ = static_cast<int>(reported[1]);
  return unfinished;
}

}  // namespace phymul::gl
