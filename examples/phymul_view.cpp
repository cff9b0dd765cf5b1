// SPDX-License-Identifier: MIT
//
// phymul-view [BODY] [LOADS]: a window in which a body moves. The solver runs in the window's own GL context, and the
// window is drawn from the solver's own textures.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <phymul/error.h>

#include <cctype>
#include <chrono>
#include <cstdio>

#include "view_input.h"
#include "view_options.h"
#include "view_simulation.h"
#include "view_window.h"

namespace {

using Clock = std::chrono::steady_clock;

/// The hands of a script: a key a frame; the mouse, which goes each of its ways in an equal number of frames, pressed
/// from the first of them to the last.
void play(ViewInput& input, const ViewOptions& options, int frame) {
  if (static_cast<std::size_t>(frame) < options.keys.size()) {
    // GLFW numbers keys by their capital letters, and has + on that of =.
    const int key = std::toupper(static_cast<unsigned char>(options.keys[static_cast<std::size_t>(frame)]));
    input.key(key == '+' ? GLFW_KEY_EQUAL : key);
  }
  const int ways = static_cast<int>(options.drag.size() / 4), frames = ways > 0 ? options.frames / ways : 0;
  if (frames < 2 || frame >= ways * frames) return;
  const double* const way = &options.drag[4 * static_cast<std::size_t>(frame / frames)];
  const double share = static_cast<double>(frame % frames) / (frames - 1);
  if (frame % frames == 0) input.button(GLFW_MOUSE_BUTTON_LEFT, false);
  input.cursor(way[0] + share * (way[2] - way[0]), way[1] + share * (way[3] - way[1]));
  if (frame % frames == 0) input.button(GLFW_MOUSE_BUTTON_LEFT, true);
}

int run(const ViewOptions& options) {
  const FileBody body = make_view_body(options);
  for (const std::string& note : body.model.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  ViewWindow window(options.width, options.height, options.hidden);
  ViewSimulation simulation(body, options);
  ViewInput input(simulation, window);
  window.listen(input);

  std::printf("%s\n", simulation.status().c_str());
  std::printf("drawn %s\n", simulation.display().zero_copy() ? "from the solver's own texture" : "from a copy");
  Clock::time_point then = Clock::now(), titled = then;
  for (int frame = 0; !window.closing() && (options.frames == 0 || frame < options.frames); ++frame) {
    play(input, options, frame);
    const Clock::time_point now = Clock::now();
    input.advance(std::chrono::duration<double>(now - then).count(),
                  options.frames == 0);  // a script is not in a hurry
    then = now;
    const auto [width, height] = window.size();
    if (width > 0 && height > 0) simulation.display().draw(input.camera(), input.layers(), 0, 0, width, height);
    const bool last = frame + 1 == options.frames;
    if (last && !options.png.empty()) window.save(options.png);
    window.swap();
    if (now - titled > std::chrono::milliseconds(250)) {
      titled = now;
      window.title(input.title());
    }
  }
  if (options.frames > 0) std::printf("%s\n", simulation.status().c_str());
  if (!simulation.failure().empty()) throw phymul::Error(simulation.failure());
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  int exit_code = 0;
  const std::optional<ViewOptions> options = read_view_options(argc, argv, exit_code);
  return options ? run(*options) : exit_code;
} catch (const std::exception& error) {
  std::fprintf(stderr, "phymul-view: %s\n", error.what());
  return 1;
}
