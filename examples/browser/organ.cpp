// SPDX-License-Identifier: MIT
#include "organ.h"

#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

using phymul::Index;
using phymul::Vec3;

namespace {

constexpr double longest_frame = 1.0 / 20.0;  // s; what a slower machine cannot do is left out
constexpr double way_time = 0.05;             // s, of the hand to where the mouse is

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Where a ray first meets a surface: weights of a triangle's corners.
struct Hit {
  std::array<Index, 3> triangle;
  Vec3 weight;
  Vec3 of(const phymul::VecList& points) const {
    return weight[0] * points[triangle[0]] + weight[1] * points[triangle[1]] + weight[2] * points[triangle[2]];
  }
};

/// By the method of Moeller and Trumbore (1997).
std::optional<Hit> first_hit(const phymul::VecList& points, const std::vector<std::array<Index, 3>>& triangles,
                             const Vec3& origin, const Vec3& along) {
  std::optional<Hit> first;
  double nearest = HUGE_VAL;
  for (const std::array<Index, 3>& triangle : triangles) {
    const Vec3 &a = points[triangle[0]], b = points[triangle[1]] - a, c = points[triangle[2]] - a, from = origin - a;
    const Vec3 p = along.cross(c), q = from.cross(b);
    const double size = b.dot(p), u = from.dot(p) / size, v = along.dot(q) / size, way = c.dot(q) / size;
    if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && way >= 0.0 && way < nearest)) continue;
    nearest = way;
    first = Hit{triangle, {1.0 - u - v, u, v}};
  }
  return first;
}

}  // namespace

phymul::Material organ_tissue() {
  return {.young = 3e3, .poisson = 0.4, .density = 1060.0};
}

phymul::Model organ_body(const phymul::Surface& surface, double spacing) {
  phymul::Model model = phymul::make_body(surface, {.spacing = spacing});
  phymul::set_material(model, organ_tissue());
  return model;
}

std::vector<Index> organ_foot(const phymul::Model& model) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const Vec3& x : model.rest) {
    low = std::min(low, x.z());
    high = std::max(high, x.z());
  }
  std::vector<Index> foot;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (model.rest[i].z() < low + 0.2 * (high - low)) foot.push_back(i);
  }
  return foot;
}

std::vector<Index> organ_patch(const phymul::Model& model, const Vec3& place, double reach) {
  const std::vector<Index> foot = organ_foot(model);
  std::vector<Index> patch;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if ((model.rest[i] - place).norm() < reach && !std::binary_search(foot.begin(), foot.end(), i)) patch.push_back(i);
  }
  return patch;
}

std::vector<phymul::Load> organ_pull(const std::vector<Index>& particles, const Vec3& from, const Vec3& to,
                                     double start, double end) {
  std::vector<phymul::Load> loads(3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    phymul::Load& load = loads[axis];
    load.type = phymul::LoadType::translation;
    load.particles = particles;
    load.events = {{start, from[axis]}, {end, to[axis]}};
    load.axes = {phymul::Axis::free, phymul::Axis::free, phymul::Axis::free};
    load.axes[axis] = phymul::Axis::driven;
    load.direction[axis] = 1.0;
  }
  return loads;
}

Organ::Organ(std::shared_ptr<const phymul::Surface> surface, double spacing, const std::string& backend)
    : surface_(std::move(surface)),
      model_(std::make_unique<const phymul::Model>(organ_body(*surface_, spacing))),
      scene_(*model_),
      skin_(*model_, surface_->vertices),
      topology_(std::make_shared<const phymul::TopologyTextures>(build_topology(*model_))),
      spectrum_(estimate_spectrum(*topology_, topology_->rest)) {
  scene_.fix(organ_foot(*model_));
  pull_.reach = std::max(0.012, 1.2 * spacing);
  use(backend);
}

void Organ::use(const std::string& backend) {
  std::optional<phymul::State> state;
  if (solver_) state = solver_->read();
  phymul::SolverOptions options;
  options.damping.rate = 8.0;
  options.threads = 1;
  options.spectrum = spectrum_;
  options.gl.context = phymul::GlContext::current;
  auto solver = phymul::make_solver(backend, topology_, scene_, options);
  if (state) solver->reset(*state);
  display_ = nullptr;  // it looks at the solver that goes
  solver_ = std::move(solver);
  make_display();
  dt_ = 0.5 * solver_->stable_step();
  owed_ = rate_ = counted_time_ = 0.0;
  counted_steps_ = 0;
}

