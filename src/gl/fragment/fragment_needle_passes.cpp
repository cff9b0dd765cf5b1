// SPDX-License-Identifier: MIT
#include "fragment_needle_passes.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace phymul::gl {
namespace {

constexpr int sweeps = 12;  // needle_motion.glsl
const ShaderFiles common{"dialect/dialect_fragment.glsl", "step/tables.glsl",       "dialect/vector3.glsl",
                         "tools/pushed_tables.glsl",      "tools/tool_tables.glsl", "needle/needle_state.glsl",
                         "needle/needle_shaft.glsl"};
const ShaderFiles weighs{"needle/needle_weights.glsl", "needle/needle_total.glsl", "needle/needle_weights_of.glsl"};

int levels_of(int particles) {
  int levels = 0;
  for (int rows = particles; rows > 1 || levels == 0; ++levels) {
    rows = (rows + NeedleTextures::branch - 1) / NeedleTextures::branch;
  }
  return levels;
}

}  // namespace

FragmentNeedlePasses::FragmentNeedlePasses(const ShaderLibrary& library, const BodyKind& kind, std::int64_t loop_turns,
                                           bool bending)
    : library_(&library), kind_(kind), loop_turns_(loop_turns), bending_(bending) {
  parts_ = compiled({"needle/needle_motion.glsl", "needle/needle_parts_pass.glsl"});
  means_ = compiled({"needle/needle_means_pass.glsl"});
  begin_ = compiled({"needle/needle_follow.glsl", "needle/needle_begin_pass.glsl"});
  const ShaderFiles surface{"needle/needle_follow.glsl", "needle/needle_surface.glsl",
                            "needle/needle_facets_pass.glsl"};
  first_facets_ = compiled(surface, {{"FIRST", 1}});
  facets_ = compiled(surface);
  aim_ = compiled({"needle/needle_follow.glsl", "needle/needle_weights.glsl", "needle/needle_total.glsl",
                   "needle/needle_aim_pass.glsl"});
  const ShaderFiles around{"needle/needle_weights.glsl", "needle/needle_around_pass.glsl"};
  first_around_ = compiled(around, {{"FIRST", 1}});
  around_ = compiled(around);
  select_ = compiled({"needle/needle_select_pass.glsl"}, {{"LEVELS", levels_of(kind.particles)}});
  const ShaderFiles weights = joined({weighs, {"needle/needle_weights_pass.glsl"}});
  first_weights_ = compiled(weights, {{"FIRST", 1}});
  weights_ = compiled(weights);
  append_ = compiled(joined({weighs, {"needle/needle_append_pass.glsl"}}));
  marks_ = compiled({"needle/needle_marks_pass.glsl"});
  coupling_ = compiled({"needle/needle_weights.glsl", "needle/needle_coupling_pass.glsl"});
  const ShaderFiles turning{"needle/needle_motion.glsl", "needle/needle_turning.glsl"};
  turn_parts_ = compiled(joined({turning, {"needle/needle_turn_parts_pass.glsl"}}));
  twist_ = compiled({"needle/needle_motion.glsl", "needle/needle_limits.glsl", "needle/needle_twist_pass.glsl"});
  const ShaderFiles giving = joined({turning, {"needle/needle_give_pass.glsl"}});
  give_twist_ = compiled(giving, {{"TWIST", 1}});
  give_ = compiled(giving);
  ShaderFiles settling{"needle/needle_motion.glsl", "needle/needle_limits.glsl", "needle/needle_coupling.glsl",
                       "needle/needle_sweeps.glsl"};
  if (bending) {
    const ShaderFiles holding{"dialect/two_floats.glsl", "needle/needle_held.glsl"};
    const ShaderFiles held = joined({holding, {"needle/needle_pairs.glsl", "needle/needle_held_rows.glsl"}});
    const ShaderFiles coupled{"needle/needle_motion.glsl", "needle/needle_coupling.glsl"};
    stiffness_ = compiled(joined({coupled, holding, {"needle/needle_stiffness_pass.glsl"}}));
    panel_ = compiled({"dialect/two_floats.glsl", "needle/needle_pairs.glsl", "needle/needle_panel_pass.glsl"});
    invert_ = compiled({"dialect/two_floats.glsl", "needle/needle_pairs.glsl", "needle/needle_invert_pass.glsl"});
    hold_ = compiled(joined({coupled, held, {"needle/needle_hold_pass.glsl"}}));
    settling = joined({settling, held, {"needle/needle_bent.glsl"}});
  }
  settle_ = compiled(joined({settling, {"needle/needle_settle_pass.glsl"}}));
  end_ = compiled({"needle/needle_motion.glsl", "needle/needle_end_pass.glsl"});
}

