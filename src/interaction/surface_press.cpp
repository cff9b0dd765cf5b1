// SPDX-License-Identifier: MIT
#include "surface_press.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace phymul {
namespace {

/// Of the longest edge at rest: what tool and body may use up lasts some tens of steps of a hand.
constexpr double room_in_edges = 1.0;

/// Below it, of the thickness, squared, depth_after() looks at the end alone.
constexpr double short_way = 0.2499;

/// Of half a box's thickness: what is less deep about its rim is so between its nearest faces.
constexpr double shallow = 0.1;

/// Of the distance from the box's middle: depths below it are what places round.
constexpr double rounded = 1e-13;

/// Whether a straight way stays beyond one face of a box.
bool passes_beside(const ShapeIn<double>& box, const Vector3<double>& from, const Vector3<double>& to) {
  const auto beyond = [&box](double a, double b, double half) {
    return std::min(a, b) > half + box.margin || std::max(a, b) < -half - box.margin;
  };
  return beyond(from.x, to.x, box.size.x) || beyond(from.y, to.y, box.size.y) || beyond(from.z, to.z, box.size.z);
}

/// As depth_after(): most ways are too short to pass through the tool.
Depth<double> depth_of(const ShapeIn<double>& shape, const Vector3<double>& from, const Vector3<double>& to,
                       const Vector3<double>& way) {
  if (shape.kind == ShapeKind::box && passes_beside(shape, from, to)) return {};
  if (inner_product(way, way) > short_way * shape.thickness * shape.thickness) return depth_after(shape, from, to, way);
  const Distance<double> end = distance_to(shape, to);
  return {-end.phi, end.normal};
}

}  // namespace

SurfacePress::SurfacePress(const ContactSurface& surface, const Model& model, const Tool& tool)
    : points_(make_contact_points(surface, tool)), corner_of_(model.rest.size(), -1) {
  corners_.reserve(model.rest.size());
  loaded_.reserve(model.rest.size());
  near_.reserve(points_.patches.size());
  met_.reserve(points_.patches.size());
  pressed_.reserve(points_.most_points + model.rest.size());
  below_.reserve(std::holds_alternative<Box>(tool.shape) ? points_.patches.size() : 0);
  for (const ContactPoints::Patch& patch : points_.patches) {
    for (const Index a : patch.particles()) {
      for (const Index b : patch.particles()) {
        room_ = std::max(room_, room_in_edges * (model.rest[a] - model.rest[b]).norm());
      }
    }
  }
}

/// A triangle comes nearer to the tool by no more than both go, and its corners leave its middle by no more than twice
/// what the body goes.
bool SurfacePress::knows_near(const ShapeIn<double>& shape, const ToolFrame& start, const ToolFrame& end,
                              const TouchedParticles& touched) const {
  const auto moved = [&](const ToolFrame& from, const ToolFrame& to) {
    return (to.position - from.position).norm() + (to.turn - from.turn).norm() * (lever_ + room_);
  };
  const double going = touched.going(), body = touched.step().gone() - gone_ + going_ + going;
  const double used = 3.0 * body + moved(then_, end) + going + moved(start, end);
  // Distances in a grid, and beyond it, may change faster than places do.
  return (shape.kind == ShapeKind::grid ? 2.0 : 1.0) * used <= room_;
}

void SurfacePress::find_near(const ShapeIn<double>& shape, const ToolFrame& start, const ToolFrame& end,
                             const TouchedParticles& touched) {
  then_ = end;
  gone_ = touched.step().gone();
  going_ = touched.going();
  near_.clear();
  corners_.clear();
  for (Index patch = 0; patch < static_cast<Index>(points_.patches.size()); ++patch) {
    if (may_touch(shape, corners_of(patch, start, end, touched), room_)) near_.push_back(patch);
  }
  lever_ = 0.0;
  for (const Corner& corner : corners_) {
    lever_ = std::max(lever_, corner.to.norm());
    corner_of_[corner.row] = -1;
  }
}