void Organ::make_display() {
  display_ = phymul::make_display(*solver_, skin_, surface_->triangles, {.context = phymul::GlContext::current});
}

void Organ::reset() {
  release();
  solver_->reset();
  time_ = owed_ = 0.0;
  failure_.clear();
}

void Organ::advance(double wall_time) {
  owed_ = std::min(owed_ + wall_time, longest_frame);
  const double begin = seconds_now();
  int steps = 0;
  // A few at a time, so that a slow backend gives the page back in time.
  while (owed_ >= dt_ && seconds_now() - begin < longest_frame) {
    const int n = std::clamp(static_cast<int>(owed_ / dt_), 1, 8);
    const phymul::StepReport report = solver_->step(n, dt_);
    steps += report.steps;
    time_ = report.time;
    owed_ -= n * dt_;
    if (!report.ok()) {
      failure_ = report.message();
      release();
      solver_->reset();
      break;
    }
  }
  count(steps, wall_time);
}

void Organ::count(int steps, double wall_time) {
  counted_steps_ += steps;
  counted_time_ += wall_time;
  if (counted_time_ < 0.5) return;
  rate_ = counted_steps_ / counted_time_;
  counted_steps_ = 0;
  counted_time_ = 0.0;
}

phymul::Camera Organ::camera(int width, int height) const {
  const Vec3 towards(std::cos(raised_) * std::cos(turned_), std::cos(raised_) * std::sin(turned_), std::sin(raised_));
  phymul::Camera camera = phymul::framing(surface_->vertices, towards, static_cast<double>(width) / height);
  camera.view_height *= 1.15 / zoom_;
  return camera;
}

void Organ::draw(int width, int height) {
  phymul::DisplayOptions options;
  options.edges = false;
  options.full_scale = 0.03;
  options.background = {0.965, 0.97, 0.975, 1.0};
  display_->draw(camera(width, height), options, 0, 0, width, height);
}

void Organ::turn(double right, double up) {
  turned_ -= right;
  raised_ = std::clamp(raised_ + up, -1.4, 1.4);
}

void Organ::zoom(double factor) {
  zoom_ = std::clamp(zoom_ * factor, 0.4, 5.0);
}

bool Organ::take(double x, double y, int width, int height) {
  release();
  const phymul::Camera eye = camera(width, height);
  const phymul::State state = solver_->read();
  const phymul::VecList points = skin_.deform(state.position);
  const auto at = [&](double depth) { return from_pixel(eye, {x, y, depth}, width, height); };
  const Vec3 origin = at(0.0);
  const std::optional<Hit> hit = first_hit(points, surface_->triangles, origin, at(1.0) - origin);
  if (!hit) return false;
  Held held;
  pull_.place = hit->of(surface_->vertices);
  held.particles = organ_patch(*model_, pull_.place, pull_.reach);
  if (held.particles.empty()) return false;  // the foot
  pull_.displacement.setZero();
  for (const Index i : held.particles) pull_.displacement += state.position[i] - model_->rest[i];
  pull_.displacement /= static_cast<double>(held.particles.size());
  held.depth = to_pixel(eye, hit->of(points), width, height).z();
  held.offset = pull_.displacement - at(held.depth);
  held.first_row = scene_.loads().size();
  scene_.add(organ_pull(held.particles, pull_.displacement, pull_.displacement, time_, time_ + way_time));
  held_ = std::move(held);
  return true;
}

void Organ::move(double x, double y, int width, int height) {
  if (!held_) return;
  const Vec3 wanted = from_pixel(camera(width, height), {x, y, held_->depth}, width, height) + held_->offset;
  Vec3 now;
  for (int axis = 0; axis < 3; ++axis) {
    now[axis] = value_at(scene_.loads()[held_->first_row + static_cast<std::size_t>(axis)].events, time_);
  }
  std::vector<phymul::Load> loads = organ_pull(held_->particles, now, wanted, time_, time_ + way_time);
  for (std::size_t axis = 0; axis < 3; ++axis) scene_.replace(held_->first_row + axis, std::move(loads[axis]));
  pull_.displacement = wanted;
}

void Organ::release() {
  if (!held_) return;
  for (std::size_t axis = 3; axis-- > 0;) scene_.remove(held_->first_row + axis);
  held_.reset();
}

double Organ::largest_displacement() const {
  const phymul::State state = solver_->read();
  const phymul::VecList points = skin_.deform(state.position);
  double largest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i)
    largest = std::max(largest, (points[i] - surface_->vertices[i]).norm());
  return largest;
}
