// SPDX-License-Identifier: MIT
//
// Rest shapes of solid bodies: thick sphere, square bar in torsion, Truth Cube.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "measures.h"
#include "truth_table.h"

namespace phymul::bench {
namespace {

// ---- thick sphere under inner pressure -----------------------------------------------------------------------------

/// The octant x, y, z > 0 of a hollow sphere: three patches of a cube projected on spheres, n x n cells each and
/// `layers` between the radii. Groups: inner, outer, x0, y0, z0.
Model hollow_octant(double inner, double outer, int n, int layers) {
  Model model;
  std::map<std::array<long, 3>, Index> known;
  std::array<std::vector<Index>, 2> sides;
  const auto at = [&](int patch, int i, int j, int k) {
    const double quarter = std::atan(1.0);
    const Vec3 on_cube(1, std::tan(quarter * i / n), std::tan(quarter * j / n));
    const Vec3 x = (inner + (outer - inner) * k / layers) * on_cube.normalized();
    const Vec3 turned(x[(3 - patch) % 3], x[(4 - patch) % 3], x[(5 - patch) % 3]);
    const Vec3 key = 1e7 / outer * turned;
    const auto [place, is_new] = known.try_emplace({std::lround(key[0]), std::lround(key[1]), std::lround(key[2])},
                                                   static_cast<Index>(model.rest.size()));
    if (is_new) {
      model.rest.push_back(turned);
      if (k == 0) sides[0].push_back(place->second);
      if (k == layers) sides[1].push_back(place->second);
    }
    return place->second;
  };
  for (int patch = 0; patch < 3; ++patch) {
    for (int k = 0; k < layers; ++k) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          Cell cell{.type = CellType::hexahedron};
          for (const int up : {0, 1}) {
            for (const auto& [di, dj] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
              cell.particles.push_back(at(patch, i + di, j + dj, k + up));
            }
          }
          model.cells.push_back(std::move(cell));
        }
      }
    }
  }
  model.mass.assign(model.rest.size(), 1.0);
  model.stiffness.assign(model.rest.size(), 1.0);
  model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  model.add_group("inner", sides[0]).add_group("outer", sides[1]);
  for (int axis = 0; axis < 3; ++axis) {
    model.add_group(std::string(1, "xyz"[axis]) + "0",
                    model.particles_in([&](const Vec3& x) { return x[axis] < 1e-9 * outer; }));
  }
  return model;
}

void sphere(TruthTable& table, bool quick) {
  const double a = 0.02, b = 0.04, young = 10e3, pressure = 1.0;
  for (const double nu : {0.3, 0.45}) {
    for (const int n : {4, 7, 10, 14}) {
      if (quick && n > 4) break;
      const int layers = 4 * n / 3;
      Simulation sim = simulation(hollow_octant(a, b, n, layers), {.young = young, .poisson = nu, .density = 1000});
      for (const std::string axis : {"x", "y", "z"}) {
        impose(sim.scene(), sim.model().group(axis + "0"), Vec3::Zero(), "", axis);
      }
      Load load;
      load.type = LoadType::pressure;
      load.events = {{0.0, pressure}};
      load.particles = sim.model().group("inner");
      sim.scene().add(load);
      const VecList u = rest(sim, "sphere");
      for (const auto& [side, r] : {std::pair<std::string, double>{"inner", a}, {"outer", b}}) {
        // Lame: u = p a^3 / (E (b^3 - a^3)) ((1 - 2 nu) r + (1 + nu) b^3 / (2 r^2)).
        const double exact = 1e6 * pressure * a * a * a / (young * (b * b * b - a * a * a)) *
                             ((1 - 2 * nu) * r + (1 + nu) * b * b * b / (2 * r * r));
        const std::vector<Index> group = sim.model().group(side);
        double mean = 0.0, least = INFINITY, most = 0.0;
        for (const Index i : group) {
          const double out = 1e6 * u[i].dot(sim.model().rest[i].normalized());
          mean += out / static_cast<double>(group.size()), least = std::min(least, out), most = std::max(most, out);
        }
        const std::string name = side + " radius nu " + text("%.2f", nu), mesh = text("%.0f x %.0f", n, layers);
        table.row("sphere", name, mesh, sim.model().particle_count(), mean, {exact, exact});
        table.row("sphere", name + ", worst particle", mesh, sim.model().particle_count(),
                  exact - least > most - exact ? least : most, {exact, exact});
      }
    }
  }
}

// ---- torsion of a square bar ---------------------------------------------------------------------------------------

