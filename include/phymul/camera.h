// SPDX-License-Identifier: MIT
//
// Camera: from where a body is looked at, and where its points are seen.
#pragma once

#include <phymul/types.h>

#include <span>

namespace phymul {

struct Camera {
  Vec3 eye{0, 0, 1};         ///< m
  Vec3 target{0, 0, 0};      ///< m, seen in the middle of the picture
  Vec3 up{0, 1, 0};          ///< shown upward
  double view_angle = 0.0;   ///< rad between the picture's lower and upper edge; 0: parallel rays
  double view_height = 1.0;  ///< m between the picture's lower and upper edge, where rays are parallel
  double near_plane = 0.0;   ///< m in front of the eye; nothing nearer is seen. Both 0: around the body
  double far_plane = 0.0;    ///< m in front of the eye; nothing farther is seen
};

/// A camera that sees all of `points` in a picture of width / height = aspect, from the direction `towards_eye`, z
/// upward (y, where one looks along z). Throws Error where there is no point or no direction, for a point that is not
/// finite, and for a view_angle that is not from 0 to below pi.
Camera framing(std::span<const Vec3> points, const Vec3& towards_eye, double aspect = 1.0, double view_angle = 0.0);

/// Unit vectors of the picture: to the right, upward, and from the picture to the eye. Throws Error where eye and
/// target coincide, or `up` points along the view.
struct CameraAxes {
  Vec3 right, up, towards_eye;
};
CameraAxes axes_of(const Camera& camera);

/// Where a point is seen in a picture: x to the right and y downward from its upper left corner, pixels, the first
/// pixel's centre at 0.5; z is the distance in front of the eye, m, along the view.
Vec3 to_pixel(const Camera& camera, const Vec3& point, int width, int height);

/// The point that to_pixel puts there.
Vec3 from_pixel(const Camera& camera, const Vec3& pixel, int width, int height);

/// Pixels that a metre at this point covers, across the view.
double pixels_per_metre(const Camera& camera, const Vec3& point, int height);

}  // namespace phymul
