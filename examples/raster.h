// SPDX-License-Identifier: MIT
//
// Lit triangles and lines with a depth buffer, on the processor: the same picture on every machine, and bodies and
// tools that go into each other are cut where they meet.
#pragma once

#include <phymul/camera.h>
#include <phymul/display.h>

#include <array>
#include <cstdint>
#include <vector>

class Raster {
 public:
  /// Pixels of the picture; for cameras with parallel rays.
  Raster(const phymul::Camera& camera, int width, int height);

  struct Corner {
    phymul::Vec3 place;   ///< m
    phymul::Vec3 normal;  ///< unit; either way, both sides are lit
    phymul::Colour colour;
  };
  /// `shine` in [0, 1]: share of the light that it reflects as a mirror. A triangle with an opacity below 1 must come
  /// after everything that shows through it.
  void triangle(const std::array<Corner, 3>& corners, double shine = 0.0, double opacity = 1.0);

  /// `width` in pixels; `nearer`: m by which it is taken to be nearer to the eye, so that it shows on a surface.
  void line(const phymul::Vec3& from, const phymul::Vec3& to, const phymul::Colour& colour, double width,
            double nearer);
  /// Dashes of `dash` pixels and as long gaps.
  void dashed_line(const phymul::Vec3& from, const phymul::Vec3& to, const phymul::Colour& colour, double width,
                   double nearer, double dash);

  phymul::Image image() const;  ///< each pixel the mean of its samples

 private:
  struct Sample {
    float depth;
    std::array<std::uint8_t, 3> colour;
  };
  struct Point {
    phymul::Vec3 seen;             ///< samples, and m in front of the eye
    phymul::Vec3 normal;           ///< as Corner
    phymul::Vec3 colour{0, 0, 0};  ///< red, green, blue
  };
  phymul::Vec3 seen(const phymul::Vec3& place) const;
  template <class Shade>
  void fill(const std::array<Point, 3>& points, double opacity, Shade shade);

  const phymul::Camera camera_;
  const int width_, height_;  // samples
  phymul::Vec3 light_, half_way_;
  std::vector<Sample> samples_;
};