void torsion(TruthTable& table, bool quick) {
  const double a = 0.05, young = 10e3, nu = 0.3, angle = 1e-3;
  for (const std::string kind : {"lattice", "tetrahedra", "filled"})
    for (const bool bonded : {false, true}) {
      for (const double length : {0.1, 0.2, 0.4}) {
        for (const int n : {4, 6, 8, 12}) {
          if (quick ? n > 4 : n > 8 && length > 0.3) break;
          if (kind != "lattice" && length != 0.2) break;
          const int along = static_cast<int>(std::lround(n * length / a));
          Model body = kind == "lattice" ? make_block({length, a, a}, along, n, n)
                       : kind == "tetrahedra"
                           ? make_tetrahedral_block({length, a, a}, along, n, n, 0.2, 1)
                           : make_body(solid_box(Vec3::Zero(), {length, a, a}), {.spacing = 1.2 * a / n});
          if (kind == "filled") {
            body.add_group("x0", body.particles_in([&](const Vec3& x) { return x.x() < 0.1 * a / n; }));
            body.add_group("x1", body.particles_in([&](const Vec3& x) { return x.x() > length - 0.1 * a / n; }));
          }
          Simulation sim = simulation(std::move(body), {.young = young, .poisson = nu, .density = 1000});
          // The sections at the ends turn as rigid ones do. They warp along the bar unless they are bonded.
          impose(sim.scene(), sim.model().group("x0"), Vec3::Zero(), "", bonded ? "xyz" : "yz");
          for (const Index i : sim.model().group("x1")) {
            const Vec3 arm = sim.model().rest[i] - Vec3(length, a / 2, a / 2);
            impose(sim.scene(), {i}, angle * Vec3(0, -arm.z(), arm.y()), "yz", bonded ? "x" : "");
          }
          if (!bonded) {
            // The one nearest to the axis keeps the bar where it is.
            const Vec3 axis(0, a / 2, a / 2);
            const std::vector<Index> end = sim.model().group("x0");
            impose(sim.scene(),
                   {*std::ranges::min_element(end, {}, [&](Index i) { return (sim.model().rest[i] - axis).norm(); })},
                   Vec3::Zero(), "", "xyz");
          }
          rest(sim, "torsion");
          const double torque =
              support(sim.model().group("x1"), sim.solver().topology(), sim.scene(), sim.state().position).torque.x();
          // Saint-Venant: 0.140577 G a^4 a radian over the length (Timoshenko and Goodier, section 109).
          const double exact = 0.140577 * young / (2 * (1 + nu)) * std::pow(a, 4) * angle / length;
          table.row("torsion",
                    std::string(bonded ? "bonded ends" : "ends free to warp") + text(" L / a %.0f", length / a),
                    text("%.0f across", n) + ", " + kind, sim.model().particle_count(), 1e6 * torque,
                    {1e6 * exact, 1e6 * exact});
        }
      }
    }
}

// ---- Truth Cube ----------------------------------------------------------------------------------------------------

void truth_cube(TruthTable& table, bool quick) {
  const double side = 0.08, radius = 0.0127, young = 10e3;
  const Known known = table.measured("truth cube", "stiffness N/m");
  for (const int n : {8, 12, 16}) {
    if (quick && n > 8) break;
    // A quarter of the cube; finer below the ball.
    Model model = make_block({1, 1, 1}, n, n, n);
    const auto graded = [](double t) { return std::sinh(1.5 * t) / std::sinh(1.5); };
    for (Vec3& x : model.rest) x = {side / 2 * graded(x.x()), side / 2 * graded(x.y()), side * (1 - graded(1 - x.z()))};
    Simulation sim = simulation(std::move(model), {.young = young, .poisson = 0.49, .density = 1000});
    sim.scene().fix("z0");
    impose(sim.scene(), sim.model().group("x0"), Vec3::Zero(), "", "x");
    impose(sim.scene(), sim.model().group("y0"), Vec3::Zero(), "", "y");
    const ToolHandle ball = sim.scene().add_tool(
        Tool{.shape = Sphere{radius}, .pose = {.position = {0, 0, side + radius}}, .contact = ToolContact::surface});
    double last = 0.0;
    for (int mm = 1; mm <= 18; ++mm) {
      ball.move_to({.position = {0, 0, side + radius - 1e-3 * mm}});
      rest(sim, "truth cube", 1e-5);
      const double force = 4 * sim.force_on(ball).force.z(), slope = (force - last) / 1e-3;
      last = force;
      const std::string mesh = text("%.0f a side", n);
      table.curve("truth cube", mesh, mm, force);
      if (mm == 2 || mm == 5 || mm == 10 || mm == 18) {
        // What E must be for the measured stiffness, if that was the slope there.
        table.row("truth cube", text("E, kPa, from the slope at %.1f mm", mm - 0.5), mesh, sim.model().particle_count(),
                  1e-3 * young * known.mean() / slope, not_known);
      }
    }
  }
}

}  // namespace

const std::map<std::string, TruthCase>& solid_cases() {
  static const std::map<std::string, TruthCase> cases{
      {"sphere", sphere}, {"torsion", torsion}, {"truth cube", truth_cube}};
  return cases;
}

}  // namespace phymul::bench
