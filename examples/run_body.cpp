// SPDX-License-Identifier: MIT
#include "run_body.h"

#include <phymul/body.h>
#include <phymul/error.h>
#include <phymul/lml.h>
#include <phymul/pml.h>
#include <phymul/surface_file.h>

#include <algorithm>
#include <optional>

#include "surface_body.h"

namespace {

/// A value that is there from the beginning.
phymul::Load load_on(phymul::LoadType type, const GroupVector& wish, std::vector<phymul::Index> particles,
                     double share) {
  phymul::Load load;
  load.type = type;
  load.applied_to = wish.group;
  load.particles = std::move(particles);
  load.direction = wish.value;
  load.events = {{0.0, share * wish.value.norm()}};
  return load;
}

}  // namespace

phymul::Model read_shape(const RunOptions& options) {
  return read_body_file(options.body, options.length_unit, options.spacing, options.from_file, options.fine_balls)
      .model;
}

void dress_shape(const RunOptions& options, phymul::Model& model) {
  for (const GroupBall& it : options.groups) {
    if (model.has_group(it.name)) throw phymul::Error("--group: the body already has a group " + it.name);
    model.add_group(it.name, particles_in_ball(model, it.ball.data(), "--group " + it.name));
  }
  if (options.from_file) return;
  if (std::none_of(model.cells.begin(), model.cells.end(),
                   [](const phymul::Cell& cell) { return phymul::is_volume(cell.type); })) {
    throw phymul::Error(options.body +
                        ": expected volume cells, which a material needs, got none; give --from-file to "
                        "run it with the file's own masses and stiffnesses");
  }
  phymul::set_material(model, options.material);
  for (auto [group, material] : options.materials) {
    material.density = options.material.density;
    const auto ball = std::ranges::find(options.groups, group, &GroupBall::name);
    if (ball == options.groups.end()) {
      phymul::set_material(model, material, group);
      continue;
    }
    // By the cells' centres: those whose particles are all in the ball would be a smaller region.
    const phymul::Vec3 centre(ball->ball[0], ball->ball[1], ball->ball[2]);
    phymul::set_material(model, material,
                         [&](const phymul::Vec3& at) { return (at - centre).norm() <= ball->ball[3]; });
  }
}

phymul::Model cut_along_planes(const RunOptions& options, phymul::Model model) {
  const auto plane = [](const double* it) { return phymul::cut_plane({it[0], it[1], it[2]}, {it[3], it[4], it[5]}); };
  try {
    for (std::size_t k = 0; k < options.cuts.size(); k += 6) {
      phymul::CutSurface cut = plane(&options.cuts[k]);
      if (!options.cut_front.empty()) cut.front = plane(options.cut_front.data()).distance;
      const phymul::Index before = model.particle_count();
      model = phymul::cut_body(std::move(model), cut);
      if (model.particle_count() > before) continue;
      throw phymul::Error("the plane " + std::to_string(k / 6 + 1) +
                          " passes no cell of the body; give a point inside of it, in m");
    }
  } catch (const phymul::Error& error) {
    throw phymul::Error(error.code(), std::string("--cut: ") + error.what());
  }
  return model;
}

phymul::Model read_body(const RunOptions& options) {
  phymul::Model model = read_shape(options);
  dress_shape(options, model);
  return cut_along_planes(options, std::move(model));
}

void fill_scene(const RunOptions& options, const phymul::Model& model, phymul::Scene& scene,
                std::vector<std::string>* notes) {
  if (!options.loads.empty()) scene.add(phymul::read_lml(options.loads, model, notes));
  for (const std::string& group : options.fixed_groups) scene.fix(group);
  for (std::size_t k = 0; k < options.fixed_balls.size(); k += 4) {
    scene.fix(particles_in_ball(model, &options.fixed_balls[k], "--fix-near"));
  }
  std::optional<phymul::Surface> surface;
  if (!options.held_balls.empty() && is_surface(options.body)) {
    surface = phymul::read_surface(options.body, length_unit(options.body, options.length_unit));
  }
  hold_in_balls(scene, surface ? &*surface : nullptr, options.spacing, options.held_balls);
  for (const GroupVector& force : options.forces) {
    std::vector<phymul::Index> members = model.group(force.group);
    const double share = 1.0 / static_cast<double>(members.size());
    scene.add(load_on(phymul::LoadType::force, force, std::move(members), share));
  }
  for (const GroupVector& move : options.moves) {
    if (move.value.isZero(0.0)) {
      scene.fix(move.group);
    } else {
      scene.add(load_on(phymul::LoadType::translation, move, model.group(move.group), 1.0));
    }
  }
  for (std::string& done : phymul::add_body_types(scene)) {
    if (notes) notes->push_back(std::move(done));
  }
  const std::vector<double> gravity = options.gravity.empty() ? std::vector<double>(3, 0.0) : options.gravity;
  scene.gravity({gravity[0], gravity[1], gravity[2]});
  if (options.tearing) scene.tear(*options.tearing);
}
