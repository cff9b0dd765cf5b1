// SPDX-License-Identifier: MIT
//
// picture_check: draws a bent block and checks the pixels: a body is there, in many colours, with its marks, and a
// picture of the rest shape differs.
// picture_check FILE.png: checks that something is painted there.
#include <cairo.h>
#include <phymul/error.h>
#include <phymul/shapes.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <set>
#include <string>

#include "scene_picture.h"

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

int check_drawing() {
  const phymul::Model model = phymul::make_block({0.04, 0.02, 0.02}, 8, 4, 4);
  const ScenePictures pictures(model);
  const char* file = "picture_check.png";
  phymul::State state = phymul::rest_state(model);
  ScenePictureOptions options;
  options.title = "block";
  pictures.draw(state, options, file);
  const Pixels rest = pixels_of(file);

  for (phymul::Vec3& x : state.position) x.z() -= 10.0 * x.x() * x.x();
  options.held = model.group("x0");
  options.driven = model.group("x1");
  pictures.draw(state, options, file);
  const Pixels bent = pixels_of(file);

  expect(rest.total == options.width * options.height, "the picture has the size asked for");
  expect(rest.painted > rest.total / 10 && rest.painted < rest.total / 10 * 9, "the body fills a part of the picture");
  expect(bent.painted > bent.total / 20, "the bent body is there");
  expect(bent.colours.size() > 200, "displacement gives many colours");
  expect(rest.red == 0 && bent.red > 100, "driven particles are marked");
  try {
    pictures.draw(state, options, "no such folder/picture.png");
    expect(false, "a picture that cannot be written is an error");
  } catch (const phymul::Error&) {
  }
  std::printf("%d of %d pixels painted, %zu colours\n", bent.painted, bent.total, bent.colours.size());
  return failed ? 1 : 0;
}

int check_file(const std::string& path) {
  const Pixels pixels = pixels_of(path);
  expect(pixels.painted > pixels.total / 50 && pixels.painted < pixels.total, "a body is there, and not only a body");
  expect(pixels.colours.size() > 3, "it is lit");  // a tetrahedron shows two faces and their edges
  std::printf("%s: %d of %d pixels painted, %zu colours\n", path.c_str(), pixels.painted, pixels.total,
              pixels.colours.size());
  return failed ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "--help" || what == "-h") {
    std::puts("picture_check [FILE.png]\nChecks a picture of a bent block that it draws, or that a file is painted.");
    return 0;
  }
  return what.empty() ? check_drawing() : check_file(what);
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
