// SPDX-License-Identifier: MIT
//
// What page.js calls. Every function that can fail returns 0 then, and page_error() has the sentence.
#include <emscripten/emscripten.h>
#include <emscripten/html5_webgl.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string>

#include "comparison.h"
#include "liver_shape.h"
#include "organ.h"
#include "step_times.h"

namespace {

std::unique_ptr<Organ> organ;
std::unique_ptr<Comparison> comparison;
std::string text;  // that a function returned last
std::string error;

template <class Function>
int tried(Function&& function) {
  try {
    error.clear();
    function();
    return 1;
  } catch (const std::exception& caught) {
    error = caught.what();
  } catch (...) {
    error = "unknown error";
  }
  return 0;
}

std::string quoted(const std::string& plain) {
  std::string all = "\"";
  for (const char c : plain) {
    if (c == '"' || c == '\\') all += '\\';
    all += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return all + '"';
}

std::string field(const char* name, const std::string& value) {
  return std::string(text.empty() ? "{" : ", ") + '"' + name + "\": " + value;
}

void add(const char* name, double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.9g", value);
  text += field(name, digits);
}

void add(const char* name, const std::string& value) {
  text += field(name, quoted(value));
}

const char* finished_text() {
  text += '}';
  return text.c_str();
}

/// Triangles of a binary STL file, in mm.
phymul::Surface read_stl(const unsigned char* bytes, std::size_t size) {
  constexpr std::size_t head = 84, row = 50;
  std::uint32_t count = 0;
  if (size >= head) std::memcpy(&count, bytes + head - 4, sizeof count);
  if (size < head || size != head + row * std::size_t{count}) {
    throw phymul::Error("this is no binary STL file: expected 84 bytes and 50 for each triangle; export it as binary");
  }
  phymul::Surface surface;
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      float x[3];
      std::memcpy(x, bytes + head + row * k + 12 + 12 * corner, sizeof x);
      surface.vertices.push_back(1e-3 * phymul::Vec3(x[0], x[1], x[2]));
    }
    const auto first = static_cast<phymul::Index>(3 * k);
    surface.triangles.push_back({first, first + 1, first + 2});
  }
  phymul::mend_surface(surface);
  return surface;
}

void fill(phymul::Surface surface, double spacing, const char* backend) {
  const auto shared = std::make_shared<const phymul::Surface>(std::move(surface));
  auto made = std::make_unique<Organ>(shared, spacing, backend);
  comparison = std::make_unique<Comparison>(shared, spacing);
  organ = std::move(made);
}

}  // namespace

