// SPDX-License-Identifier: MIT
#pragma once

#include <cairo.h>
#include <phymul/display.h>

#include <string>

/// A white sheet to draw on with cairo, which ends as a PNG file.
class Canvas {
 public:
  Canvas(int width, int height);
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;
  ~Canvas();

  cairo_t* cairo() const { return cairo_; }

  /// Copies a picture, taken as opaque; the sheet must have room for it there.
  void put(const phymul::Image& image, int left, int top);

  /// The file is whole or not there. Throws phymul::Error when it cannot be written.
  void save(const std::string& path) const;

 private:
  cairo_surface_t* surface_;
  cairo_t* cairo_;
};