template <class Function>
void FragmentNeedlePasses::for_all(Function&& function) {
  for (Pass* pass : {&parts_,      &means_,  &begin_,         &first_facets_, &facets_, &aim_,   &first_around_,
                     &around_,     &select_, &first_weights_, &weights_,      &append_, &marks_, &coupling_,
                     &turn_parts_, &twist_,  &give_twist_,    &settle_,       &give_,   &end_}) {
    function(*pass);
  }
  if (!bending_) return;
  for (Pass* pass : {&stiffness_, &panel_, &invert_, &hold_}) function(*pass);
}

Pass FragmentNeedlePasses::compiled(ShaderFiles files, std::vector<std::pair<std::string, int>> defines) const {
  ShaderRequest request{.files = joined({common, std::move(files)}), .defines = std::move(defines)};
  define_kernels(kind_, request);
  request.defines.emplace_back("MOST_NODES", FloatNeedles::most_nodes);
  request.defines.emplace_back("TEAM", NeedleTextures::team);
  request.defines.emplace_back("PANEL", NeedleTextures::pivots);
  if (bending_) request.defines.emplace_back("BENDING", 1);
  return {*library_, std::move(request)};
}

void FragmentNeedlePasses::set_needles(FragmentNeedles& needles, const FragmentTools& tools) {
  for_all([&](Pass& pass) {
    tools.bind(pass);
    needles.bind(pass);
  });
  needles_ = &needles;
}

void FragmentNeedlePasses::set_step(double dt) {
  for (Pass* pass : {&parts_, &turn_parts_, &twist_, &give_twist_, &settle_, &give_, &end_}) {
    pass->set("dt", static_cast<float>(dt));
    pass->set("inverse_dt", static_cast<float>(1.0 / dt));
  }
  if (!bending_) return;
  for (Pass* pass : {&stiffness_, &hold_}) {
    pass->set("dt", static_cast<float>(dt));
    pass->set("inverse_dt", static_cast<float>(1.0 / dt));
  }
}

void FragmentNeedlePasses::prepare(Pass& pass, const Placed& needle) const {
  const NeedleTextures& drawn = needle.drawn;
  pass.input("displacement", state_->displacement());
  pushed_->bind(pass);
  pass.input("needle_state", drawn.state[needle.turn]);
  pass.input("needle_lists", drawn.lists);
  pass.input("needle_places", drawn.means[0]);
  pass.input("needle_motions", drawn.means[1]);
  pass.set("needle", row_);
  pass.set("number", number_);
}

void FragmentNeedlePasses::draw(Pass& pass, const Placed& needle, const Texture& rows, int count,
                                const Framebuffer& target) const {
  prepare(pass, needle);
  pass.set_rows(rows, count);
  pass.draw(target);
}

void FragmentNeedlePasses::draw_state(Pass& pass, Placed& needle) const {
  prepare(pass, needle);
  needle.turn = 1 - needle.turn;
  pass.set_rows(needle.drawn.state[0], needle.state_rows());
  pass.draw(needle.drawn.state_targets[needle.turn]);
}

void FragmentNeedlePasses::gather(Placed& needle, bool only_new) {
  const NeedleTextures& drawn = needle.drawn;
  for (Pass* pass : {&parts_, &means_}) pass->set("only_new", only_new ? 1 : 0);
  draw(parts_, needle, drawn.parts[0], NeedleTextures::team * needle.law.nodes, drawn.parts_target);
  means_.input("place_parts", drawn.parts[0]);
  means_.input("motion_parts", drawn.parts[1]);
  means_.input("hub_parts", drawn.parts[2]);
  draw(means_, needle, drawn.means[0], needle.law.nodes, drawn.means_target);
}

void FragmentNeedlePasses::meet_surface(const Placed& needle) {
  int rows = needles_->facet_count();
  const NeedleTextures::Level* source = nullptr;
  for (const NeedleTextures::Level& level : needle.drawn.facets) {
    Pass& pass = source ? facets_ : first_facets_;
    if (source) {
      pass.input("entering_rows", source->rows[0]);
      pass.input("behind_rows", source->rows[1]);
      pass.input("ahead_rows", source->rows[2]);
    }
    pass.set("source_count", rows);
    draw(pass, needle, level.rows[0], level.count, level.target);
    source = &level;
    rows = level.count;
  }
  aim_.input("entering_rows", source->rows[0]);
  aim_.input("behind_rows", source->rows[1]);
  aim_.input("ahead_rows", source->rows[2]);
}