SurfacePress::Corners SurfacePress::corners_of(Index patch, const ToolFrame& start, const ToolFrame& end,
                                               const TouchedParticles& touched) {
  Corners all{};
  for (const Index row : points_.patches[patch].particles()) {
    if (corner_of_[row] < 0) {
      corner_of_[row] = static_cast<Index>(corners_.size());
      Corner& made = corners_.emplace_back();
      made.row = row;
      made.from = start.inside(touched.start(row));
      made.to = end.inside(touched.end(row));
    }
    all.row[static_cast<std::size_t>(all.count++)] = static_cast<std::size_t>(corner_of_[row]);
  }
  return all;
}

/// Whether a point of the triangle may be in the tool at the step's end, or have gone through it, if it comes nearer by
/// `room`, m.
bool SurfacePress::may_touch(const ShapeIn<double>& shape, const Corners& of, double room) const {
  if (shape.kind == ShapeKind::box) {
    Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
    for (const std::size_t c : of.rows()) {
      low = low.cwiseMin(corners_[c].from.cwiseMin(corners_[c].to));
      high = high.cwiseMax(corners_[c].from.cwiseMax(corners_[c].to));
    }
    const Vec3 reach = packed(shape.size) + Vec3::Constant(shape.margin + room);
    return (low.array() <= reach.array()).all() && (high.array() >= -reach.array()).all();
  }
  Vec3 middle(0, 0, 0);
  for (const std::size_t c : of.rows()) middle += corners_[c].to / of.count;
  double far = 0.0, way = 0.0;  // squared
  for (const std::size_t c : of.rows()) {
    far = std::max(far, (corners_[c].to - middle).squaredNorm());
    way = std::max(way, (corners_[c].to - corners_[c].from).squaredNorm());
  }
  return distance_to(shape, unpacked(middle)).phi <= std::sqrt(far) + std::sqrt(way) + room;
}

/// Whether no point of the triangle passes through what is so thick, m, in this step.
bool SurfacePress::is_short(const Corners& of, double thickness) const {
  return std::ranges::all_of(of.rows(), [&](std::size_t c) {
    return (corners_[c].to - corners_[c].from).squaredNorm() <= short_way * thickness * thickness;
  });
}

/// A flat face that presses all corners of a triangle presses the points in between as well: then the corners act, for
/// all of them.
bool SurfacePress::is_before_one_face(const BoxPlanes& box, const Corners& of) const {
  const int face = face_of(box, corners_[of.row[0]].to);
  return face >= 0 &&
         std::ranges::all_of(of.rows(), [&](std::size_t c) { return face == face_of(box, corners_[c].to); });
}

std::optional<BoxPlanes> SurfacePress::planes_for(const ShapeIn<double>& box, const Corners& of, bool placed) const {
  const Vec3 half = packed(box.size);
  BoxPlanes planes{-half, half};
  if (!placed && is_short(of, box.thickness)) return planes;
  int axis = 0;
  half.minCoeff(&axis);
  const auto side_of = [&](std::size_t c) { return corners_[c].from[axis] < 0.0 ? -1.0 : 1.0; };
  const double side = side_of(of.row[0]);
  Vec3 wide = half;
  wide[axis] = HUGE_VAL;
  if (!is_short(of, wide.minCoeff())) return std::nullopt;
  double past = 0.0;  // m, the middle
  for (const std::size_t c : of.rows()) past = std::max(past, -side_of(c) * corners_[c].to[axis]);
  if (std::ranges::any_of(of.rows(), [&](std::size_t c) { return side_of(c) != side; })) {  // about the rim
    const DepthInBox in = depth_in(planes, places(of, &Corner::to), 1.0);
    return past > 0.0 || in.square > shallow * half[axis] * in.whole ? std::nullopt : std::optional(planes);
  }
  (side > 0.0 ? planes.low : planes.high)[axis] -= side * 4.0 * past;  // twice would leave both sides equally near
  return planes;
}

