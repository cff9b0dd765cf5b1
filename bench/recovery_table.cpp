// SPDX-License-Identifier: MIT
//
// From which broken states a body finds back to its rest shape: a cube of 125 particles of soft tissue, 12,000 steps
// with d = 0.99. `recovery_table [share of the stable step]`, default 0.2 and 0.5; takes minutes in the reference
// backend.
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "bodies.h"

namespace {

using namespace phymul;
using namespace phymul::test;

constexpr double side = 0.04, spacing = 0.01;
const Vec3 middle(side / 2, side / 2, side / 2);

struct Failure {
  const char* name;
  std::function<void(VecList&, std::mt19937&)> apply;
};

void shake(VecList& x, std::mt19937& bits, double amount) {
  for (Vec3& p : x) p += amount * spacing * random_vector(bits, 3);
}

void each(VecList& x, const std::function<Vec3(const Vec3&)>& move) {
  for (Vec3& p : x) p = move(p);
}

Vec3 twisted(const Vec3& p) {
  const double angle = 2.0 * 3.14159265358979323846 * p.z() / side;
  return Eigen::AngleAxisd(angle, Vec3::UnitZ()) * (p - middle) + middle;
}

void onto(VecList& x, int axes) {
  each(x, [axes](Vec3 p) {
    for (int axis = 3 - axes; axis < 3; ++axis) p[axis] = side / 2;
    return p;
  });
}

void scatter(VecList& x, std::mt19937& bits, double reach) {
  for (Vec3& p : x) p = middle + reach * random_vector(bits, 3);
}

const std::vector<Failure>& failures() {
  static const std::vector<Failure> all{
      {"flat", [](VecList& x, std::mt19937&) { onto(x, 1); }},
      {"flat, noise", [](VecList& x, std::mt19937& b) { onto(x, 1), shake(x, b, 1e-3); }},
      {"line, noise", [](VecList& x, std::mt19937& b) { onto(x, 2), shake(x, b, 1e-3); }},
      {"point, noise", [](VecList& x, std::mt19937& b) { onto(x, 3), shake(x, b, 1e-3); }},
      {"mirrored", [](VecList& x, std::mt19937&) { each(x, [](Vec3 p) { return Vec3(side - p.x(), p.y(), p.z()); }); }},
      {"random", [](VecList& x, std::mt19937& b) { scatter(x, b, side / 2); }},
      {"random, 3x", [](VecList& x, std::mt19937& b) { scatter(x, b, 1.5 * side); }},
      {"stretched 10x",
       [](VecList& x, std::mt19937&) { each(x, [](Vec3 p) { return Vec3(p.x(), p.y(), 10 * p.z()); }); }},
      {"squashed", [](VecList& x, std::mt19937&) { each(x, [](Vec3 p) { return Vec3(p.x(), p.y(), p.z() / 10); }); }},
      {"twisted", [](VecList& x, std::mt19937&) { each(x, twisted); }},
      {"inside out",
       [](VecList& x, std::mt19937&) {
         each(x, [](Vec3 p) { return Vec3(p.x(), p.y(), std::min(p.z(), side - p.z())); });
       }},
      {"pulled 10 sides", [](VecList& x, std::mt19937&) { x.back().x() += 10 * side; }},
      {"swapped",
       [](VecList& x, std::mt19937& b) {
         for (int k = 0; k < 6; ++k) std::swap(x[b() % x.size()], x[b() % x.size()]);
       }},
      {"noise 0.8 h", [](VecList& x, std::mt19937& b) { shake(x, b, 0.8); }}};
  return all;
}

void print_row(const char* name, double poisson, const TopologyOptions& topology, double share) {
  Model model = make_block({side, side, side}, 4, 4, 4, 6);
  set_material(model, soft_tissue(poisson));
  const Scene scene(model);
  SolverOptions options;
  options.damping.factor = 0.99;
  const auto solver = make_solver("reference", model, scene, topology, options);
  int returned = 0;
  std::string lost;
  for (const Failure& failure : failures()) {
    std::mt19937 bits(5);
    State state = rest_state(model);
    failure.apply(state.position, bits);
    solver->reset(state);
    const StepReport report = solver->step(12000, share * solver->stable_step());
    // The energy of a uniform strain of about 0.5 %: nothing folded is left.
    const bool rests = report.ok() && solver->energy().elastic < 1e-5 * soft_tissue().young * side * side * side;
    returned += rests;
    if (!rests) lost += std::string(lost.empty() ? "" : ", ") + failure.name + (report.ok() ? "" : " (ran away)");
  }
  std::printf("%-28s nu %.2f  step %.1f of the limit: %2d of %zu; lost: %s\n", name, poisson, share, returned,
              failures().size(), lost.c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  TopologyOptions bounded, quadratic, averaged, exponent;
  quadratic.volume_law = VolumeLaw::quadratic;
  averaged.cell_average = 0.9;
  exponent.poisson_route = PoissonRoute::area_exponent;
  const std::vector<double> shares = argc > 1 ? std::vector{std::atof(argv[1])} : std::vector{0.2, 0.5};
  for (double share : shares) {
    for (double poisson : {0.3, 0.45}) {
      print_row("bounded volume law", poisson, bounded, share);
      print_row("quadratic volume law", poisson, quadratic, share);
      print_row("bounded, cell-averaged", poisson, averaged, share);
    }
    print_row("area exponent", 0.3, exponent, share);
  }
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