void FragmentNeedlePasses::take_aim(Placed& needle, bool after_node, bool ends) {
  aim_.set("after_node_made", after_node ? 1 : 0);
  aim_.set("ends", ends ? 1 : 0);
  const NeedleTextures::Level& total = needle.drawn.around.back();
  aim_.input("around_0", total.rows[0]);
  aim_.input("around_1", total.rows[1]);
  aim_.input("around_2", total.rows[2]);
  draw_state(aim_, needle);
}

void FragmentNeedlePasses::find_particles(const Placed& needle) {
  int rows = needles_->particles();
  const NeedleTextures::Level* source = nullptr;
  int k = 0;
  for (const NeedleTextures::Level& level : needle.drawn.around) {
    Pass& pass = source ? around_ : first_around_;
    if (source) {
      pass.input("around_0", source->rows[0]);
      pass.input("around_1", source->rows[1]);
      pass.input("around_2", source->rows[2]);
    }
    pass.set("source_count", rows);
    draw(pass, needle, level.rows[0], level.count, level.target);
    select_.input(("around_count_" + std::to_string(k++)).c_str(), level.rows[1]);
    source = &level;
    rows = level.count;
  }
  select_.input("around_who", needle.drawn.who);
  draw(select_, needle, needle.drawn.found, needle.law.particles, needle.drawn.found_target);
}

void FragmentNeedlePasses::weigh(const Placed& needle) {
  const NeedleTextures& drawn = needle.drawn;
  const NeedleTextures::Level& total = drawn.around.back();
  const auto bind = [&](Pass& pass, std::size_t turn) {
    pass.input("around_0", total.rows[0]);
    pass.input("around_1", total.rows[1]);
    pass.input("around_2", total.rows[2]);
    pass.input("particles_found", drawn.found);
    pass.input("weight_sums", drawn.weights[turn][0]);
    pass.input("weight_solutions", drawn.weights[turn][1]);
  };
  const int rows = static_cast<int>(drawn.weights[0][0].rows());
  constexpr std::size_t rounds =
      3;  // refinements of needle_weights.glsl, less the last, which needle_append_pass.glsl is
  for (std::size_t round = 0; round < rounds; ++round) {
    Pass& pass = round == 0 ? first_weights_ : weights_;
    bind(pass, 1 - round % 2);
    draw(pass, needle, drawn.weights[0][0], rows, drawn.weight_targets[round % 2]);
  }
  bind(append_, (rounds - 1) % 2);
  draw(append_, needle, drawn.lists, needle.law.nodes * needle.law.particles, drawn.lists_target);
}

void FragmentNeedlePasses::make_node(Placed& needle) {
  find_particles(needle);
  weigh(needle);
}

/// What an impulse on a node moves, of nodes that are new.
void FragmentNeedlePasses::couple(Placed& needle) {
  for (Pass* pass : {&marks_, &coupling_}) pass->set("all_new", needle.coupled ? 0 : 1);
  draw(marks_, needle, needle.drawn.marks, needles_->particles(), needle.drawn.marks_target);
  draw(coupling_, needle, needle.drawn.coupling, needle.law.nodes * needle.law.nodes, needle.drawn.coupling_target);
  needle.coupled = true;
}

/// Friction around the shaft, before what sweeps see of the particles' motion.
void FragmentNeedlePasses::twist(Placed& needle, FragmentPushed& pushed) {
  const NeedleTextures& drawn = needle.drawn;
  draw(turn_parts_, needle, drawn.turn_parts[0], NeedleTextures::team * needle.law.nodes, drawn.turn_parts_target);
  twist_.input("push_parts", drawn.turn_parts[0]);
  twist_.input("moment_parts", drawn.turn_parts[1]);
  draw(twist_, needle, drawn.twists[0], needle.law.nodes, drawn.twists_target);
  prepare(give_twist_, needle);
  give_twist_.input("needle_marks", drawn.marks);
  give_twist_.input("needle_impulses", drawn.twists[0]);
  pushed.push(give_twist_);
  gather(needle, false);
}