Vec3 SurfacePress::mean(const ContactPoints::Shares& share, const Corners& of, Vec3 Corner::*place) const {
  const auto part = [&](std::size_t c) { return share[c] * corners_[of.row[c]].*place; };
  if (of.count == 3) return part(0) + part(1) + part(2);  // nearly all, unrolled
  Vec3 sum = part(0);
  for (std::size_t c = 1; c < of.rows().size(); ++c) sum += part(c);
  return sum;
}

/// Keeps a point that is in the tool at the step's end.
void SurfacePress::find(const ShapeIn<double>& shape, const Corners& of, const ContactPoints::Shares& share,
                        double area) {
  const Vector3<double> from = unpacked(mean(share, of, &Corner::from)), to = unpacked(mean(share, of, &Corner::to));
  const double depth = depth_of(shape, from, to, to - from).depth;
  if (!(depth > 0.0)) return;
  pressed_.push_back({of, share, area * depth});
  for (std::size_t c = 0; c < of.rows().size(); ++c) corners_[of.row[c]].load += share[c] * area * depth;
}

/// Finds the patches that may touch.
void SurfacePress::meet(const ShapeIn<double>& shape, const ToolFrame& start, const ToolFrame& end,
                        const TouchedParticles& touched, bool placed) {
  corners_.clear();
  loaded_.clear();
  met_.clear();
  const double room = shape.kind == ShapeKind::box ? touched.going() : 0.0;  // a later look may find what comes nearer
  for (const Index row : near_) {
    const Corners of = corners_of(row, start, end, touched);
    if (!may_touch(shape, of, room)) continue;
    Met& met = met_.emplace_back(Met{.corner = of, .patch = &points_.patches[row]});
    met.is_triangle = of.count == 3 && !met.patch->of_cut_cell;
    if (met.is_triangle && shape.kind == ShapeKind::box) met.box = planes_for(shape, of, placed);
  }
  for (const Corner& corner : corners_) corner_of_[corner.row] = -1;
}

/// Finds the points that touch, their load on each particle, and what that makes of them.
void SurfacePress::find_points(const ShapeIn<double>& shape, const ContactLaw<double>& law, TouchedParticles& touched) {
  const double dt = touched.dt();
  pressed_.clear();
  below_.clear();
  for (Corner& corner : corners_) corner.load = corner.area = 0.0;
  for (const Met& met : met_) {
    const auto& [of, patch, is_triangle, box] = met;
    const double area = patch->area * static_cast<double>(patch->points->size());
    if (box ? is_before_one_face(*box, of) : is_triangle && shape.kind == ShapeKind::half_space) {
      for (const std::size_t c : of.rows()) corners_[c].area += area / 3.0;
    } else if (box && shape.margin == 0.0) {
      look_below(*box, of, area, law.placed && law.compliance == 0.0);
    } else {
      for (const ContactPoints::Shares& share : *patch->points) find(shape, of, share, patch->area);
    }
  }
  // The same corner of several triangles is one point.
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    if (corners_[k].area > 0.0) find(shape, {{k}, 1}, {1.0}, corners_[k].area);
  }
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    Corner& corner = corners_[k];
    if (!(corner.load > 0.0) || corner.slot) continue;
    loaded_.push_back(k);
    corner.slot = touched.slot(corner.row);
    const TouchedParticles::Touched& particle = touched[*corner.slot];
    corner.inverse_mass = particle.held || particle.fixed == 7 ? 0.0 : particle.inverse_mass;
    corner.fixed = particle.fixed;
  }
  for (auto& [of, share, load, crowd] : pressed_) {
    for (std::size_t c = 0; c < of.rows().size(); ++c) {
      const double part = share[c] * corners_[of.row[c]].load / load;
      crowd.inverse_mass += part * corners_[of.row[c]].inverse_mass;
      crowd.crowd += part;
    }
  }
  for (Below& below : below_) {
    double crowd = 0.0;  // as of a point
    for (int c = 0; c < 3; ++c) {
      const Corner& corner = corners_[below.corner.row[static_cast<std::size_t>(c)]];
      if (!(below.in.load[c] > 0.0)) continue;
      // Pushes of opposite faces cancel each other, and a triangle through a box would go far for what little is left.
      const double own = below.in.push.col(c).norm(), least = 0.5 * below.in.load[c];
      const double part = own * std::max(own, least) * corner.load / below.in.load[c];
      below.inverse_mass += part * corner.inverse_mass;
      crowd += part;
    }
    if (below.inverse_mass > 0.0) below.gain = dt / (law.compliance * crowd + dt * dt * below.inverse_mass);
  }
}

