// SPDX-License-Identifier: MIT
//
// Draws a bent block and looks at the pixels: a body is there, in many colours, with its marks, and a picture of the
// rest shape differs.
#include <cairo.h>
#include <phymul/error.h>
#include <phymul/shapes.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <set>
#include <string>

#include "picture.h"

namespace {

struct Pixels {
  std::set<std::uint32_t> colours;
  int painted = 0;  ///< not white
  int red = 0;      ///< as the marks of driven particles
  int total = 0;
};

Pixels pixels_of(const std::string& path) {
  Pixels pixels;
  cairo_surface_t* image = cairo_image_surface_create_from_png(path.c_str());
  const int width = cairo_image_surface_get_width(image);
  const int height = cairo_image_surface_get_height(image);
  for (int y = 0; y < height; ++y) {
    const unsigned char* row = cairo_image_surface_get_data(image) + y * cairo_image_surface_get_stride(image);
    for (int x = 0; x < width; ++x) {
      std::uint32_t colour = 0;
      std::memcpy(&colour, row + 4 * x, sizeof colour);
      colour &= 0xFFFFFF;
      pixels.colours.insert(colour);
      pixels.painted += colour != 0xFFFFFF;
      pixels.red += (colour >> 16) > 200 && (colour >> 8 & 255) < 60 && (colour & 255) < 60;
      ++pixels.total;
    }
  }
  cairo_surface_destroy(image);
  return pixels;
}

bool failed = false;

void expect(bool holds, const char* what) {
  if (holds) return;
  std::printf("failed: %s\n", what);
  failed = true;
}

}  // namespace

int main() try {
  const phymul::Model model = phymul::make_block({0.04, 0.02, 0.02}, 8, 4, 4);
  phymul::State state = phymul::rest_state(model);
  PictureOptions options;
  options.title = "block";
  draw_picture(model, state, options, "picture_check.png");
  const Pixels rest = pixels_of("picture_check.png");

  for (phymul::Vec3& x : state.position) x.z() -= 10.0 * x.x() * x.x();
  options.fixed = model.group("x0");
  options.driven = model.group("x1");
  draw_picture(model, state, options, "picture_check.png");
  const Pixels bent = pixels_of("picture_check.png");

  expect(rest.total == options.width * options.height, "the picture has the size asked for");
  expect(rest.painted > rest.total / 10 && rest.painted < rest.total / 10 * 9, "the body fills a part of the picture");
  expect(bent.painted > bent.total / 20, "the bent body is there");
  expect(bent.colours.size() > 200, "displacement gives many colours");
  expect(rest.red == 0 && bent.red > 100, "driven particles are marked");
  try {
    draw_picture(model, state, options, "no such folder/picture.png");
    expect(false, "a picture that cannot be written is an error");
  } catch (const phymul::Error&) {
  }
  std::printf("%d of %d pixels painted, %zu colours\n", bent.painted, bent.total, bent.colours.size());
  return failed ? 1 : 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
