// SPDX-License-Identifier: MIT
#include "view_scalpel.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace {

using phymul::Vec3;

constexpr const char* name = "scalpel";
constexpr double first_way = 2.0;  // pixels; before, a hand has no direction

}  // namespace

Scalpel::Scalpel(phymul::Simulation& sim, const phymul::Model& body)
    : sim_(sim), width_(3.0 * body_size(body)), longest_way_(0.8 * mean_spacing(body)), middle_(0, 0, 0) {
  for (const Vec3& place : body.rest) middle_ += place / static_cast<double>(body.rest.size());
}

void Scalpel::begin(double x, double y) {
  end();
  place_ = {x, y};
}

void Scalpel::move(const phymul::Camera& camera, double x, double y, int width, int height) {
  if (!place_) return;
  const double depth = to_pixel(camera, middle_, width, height).z();
  const auto at = [&](double share) {
    return from_pixel(camera, {place_->x(), place_->y(), share * depth}, width, height);
  };
  const Eigen::Vector2d way = Eigen::Vector2d(x, y) - *place_;
  if (way.norm() < (blade_ ? 1e-6 : first_way)) return;
  const Vec3 before = at(1.0);
  *place_ += std::min(1.0, longest_way_ * pixels_per_metre(camera, middle_, height) / way.norm()) * way;

  phymul::Mat3 axes;
  axes.col(0) = (at(1.0) - at(0.5)).normalized();
  const Vec3 forward = at(1.0) - before;
  axes.col(2) = -(forward - forward.dot(axes.col(0)) * axes.col(0)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  phymul::ToolPose pose{.position = before, .orientation = phymul::Quaternion(Eigen::Quaterniond(axes))};
  if (!blade_) blade_ = sim_.scene().add_tool(name, {.shape = phymul::Blade{.width = width_}, .pose = pose});
  pose.position = at(1.0);
  blade_->move_to(pose);
}

void Scalpel::end() {
  if (blade_) sim_.scene().remove_tool(name);
  blade_.reset();
  place_.reset();
}