/// Keeps a triangle that is in the box.
void SurfacePress::look_below(const BoxPlanes& box, const Corners& of, double area, bool comes_out) {
  const std::array<Vec3, 3> to = places(of, &Corner::to);
  const DepthInBox in = depth_in(box, to, area);
  if (!(in.whole > 0.0 && in.square > rounded * to[0].norm() * in.whole)) return;
  Below& made = below_.emplace_back(Below{.corner = of, .in = in, .out = in.square});
  for (int c = 0; c < 3; ++c) {
    Corner& corner = corners_[of.row[static_cast<std::size_t>(c)]];
    made.out += in.push.col(c).dot(corner.to);
    corner.load += in.load[c];
  }
  if (comes_out)
    made.before = std::min(1.0, std::sqrt(depth_in(box, places(of, &Corner::from), area).square / in.square));
}

/// Particles take nothing before hand_over(). m, how deep the point was; 0: there is nothing for them.
double SurfacePress::press(const ShapeIn<double>& shape, const ContactLaw<double>& law, const Pressed& point,
                           double dt) {
  const auto [inverse_mass, crowd] = point.crowd;
  if (!(inverse_mass > 0.0)) return 0.0;
  const Vector3<double> from = unpacked(mean(point.share, point.corner, &Corner::from));
  const Vector3<double> to = unpacked(mean(point.share, point.corner, &Corner::to));
  const Depth<double> in = depth_of(shape, from, to, to - from);
  if (!(in.depth > 0.0)) return 0.0;
  ContactLaw<double> own_law = law;
  own_law.friction = 0.0;       // rub(): so the point's way does not count
  own_law.compliance *= crowd;  // so that a patch that moves as one is as compliant as its particles
  const Touch<double> touch = touch_at_depth(shape, own_law, in, from, {}, inverse_mass, dt);
  for (std::size_t c = 0; c < point.corner.rows().size(); ++c) {
    Corner& corner = corners_[point.corner.row[c]];
    corner.impulse += point.share[c] * packed(touch.impulse);
    corner.shift += point.share[c] / inverse_mass * packed(touch.shift);
  }
  return in.depth;
}

/// The same for a triangle over a box's edges.
double SurfacePress::press_below(const Below& below) {
  const auto corner = [&](int c) -> Corner& { return corners_[below.corner.row[static_cast<std::size_t>(c)]]; };
  const Mat3& push = below.in.push;
  double deep = below.out;  // m^4
  for (int c = 0; c < 3; ++c) deep -= push.col(c).dot(corner(c).to);
  if (!(deep > 0.0) || below.gain == 0.0) return 0.0;
  for (int c = 0; c < 3; ++c) {
    corner(c).impulse += (1.0 - below.before) * deep * below.gain * push.col(c);
    corner(c).shift += below.before * deep / below.inverse_mass * push.col(c);
  }
  return deep / below.in.whole;
}

/// An impulse and a shift, in the tool's frame, to a particle that can take it.
Vec3 SurfacePress::give(Corner& corner, const Vec3& impulse, const Vec3& shift, const ToolFrame& end,
                        const TouchedParticles& touched) {
  const auto taken = [&](const Vec3& v) -> Vec3 {
    return corner.fixed == 0 ? v : Vec3(end.turn.transpose() * free_part(end.turn * v, corner.fixed));
  };
  const Vec3 given = taken(impulse), by = taken(shift);
  corner.given += given;
  corner.shifted += by;
  corner.from += by;
  corner.to += touched.dt() * corner.inverse_mass * given + by;
  return given;
}

