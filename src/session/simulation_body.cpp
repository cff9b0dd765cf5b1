// SPDX-License-Identifier: MIT
//
// Changes of the body of a simulation: cells that are removed, cuts, and their undoing.
#include <phymul/error.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "body/cut_places.h"
#include "model/cell_geometry.h"
#include "simulation_parts.h"

namespace phymul {

BodyEdit& Simulation::Parts::body_edit() {
  // The solver first: it estimates its steps from the body as it was, whatever is done before its first step.
  solver();
  if (!edit) edit = std::make_unique<BodyEdit>(model, *topology);
  return *edit;
}

/// Cuts are undone, and those that were undone made again, while no cell is removed.
void Simulation::Parts::change_body(const std::vector<Index>& removed, const BodyCuts& cuts) {
  const auto without = [](const std::vector<Index>& a, const std::vector<Index>& b) {
    std::vector<Index> rest;
    std::ranges::set_difference(a, b, std::back_inserter(rest));
    return rest;
  };
  std::vector<Index> changed;  // rows of cells
  const auto set_shares = [&](const std::vector<Index>& cells, double share) {
    body_edit().set_shares(cells, share);
    changed.insert(changed.end(), cells.begin(), cells.end());
  };
  const auto set_removed = [&](const std::vector<Index>& to) {
    const std::vector<Index> from = topology->removed;
    set_shares(without(from, to), 1.0);
    set_shares(without(to, from), 0.0);
  };
  const auto add_changed = [&](const BodyCut& cut, std::size_t first_added) {
    for (const BodyCut::Change& change : cut.changed) changed.push_back(change.row);
    for (std::size_t k = 0; k < cut.added.size(); ++k) changed.push_back(static_cast<Index>(first_added + k));
  };
  const auto same = [](const auto& a, const auto& b) { return a == b || *a == *b; };
  const auto stays = std::ranges::mismatch(topology->cuts, cuts, same);
  const auto past_removed = [&](const std::shared_ptr<const BodyCut>& cut) {
    return std::ranges::any_of(cut->changed, [&](const BodyCut::Change& change) {
      return std::ranges::binary_search(topology->removed, change.row);
    });
  };
  const bool only_further = stays.in1 == topology->cuts.end() && removed == topology->removed &&
                            std::none_of(stays.in2, cuts.end(), past_removed);
  if (!only_further && !equal_cuts(topology->cuts, cuts)) set_removed({});
  const auto kept = static_cast<std::size_t>(stays.in2 - cuts.begin());
  while (topology->cuts.size() > kept) {
    const std::shared_ptr<const BodyCut> undone = topology->cuts.back();
    body_edit().undo();
    add_changed(*undone, model.cells.size());
  }
  for (std::size_t k = kept; k < cuts.size(); ++k) {
    add_changed(*cuts[k], model.cells.size());
    body_edit().make(cuts[k]);
  }
  set_removed(removed);
  scene.body_changed(topology->cuts, std::move(changed));
}

void Simulation::Parts::see_tools() {
  for (const SceneTool& tool : scene.tools()) tools_seen[tool.id] = {tool.moves, tool.places, tool.grasps};
  if (tools_seen.size() == scene.tools().size()) return;
  std::erase_if(tools_seen, [this](const auto& seen) {
    return std::ranges::find(scene.tools(), seen.first, &SceneTool::id) == scene.tools().end();
  });
}

/// What tools were asked since they were as `seen`, which the solver has forgotten.
void Simulation::Parts::ask_tools_again(std::vector<SceneTool> asked, const std::map<std::uint64_t, SeenTool>& seen) {
  for (const SceneTool& tool : asked) {
    const auto known = seen.find(tool.id);
    const SeenTool before = known != seen.end() ? known->second : SeenTool{};
    const ToolHandle handle = scene.tool(tool.name);
    if (before.places != tool.places) handle.teleport(tool.pose);
    if (before.places == tool.places && before.moves != tool.moves) handle.move_to(tool.pose);
    if (tool.released > before.grasps) handle.release();
    if (before.grasps != tool.grasps && tool.grasping) handle.grasp(tool.grasp_distance);
  }
}

void Simulation::Parts::took_steps(const StepReport& report) {
  if (report.steps == 0) return;
  last_dt = report.dt;
  started.reset();
  see_tools();
}

void Simulation::Parts::set_body(const std::vector<Index>& removed, const BodyCuts& cuts) {
  if (removed == topology->removed && equal_cuts(cuts, topology->cuts)) return;
  const std::vector<Index> removed_before = topology->removed;
  const BodyCuts cuts_before = topology->cuts;
  try {
    change_body(removed, cuts);
    solver().body_changed();  // after which it has forgotten what tools were asked since its last step
  } catch (...) {
    change_body(removed_before, cuts_before);
    try {
      solver().body_changed();
      ask_tools_again(scene.tools(), tools_seen);
    } catch (...) {
      // A solver that does not follow has taken over nothing; where memory ran out in one that does, a part.
    }
    throw;
  }
  ask_tools_again(scene.tools(), tools_seen);
  if (!waiting.empty()) follow_waiting(cuts_before);
  const std::size_t known = warnings.size();
  look_for_tools_beyond_cuts(model, scene, warnings);
  if (options.log && warnings.size() > known) options.log(warnings.back());
}

bool Simulation::Parts::keeps_body() {
  return refused_cut || solver().substeps() > 1;
}

void Simulation::Parts::make_cut(BodyCut cut, std::size_t cells, StepReport& report) {
  BodyCuts all = topology->cuts;
  all.push_back(std::make_shared<const BodyCut>(std::move(cut)));
  try {
    set_body(topology->removed, all);
  } catch (const Error& error) {
    // Parts with local steps are of the body as it was made.
    if (error.code() != ErrorCode::not_supported || options.solver.max_substeps == 1) throw;
    refused_cut = true;
    report.uncut += static_cast<int>(cells);
    return;
  }
  if (recorder) recorder->body_changed();
}

void Simulation::remove_cells(std::span<const Index> cells) {
  std::vector<Index> removed = parts_->topology->removed;
  for (const Index row : cells) {
    const auto count = static_cast<Index>(model().cells.size());
    if (row >= 0 && row < count) continue;
    throw Error("Simulation::remove_cells: expected rows of Model::cells from 0 to " + std::to_string(count - 1) +
                ", got " + std::to_string(row));
  }
  removed.insert(removed.end(), cells.begin(), cells.end());
  std::ranges::sort(removed);
  const auto again = std::ranges::unique(removed);
  removed.erase(again.begin(), again.end());
  parts_->set_body(removed, cuts());
  if (parts_->recorder) parts_->recorder->body_changed();
}

bool Simulation::cut(const CutSurface& surface) {
  std::vector<Index> cells;
  for (Index row = 0; row < static_cast<Index>(model().cells.size()); ++row) {
    if (model().cells[row].share > 0.0 && is_tissue(model(), model().cells[row])) cells.push_back(row);
  }
  const CutPlaces places(model(), cells, surface, "Simulation::cut");
  BodyCut found = parts_->body_edit().find_cut(places.cut());
  if (found.empty()) return false;
  BodyCuts all = cuts();
  all.push_back(std::make_shared<const BodyCut>(std::move(found)));
  parts_->set_body(removed_cells(), all);
  if (parts_->recorder) parts_->recorder->body_changed();
  return true;
}

const BodyCuts& Simulation::cuts() const {
  return parts_->topology->cuts;
}

const std::vector<Index>& Simulation::removed_cells() const {
  return parts_->topology->removed;
}

}  // namespace phymul
