// SPDX-License-Identifier: MIT
//
// A wound of 6 mm between two pieces of tissue is closed by stitches: the thread is pulled across the wound, then tied.
//   task_stitched_wound [stitches]   (1 to 9, 3 by default)
#include <phymul/phymul.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

constexpr double width = 0.03, length = 0.05, depth = 0.01, gap = 0.006;  // m

phymul::Model piece(double x) {
  return phymul::moved(phymul::make_tetrahedral_block({width, length, depth}, 8, 12, 4, 0.2, 5), {x, 0, 0});
}

/// m, between the means of both edges.
double gap_of(const phymul::Simulation& sim, const std::vector<phymul::Index>& left,
              const std::vector<phymul::Index>& right) {
  const phymul::State state = sim.state();
  const auto mean_x = [&](const std::vector<phymul::Index>& edge) {
    double sum = 0.0;
    for (const phymul::Index i : edge) sum += state.position[i].x();
    return sum / static_cast<double>(edge.size());
  };
  return mean_x(right) - mean_x(left);
}

/// As long as `full` for a share of 1.
std::string bar(double share, std::size_t full = 40) {
  return std::string(static_cast<std::size_t>(std::clamp(share, 0.0, 1.0) * static_cast<double>(full)), '#');
}

}  // namespace

int main(int argc, char** argv) try {
  const int stitches = argc > 1 ? std::clamp(std::atoi(argv[1]), 1, 9) : 3;
  const phymul::Model left = piece(-width - 0.5 * gap), right = piece(0.5 * gap);
  const std::array<phymul::NamedBody, 2> both{{{"left", &left}, {"right", &right}}};
  phymul::Simulation sim(phymul::merge_models(both),
                         {.material = {.young = 5e3, .poisson = 0.45, .density = 1000}, .damping = {.rate = 30}});
  phymul::Scene& scene = sim.scene();
  scene.fix("left/x0").fix("right/x1");
  const std::vector<phymul::Index> left_edge = sim.model().group("left/x1"), right_edge = sim.model().group("right/x0");

  const phymul::Thread suture{.length = 0.2, .friction = 0.1, .breaking_force = 10, .passage_limit = 1.5};
  std::vector<phymul::ThreadHandle> threads;
  for (int k = 0; k < stitches; ++k) {
    const double y = length * (k + 0.5) / stitches;
    threads.push_back(scene.sew(
        suture,
        phymul::VecList{{-0.007, y, depth}, {-0.004, y, 0.4 * depth}, {0.004, y, 0.4 * depth}, {0.007, y, depth}}));
  }
  std::puts("time    force   gap     tension under the wound");
  constexpr int rows = 12;
  for (int row = 0; row <= rows; ++row) {
    const double force = 0.03 * std::min(1.0, row / 8.0);  // N
    for (const phymul::ThreadHandle& thread : threads) {
      if (row < 9) {
        thread.pull(phymul::ThreadTip::first, {force, 0, 0});
        thread.pull(phymul::ThreadTip::last, {-force, 0, 0});
      } else if (row == 9) {
        thread.tie(0, 3, 4);
        thread.pull(phymul::ThreadTip::first, phymul::Vec3::Zero());
        thread.pull(phymul::ThreadTip::last, phymul::Vec3::Zero());
      }
    }
    if (const auto report = sim.advance(0.1); !report.ok()) return std::puts(report.message().c_str()), 1;
    double tension = 0.0;
    for (const phymul::ThreadHandle& thread : threads) {
      tension = std::max(tension, sim.solver().thread_state(thread).tension[2]);
    }
    const double now = gap_of(sim, left_edge, right_edge);
    std::printf("%.1f s  %s  %.2f mm  %.4f N  %s\n", sim.state().time, row < 9 ? "pulled" : "tied  ", 1e3 * now,
                tension, bar(now / gap).c_str());
  }
  std::printf("%d stitches close the wound from %.1f to %.1f mm\n", stitches, 1e3 * gap,
              1e3 * gap_of(sim, left_edge, right_edge));
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