/// What a round's points gave. Compliance may leave a particle in the tool: later rounds take that for its surface.
void SurfacePress::hand_over(double compliance, const ToolFrame& end, const TouchedParticles& touched) {
  for (const std::size_t k : loaded_) {
    Corner& corner = corners_[k];
    if (corner.inverse_mass > 0.0) {
      const Vec3 given = give(corner, corner.impulse, corner.inverse_mass * corner.shift, end, touched);
      corner.to += compliance / touched.dt() * given;
      corner.pressed += corner.impulse;
    }
    corner.impulse = corner.shift = Vec3::Zero();
  }
}

void SurfacePress::rub(double friction, const ToolFrame& end, const TouchedParticles& touched) {
  for (const std::size_t k : loaded_) {
    Corner& corner = corners_[k];
    const double press = corner.pressed.norm();
    if (!(press > 0.0)) continue;
    const Vec3 normal = corner.pressed / press;
    const auto along = [&](const Vec3& v) { return Vec3(v - normal.dot(v) * normal); };
    const double stop = 1.0 / (touched.dt() * corner.inverse_mass);
    Vec3 wanted = along(corner.rubbed - stop * (corner.to - corner.from));
    const double most = friction * press, size = wanted.norm();
    if (size > most) wanted *= most / size;
    give(corner, wanted - corner.rubbed, Vec3::Zero(), end, touched);
    corner.rubbed = wanted;
  }
}

/// m: how deep the points were that touch.
double SurfacePress::press_all(const ShapeIn<double>& shape, const ContactLaw<double>& law, const ToolFrame& start,
                               const ToolFrame& end, TouchedParticles& touched, ToolForce& force) {
  const double dt = touched.dt();
  meet(shape, start, end, touched, law.placed);
  double deepest = 0.0;
  const int rounds = rounds_of_surface(law.placed);
  for (int round = 0; round < rounds; ++round) {
    const bool looks = round == 0 || (shape.kind == ShapeKind::box && round % (rounds / looks_at_box) == 0);
    if (looks) find_points(shape, law, touched);
    double deep = 0.0;
    for (const Pressed& point : pressed_) deep = std::max(deep, press(shape, law, point, dt));
    for (const Below& below : below_) deep = std::max(deep, press_below(below));
    deepest = std::max(deepest, deep);
    const bool is_out = deep == 0.0 && (looks || below_.empty());
    if (deep > 0.0) hand_over(law.compliance, end, touched);
    if (law.friction > 0.0 && (is_out || round % 2 == 1)) rub(law.friction, end, touched);
    if (is_out) break;
  }
  for (const std::size_t k : loaded_) {
    const Corner& corner = corners_[k];
    if (corner.given == Vec3::Zero() && corner.shifted == Vec3::Zero()) continue;
    TouchedParticles::Touched& particle = touched[*corner.slot];
    const Vec3 given = TouchedParticles::push(particle, end.turn * corner.given);
    particle.shift += particle.free_part(end.turn * corner.shifted);
    if (law.friction > 0.0 && corner.pressed != Vec3::Zero()) {
      particle.rubbed = law.friction * (end.turn * corner.pressed.normalized());
    }
    if (given == Vec3::Zero()) continue;
    react(force, end, particle.position, given + dt * TouchedParticles::borne(particle, given), dt);
  }
  return deepest;
}

void SurfacePress::act(const ShapeIn<double>& shape, const ContactLaw<double>& law, const ToolFrame& start,
                       const ToolFrame& end, TouchedParticles& touched, ToolForce& force) {
  if (!knows_near(shape, start, end, touched)) find_near(shape, start, end, touched);
  const int others = force.particles;
  double deep = press_all(shape, law, start, end, touched, force);
  if (!law.placed || law.compliance > 0.0 || !lets_surface_out(touched.dt(), touched.last_dt())) return;
  const double may_stay = deep * std::pow(touched.dt() / touched.last_dt(), 2);
  int most = force.particles;  // each of them once
  for (int again = 0; again < most_again && deep > may_stay; ++again) {
    force.particles = others;
    deep = press_all(shape, law, start, end, touched, force);
    most = std::max(most, force.particles);
  }
  force.particles = most;
}

}  // namespace phymul
