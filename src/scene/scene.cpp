// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/load_frame.h>
#include <phymul/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <utility>

#include "base/decimal.h"
#include "model/group.h"
#include "model/outer_faces.h"
#include "scene_items.h"

namespace phymul {
namespace {

constexpr std::uint8_t all_axes = 7;

const char* load_name(LoadType type) {
  constexpr std::array<const char*, 5> names{"translation", "rotation", "force", "pressure", "acceleration"};
  return names[static_cast<std::size_t>(type)];
}

std::string load_label(const Load& load) {
  const std::string target = load.applied_to.empty() ? "" : " on \"" + load.applied_to + '"';
  return load_name(load.type) + target + ": ";
}

/// The components of v that the load drives, the others 0.
Vec3 driven_part(const Load& load, Vec3 v) {
  for (int a = 0; a < 3; ++a) {
    if (load.axes[a] != Axis::driven) v[a] = 0.0;
  }
  return v;
}

bool has_driven_axis(const Load& load) {
  return std::any_of(load.axes.begin(), load.axes.end(), [](Axis axis) { return axis == Axis::driven; });
}

bool always_zero(std::span<const ValueEvent> events) {
  return std::all_of(events.begin(), events.end(), [](const ValueEvent& event) { return event.value == 0.0; });
}

bool has_direction(const Load& load) {
  return load.toward >= 0 || !driven_part(load, load.direction).isZero(0.0);
}

Vec3 normalised(const Vec3& v) {
  const double length = v.stableNorm();
  return length > 0.0 ? Vec3(v / length) : Vec3(Vec3::Zero());
}

/// Of the load and these events.
void require_events(const Load& load, std::span<const ValueEvent> events) {
  if (events.empty() && has_driven_axis(load)) {
    throw Error(load_label(load) + "expected at least one value with its date, got none");
  }
  for (const ValueEvent& event : events) {
    if (std::isfinite(event.date) && std::isfinite(event.value)) continue;
    throw Error(load_label(load) + "expected finite dates and values, got value " + to_decimal(event.value) +
                " at date " + to_decimal(event.date) + " s");
  }
  if (!has_direction(load) && load.type != LoadType::pressure && has_driven_axis(load) && !always_zero(events)) {
    throw Error(load_label(load) + "expected a direction that is not zero; set Load::direction or Load::toward");
  }
}

bool is_earlier(const ValueEvent& a, const ValueEvent& b) {
  return a.date < b.date;
}

Load held(std::vector<Index> particles) {
  Load load{.type = LoadType::translation, .particles = std::move(particles)};
  load.axes.fill(Axis::held);
  return load;
}

void require_row(const char* caller, std::size_t row, std::size_t loads) {
  if (row < loads) return;
  throw Error(std::string(caller) + ": expected a row of one of " + std::to_string(loads) + " loads, got " +
              std::to_string(row));
}

/// In the plane z = 0 nothing may push along z, and turning is about z alone.
void require_in_plane(const Load& load) {
  const bool turns = load.type == LoadType::rotation;
  const Vec3 u = driven_part(load, load.direction);
  if (turns ? load.toward < 0 && u.head<2>().isZero(0.0) : load.toward >= 0 || u.z() == 0.0) return;
  throw Error(load_label(load) + (turns ? "expected an axis along z" : "expected a direction with z = 0") +
              " in a two-dimensional model");
}

}  // namespace

Scene::Scene(const Model& model) : model_(&model) {
  validate(model);
  find_removed();
}

Scene::Scene(std::shared_ptr<const Model> model) : owned_(std::move(model)), model_(owned_.get()) {
  if (!model_) throw Error("Scene: expected a model, got null");
  validate(*model_);
  find_removed();
}

void Scene::require(const Load& load) const {
  const Index count = model_->particle_count();
  require_indices(load.particles, model_->rest.size(), "particles", [&] { return load_label(load); });
  if (load.toward < -1 || load.toward >= count) {
    throw Error(load_label(load) + "expected a particle to point toward from 0 to " + std::to_string(count - 1) +
                " (or -1 for none), got " + std::to_string(load.toward));
  }
  if (load.toward < 0 && !driven_part(load, load.direction).allFinite()) {
    throw Error(load_label(load) + "expected a finite direction");
  }
  require_events(load, load.events);
  if (load.type == LoadType::rotation && !has_direction(load)) {
    throw Error(load_label(load) + "expected an axis; set Load::direction");
  }
  if (model_->dimension == 2) require_in_plane(load);
}

/// The load's unit direction as seen from a place; zero where the place is the one it points toward.
Vec3 Scene::unit_direction(const Load& load, const Vec3& from) const {
  return normalised(driven_part(load, load.toward < 0 ? load.direction : Vec3(model_->rest[load.toward] - from)));
}

Scene::Action Scene::prepared(const Load& load) const {
  Action action;
  action.particles = load.particles;
  std::sort(action.particles.begin(), action.particles.end());
  action.particles.erase(std::unique(action.particles.begin(), action.particles.end()), action.particles.end());
  if (load.type == LoadType::rotation) return prepared_rotation(load, std::move(action));
  if (load.type == LoadType::pressure) return prepared_pressure(load, std::move(action));
  if (load.type == LoadType::acceleration && load.toward < 0 &&
      action.particles.size() == static_cast<std::size_t>(model_->particle_count())) {
    action.uniform = true;
    action.axis = unit_direction(load, Vec3::Zero());
    return action;
  }
  for (const Index i : action.particles) {
    const double factor = load.type == LoadType::acceleration ? model_->mass[i] : 1.0;
    action.unit.push_back(factor * unit_direction(load, model_->rest[i]));
  }
  if (load.type == LoadType::translation) {
    for (int a = 0; a < 3; ++a) action.imposed |= static_cast<std::uint8_t>((load.axes[a] != Axis::free) << a);
  }
  return action;
}

/// Throws for a load that makes no sense; else sorts its events.
Scene::Action Scene::accepted(Load& load) const {
  require(load);
  Action action = prepared(load);
  std::stable_sort(load.events.begin(), load.events.end(), is_earlier);
  return action;
}

Scene::Action Scene::prepared_rotation(const Load& load, Action action) const {
  // A cut leaves the axis where it is: copies of particles of the load do not count.
  std::vector<Index> counted = action.particles;
  for (const auto& [copy, of, shared] : copies_) {
    if (std::ranges::binary_search(action.particles, of)) std::erase(counted, copy);
  }
  Vec3 centroid = Vec3::Zero();
  for (const Index i : counted) centroid += model_->rest[i] / static_cast<double>(counted.size());
  for (const Index i : action.particles) action.unit.push_back(model_->rest[i] - centroid);
  action.axis = unit_direction(load, centroid);
  action.imposed = all_axes;
  if (action.axis.isZero(0.0) && !action.particles.empty()) {
    throw Error(load_label(load) + "expected an axis, but the particle it points toward lies at the centroid");
  }
  return action;
}

Scene::Action Scene::prepared_pressure(const Load& load, Action action) const {
  if (action.particles.empty()) return action;
  std::vector<char> chosen(model_->rest.size(), 0);
  for (const Index i : action.particles) chosen[i] = 1;
  const std::vector<Facet> facets = surface_facets(*model_, chosen);
  if (facets.empty() && body_version_ == 0) {
    throw Error(load_label(load) +
                "expected particles that span facets of the surface, but no facet has all of its particles among them");
  }
  const bool directed = has_direction(load);
  VecList unit(model_->rest.size(), Vec3::Zero());
  for (const Facet& facet : facets) {
    const double shares = static_cast<double>(facet.particles.size());
    for (const Index i : facet.particles) {
      unit[i] += directed ? Vec3(facet.area.norm() / shares * unit_direction(load, model_->rest[i]))
                          : Vec3(-facet.area / shares);
    }
  }
  for (const Index i : action.particles) action.unit.push_back(unit[i]);
  return action;
}

Scene& Scene::fix(std::string_view group) & {
  Load load = held(model_->group(group));
  load.applied_to = group;
  return add(std::move(load));
}

Scene& Scene::fix(std::span<const Index> particles) & {
  return add(held({particles.begin(), particles.end()}));
}

Scene& Scene::gravity(const Vec3& acceleration) & {
  if (!acceleration.allFinite()) throw Error("gravity: expected a finite acceleration in m/s^2");
  if (model_->dimension == 2 && acceleration.z() != 0.0) {
    throw Error("gravity: expected z = 0 in a two-dimensional model, got " + to_decimal(acceleration.z()));
  }
  gravity_ = acceleration;
  ++version_;
  return *this;
}

Scene& Scene::add(Load load) & {
  std::vector<Load> one;
  one.push_back(std::move(load));
  return add(std::move(one));
}

Scene& Scene::add(std::vector<Load> loads) & {
  std::vector<Action> actions;
  for (Load& load : loads) actions.push_back(accepted(load));
  // Room first: what follows cannot fail half-way.
  loads_.reserve(loads_.size() + loads.size());
  actions_.reserve(loads_.size() + loads.size());
  std::move(loads.begin(), loads.end(), std::back_inserter(loads_));
  std::move(actions.begin(), actions.end(), std::back_inserter(actions_));
  ++version_;
  return *this;
}

Scene& Scene::replace(std::size_t row, Load load) {
  require_row("replace", row, loads_.size());
  actions_[row] = accepted(load);
  loads_[row] = std::move(load);
  ++version_;
  return *this;
}

Scene& Scene::remove(std::size_t row) {
  require_row("remove", row, loads_.size());
  loads_.erase(loads_.begin() + static_cast<std::ptrdiff_t>(row));
  actions_.erase(actions_.begin() + static_cast<std::ptrdiff_t>(row));
  ++version_;
  return *this;
}

Scene& Scene::set_events(std::size_t row, std::span<const ValueEvent> events) {
  require_row("set_events", row, loads_.size());
  Load& load = loads_[row];
  require_events(load, events);
  load.events.assign(events.begin(), events.end());
  if (!std::is_sorted(load.events.begin(), load.events.end(), is_earlier)) {
    std::stable_sort(load.events.begin(), load.events.end(), is_earlier);
  }
  ++values_version_;
  return *this;
}

Scene& Scene::clear() {
  loads_.clear();
  actions_.clear();
  tools_.clear();
  joints_.clear();
  threads_.clear();
  gravity_.setZero();
  stiffness_factors_.clear();
  tearing_.clear();
  volume_constraints_.clear();
  open_volumes_.clear();
  contacts_.reset();
  ++version_;
  return *this;
}

/// What is imposed on a particle, an acceleration and a pressure are on all of its tissue. A force stays at the
/// particle, also while this is no copy, but not where it becomes one of another.
void Scene::follow_copies(const BodyCuts& cuts) {
  const std::vector<BodyCut::Copy> before = std::exchange(copies_, {});
  for (const auto& cut : cuts) copies_.insert(copies_.end(), cut->copies.begin(), cut->copies.end());
  const auto stays = std::ranges::mismatch(before, copies_);
  std::map<Index, Index> were;  // what particles copied that are no copies any more
  for (const BodyCut::Copy& copy : undone_copies_) were[copy.particle] = copy.of;
  for (auto old = stays.in1; old != before.end(); ++old) were[old->particle] = old->of;
  for (std::size_t row = 0; row < loads_.size(); ++row) {
    const bool on_all = loads_[row].type != LoadType::force;
    std::vector<Index>& particles = loads_[row].particles;
    const std::size_t count = particles.size();
    for (auto old = stays.in1; on_all && old != before.end(); ++old) std::erase(particles, old->particle);
    bool changed = particles.size() != count;
    for (auto added = stays.in2; added != copies_.end(); ++added) {
      const auto was = were.find(added->particle);
      const bool is_another = was != were.end() && was->second != added->of;
      if (!on_all && is_another) changed = std::erase(particles, added->particle) > 0 || changed;
      if (!on_all || std::ranges::find(particles, added->of) == particles.end()) continue;
      particles.push_back(added->particle);
      changed = true;
    }
    if (changed) actions_[row] = prepared(loads_[row]);
  }
  for (const BodyCut::Copy& copy : copies_) were.erase(copy.particle);
  undone_copies_.clear();
  for (const auto& [particle, of] : were) undone_copies_.push_back({particle, of});
}

void Scene::body_changed(const BodyCuts& cuts, std::vector<Index> cells) {
  ++body_version_;
  changed_cells_ = std::move(cells);
  follow_copies(cuts);
  for (std::size_t row = 0; row < loads_.size(); ++row) {
    const LoadType type = loads_[row].type;
    if (type == LoadType::pressure || type == LoadType::acceleration) actions_[row] = prepared(loads_[row]);
  }
  find_removed();
  find_open_volumes();
  ++version_;
}

void Scene::find_removed() {
  removed_.clear();
  for (Index i = 0; i < model_->particle_count(); ++i) {
    if (model_->mass[i] == 0.0) removed_.push_back(i);
  }
}

void Scene::prepare(LoadFrame& frame) const {
  bool pushes = false, imposed = !removed_.empty();
  for (std::size_t row = 0; row < loads_.size(); ++row) {
    if (actions_[row].particles.empty()) continue;
    imposed |= actions_[row].imposed != 0;
    pushes |= !imposes(loads_[row].type) && !actions_[row].uniform;
  }
  const std::size_t count = model_->rest.size();
  frame.gravity = gravity_;
  frame.force.assign(pushes ? count : 0, Vec3::Zero());
  frame.fixed.assign(imposed ? count : 0, 0);
  // By range, not by copy: a frame that has the room already takes none anew.
  frame.target.assign(model_->rest.begin(), imposed ? model_->rest.end() : model_->rest.begin());
  for (const Action& action : actions_) {
    if (action.imposed == 0) continue;
    for (const Index i : action.particles) frame.fixed[i] |= action.imposed;
  }
  for (const Index i : removed_) frame.fixed[i] = all_axes;
}

void Scene::evaluate(double time, LoadFrame& frame) const {
  frame.gravity = gravity_;
  // Only particles that some load pushes ever differ from 0: the cost follows the loads, not the body.
  for (std::size_t row = 0; row < loads_.size(); ++row) {
    if (imposes(loads_[row].type) || actions_[row].uniform) continue;
    for (const Index i : actions_[row].particles) frame.force[i].setZero();
  }
  for (std::size_t row = 0; row < loads_.size(); ++row) {
    const Action& action = actions_[row];
    assert(action.imposed == 0 || action.particles.empty() || frame.target.size() == model_->rest.size());
    assert(imposes(loads_[row].type) || action.unit.empty() || frame.force.size() == model_->rest.size());
    const double value = value_at(loads_[row].events, time);
    if (action.uniform) {
      frame.gravity += value * action.axis;
    } else if (loads_[row].type == LoadType::rotation) {
      const Mat3 turn = Eigen::AngleAxisd(value, action.axis).toRotationMatrix() - Mat3::Identity();
      for (std::size_t k = 0; k < action.particles.size(); ++k) {
        const Index i = action.particles[k];
        // From the rest place, so that no turn leaves it there to the last digit.
        if (model_->mass[i] > 0.0) frame.target[i] = model_->rest[i] + turn * action.unit[k];
      }
    } else if (loads_[row].type == LoadType::translation) {
      for (std::size_t k = 0; k < action.particles.size(); ++k) {
        const Index i = action.particles[k];
        if (model_->mass[i] == 0.0) continue;  // removed: it stays at its rest place
        for (int a = 0; a < 3; ++a) {
          if (action.imposed >> a & 1) frame.target[i][a] = model_->rest[i][a] + value * action.unit[k][a];
        }
      }
    } else {
      for (std::size_t k = 0; k < action.particles.size(); ++k) {
        frame.force[action.particles[k]] += value * action.unit[k];
      }
    }
  }
}

}  // namespace phymul