extern "C" {

EMSCRIPTEN_KEEPALIVE const char* page_error() {
  return error.c_str();
}

/// Makes the context of the canvas with this CSS selector.
EMSCRIPTEN_KEEPALIVE int page_open(const char* canvas) {
  return tried([&] {
    EmscriptenWebGLContextAttributes attributes;
    emscripten_webgl_init_context_attributes(&attributes);
    attributes.majorVersion = 2;
    attributes.alpha = false;
    const EMSCRIPTEN_WEBGL_CONTEXT_HANDLE context = emscripten_webgl_create_context(canvas, &attributes);
    if (context <= 0) throw phymul::Error("this browser has no WebGL 2, which the picture needs");
    emscripten_webgl_make_context_current(context);
  });
}

/// Empty where the backend can run here.
EMSCRIPTEN_KEEPALIVE const char* page_why_unavailable(const char* backend) {
  phymul::SolverOptions options;
  options.gl.context = phymul::GlContext::current;
  if (!tried([&] { text = phymul::why_unavailable(backend, options); })) text = error;
  return text.c_str();
}

EMSCRIPTEN_KEEPALIVE int page_fill_liver(double spacing, const char* backend) {
  return tried([&] { fill(liver_surface(0.006), spacing, backend); });
}

EMSCRIPTEN_KEEPALIVE int page_fill_stl(const unsigned char* bytes, int size, double spacing, const char* backend) {
  return tried([&] { fill(read_stl(bytes, static_cast<std::size_t>(size)), spacing, backend); });
}

EMSCRIPTEN_KEEPALIVE int page_use(const char* backend) {
  return tried([&] { organ->use(backend); });
}

EMSCRIPTEN_KEEPALIVE int page_reset() {
  return tried([&] { organ->reset(); });
}

EMSCRIPTEN_KEEPALIVE int page_frame(double seconds, int width, int height) {
  return tried([&] {
    organ->advance(seconds);
    organ->draw(width, height);
  });
}

EMSCRIPTEN_KEEPALIVE int page_take(double x, double y, int width, int height) {
  bool taken = false;
  return tried([&] { taken = organ->take(x, y, width, height); }) && taken;
}

EMSCRIPTEN_KEEPALIVE int page_move(double x, double y, int width, int height) {
  return tried([&] { organ->move(x, y, width, height); });
}

EMSCRIPTEN_KEEPALIVE int page_release() {
  return tried([&] { organ->release(); });
}

EMSCRIPTEN_KEEPALIVE void page_turn(double right, double up) {
  organ->turn(right, up);
}

EMSCRIPTEN_KEEPALIVE void page_zoom(double factor) {
  organ->zoom(factor);
}

/// JSON, lengths in m and times in s.
EMSCRIPTEN_KEEPALIVE const char* page_status() {
  text.clear();
  add("backend", std::string(organ->solver().name()));
  add("device", organ->solver().device());
  add("particles", organ->model().particle_count());
  add("cells", static_cast<double>(organ->model().cells.size()));
  add("time", organ->time());
  add("stepsPerSecond", organ->steps_per_second());
  add("speed", organ->speed());
  add("held", organ->holds() ? 1.0 : 0.0);
  add("pull", organ->last_pull().displacement.norm());
  add("moved", organ->largest_displacement());
  add("failure", organ->failure());
  return finished_text();
}

/// JSON of the error of the last pull against the finer body; empty where it failed.
EMSCRIPTEN_KEEPALIVE const char* page_compare() {
  PullError found;
  if (!tried([&] { found = comparison->error_of(organ->last_pull()); })) return "";
  text.clear();
  add("mean", found.mean);
  add("largest", found.largest);
  add("moved", found.moved);
  add("particles", found.particles);
  add("spacing", found.spacing);
  return finished_text();
}

/// JSON of particles and seconds of a step; empty where it failed.
EMSCRIPTEN_KEEPALIVE const char* page_step_time(int side, const char* backend) {
  StepTime found;
  if (!tried([&] { found = step_time(side, backend); })) return "";
  text.clear();
  add("particles", found.particles);
  add("seconds", found.seconds);
  return finished_text();
}

/// Largest distance between the bodies of two backends after `steps` steps from a stretched start, over the largest
/// displacement; -1 where it failed.
EMSCRIPTEN_KEEPALIVE double page_difference(const char* backend, const char* other, int steps) {
  double share = -1.0;
  tried([&] {
    const phymul::Model& model = organ->model();
    phymul::Scene scene(model);
    scene.fix(organ_foot(model));
    phymul::State start = phymul::rest_state(model), ends[2];
    for (phymul::Vec3& x : start.position) x.x() *= 1.1;
    const char* names[] = {backend, other};
    for (int k = 0; k < 2; ++k) {
      phymul::SolverOptions options;
      options.threads = 1;
      options.gl.context = phymul::GlContext::current;
      const auto solver = phymul::make_solver(names[k], model, scene, {}, options);
      solver->reset(start);
      const phymul::StepReport report = solver->step(steps, 0.4 * solver->stable_step());
      if (!report.ok()) throw phymul::Error(report.message());
      ends[k] = solver->read();
    }
    double apart = 0.0, moved = 0.0;
    for (std::size_t i = 0; i < model.rest.size(); ++i) {
      apart = std::max(apart, (ends[0].position[i] - ends[1].position[i]).norm());
      moved = std::max(moved, (ends[0].position[i] - model.rest[i]).norm());
    }
    share = apart / moved;
  });
  return share;
}
}