/// How a shaft that bends gives way, inverted.
void FragmentNeedlePasses::stiffen(const Placed& needle) {
  const NeedleTextures& drawn = needle.drawn;
  const int nodes = needle.law.nodes, rows = nodes * (nodes + 1);
  stiffness_.input("needle_coupling", drawn.coupling);
  draw(stiffness_, needle, drawn.stiffness[0], rows, drawn.stiffness_targets[0]);
  std::size_t turn = 0;
  for (int pivot = 0; pivot < nodes; pivot += NeedleTextures::pivots) {
    for (Pass* pass : {&panel_, &invert_}) {
      pass->input("needle_stiffness", drawn.stiffness[turn]);
      pass->set("pivot", pivot);
    }
    invert_.input("needle_panel", drawn.panel);
    draw(panel_, needle, drawn.panel, NeedleTextures::pivots * nodes, drawn.panel_target);
    turn = 1 - turn;
    draw(invert_, needle, drawn.stiffness[0], rows, drawn.stiffness_targets[turn]);
  }
  for (Pass* pass : {&settle_, &hold_}) pass->input("needle_stiffness", drawn.stiffness[turn]);
}

/// Half of the turns are left to what is not counted.
int FragmentNeedlePasses::sweeps_at_a_time(const Placed& needle) const {
  const std::int64_t nodes = needle.law.nodes, a_sweep = (nodes + 1) * (nodes + 1);
  return static_cast<int>(std::clamp<std::int64_t>(loop_turns_ / 2 / a_sweep, 1, sweeps));
}

void FragmentNeedlePasses::sweep(const Placed& needle, int from, int to) {
  const NeedleTextures& drawn = needle.drawn;
  settle_.input("settled_sides", drawn.settled[settled_][0]);
  settle_.input("settled_motions", drawn.settled[settled_][1]);
  settle_.set("first_sweep", from);
  settle_.set("end_sweep", to);
  settled_ = 1 - settled_;
  draw(settle_, needle, drawn.impulses, needle.law.nodes, drawn.settled_targets[settled_]);
}

/// A draw from where a sweep holds nodes on the shaft to where the next one does, and one for that.
void FragmentNeedlePasses::settle_on_bent(const Placed& needle) {
  const NeedleTextures& drawn = needle.drawn;
  settle_.input("needle_holds", drawn.holds);
  hold_.input("needle_impulses", drawn.impulses);
  hold_.input("needle_coupling", drawn.coupling);
  sweep(needle, 0, 0);
  for (int k = 1; k <= sweeps; ++k) {
    hold_.input("settled_sides", drawn.settled[settled_][0]);
    hold_.input("settled_motions", drawn.settled[settled_][1]);
    draw(hold_, needle, drawn.holds, needle.law.nodes, drawn.holds_target);
    sweep(needle, k, k);
  }
}

void FragmentNeedlePasses::settle(const Placed& needle) {
  const NeedleTextures& drawn = needle.drawn;
  settle_.input("needle_coupling", drawn.coupling);
  settle_.input("needle_twists", drawn.twists[1]);
  if (needle.law.bends()) {
    stiffen(needle);
    settle_on_bent(needle);
  } else {
    // What the program reads of shafts that bend must not be another needle's, which may be gone.
    for (const char* name : {"needle_stiffness", "needle_holds"}) settle_.input(name, drawn.coupling);
    const int at_a_time = sweeps_at_a_time(needle);
    for (int from = 0; from < sweeps; from += at_a_time) sweep(needle, from, std::min(from + at_a_time, sweeps));
  }
  end_.input("settled_sides", drawn.settled[settled_][0]);
}

void FragmentNeedlePasses::act(const FragmentState& state, int number, FragmentPushed& pushed) {
  state_ = &state;
  pushed_ = &pushed;
  number_ = number;
  row_ = 0;
  for (Placed& needle : needles_->placed()) {
    gather(needle, false);
    draw_state(begin_, needle);
    meet_surface(needle);
    const int nodes = needles_->nodes_to_make(number);
    take_aim(needle, false, nodes == 0);
    for (int k = 1; k <= nodes; ++k) {
      make_node(needle);
      take_aim(needle, true, k == nodes);
    }
    if (nodes > 0) gather(needle, true);
    if (nodes > 0 || !needle.coupled) couple(needle);
    if (needles_->turns(needle, number)) twist(needle, pushed);
    settle(needle);
    give_.input("needle_marks", needle.drawn.marks);
    give_.input("needle_impulses", needle.drawn.impulses);
    prepare(give_, needle);
    end_.input("needle_impulses", needle.drawn.impulses);
    end_.input("needle_hubs", needle.drawn.means[2]);
    end_.input("needle_node_ends", needle.drawn.node_ends);
    end_.input("needle_twist_pushes", needle.drawn.twists[0]);
    end_.input("needle_twists", needle.drawn.twists[1]);
    pushed.push(give_);
    draw_state(end_, needle);
    ++row_;
  }
}

}  // namespace phymul::gl
