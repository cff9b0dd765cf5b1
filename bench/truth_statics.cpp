// SPDX-License-Identifier: MIT
//
// Rest shapes: beam of silicone, brain tissue, Cook's membrane, roll-up.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "measures.h"
#include "truth_table.h"

namespace phymul::bench {
namespace {

using std::numbers::pi;

std::vector<int> meshes(bool quick, std::vector<int> all) {
  return quick ? std::vector<int>{all.front()} : std::move(all);
}

// ---- A: beam of silicone, 100 x 30 x 30 mm -------------------------------------------------------------------------

constexpr double beam_loads[] = {0.0, 0.51012, 1.00062};  // N
/// Places of the three marks on the free end, mm from its lower corner along y and z; the first on the upper edge.
constexpr double marks[][2] = {{15, 30}, {0, 24}, {30, 6}};

/// mm down at the marks, and at the first one's marker, which stands 6 mm above the surface.
std::array<double, 4> beam_at_rest(int across, double young, double poisson, double load) {
  Simulation sim = silicone_beam(across, {.young = young, .poisson = poisson, .density = 1070});
  if (load > 0.0) {
    // Spread evenly along the upper edge of the free end: an end particle has half of an inner one's share.
    std::vector<Index> inner, ends;
    for (const Index i : sim.model().group("x1")) {
      const Vec3& at = sim.model().rest[i];
      if (at.z() < 0.03 - 1e-9) continue;
      (at.y() < 1e-9 || at.y() > 0.03 - 1e-9 ? ends : inner).push_back(i);
    }
    sim.scene().add(push(LoadType::force, {0, 0, -load / across}, inner));
    sim.scene().add(push(LoadType::force, {0, 0, -load / across / 2}, ends));
  }
  rest(sim, "beam");
  std::array<double, 4> down{};
  for (int k = 0; k < 3; ++k) down[k] = 1e3 * at_point(sim, {0.1, 1e-3 * marks[k][0], 1e-3 * marks[k][1]}).z();
  // The marker turns with the facet below it, whose normal is that of the upper side at the end.
  const Vec3 back = at_point(sim, {0.095, 0.015, 0.03}), front = at_point(sim, {0.1, 0.015, 0.03});
  const Vec3 along = Vec3(0.005, 0, 0) + front - back;
  down[3] = down[0] + 6.0 * (along.x() / along.norm() - 1.0);
  return down;
}

void beam(TruthTable& table, bool quick) {
  const auto quantity = [](double load, int mark) { return text("%.5g N mark %.0f", load, mark + 1); };
  const double target = table.measured("beam", quantity(beam_loads[2], 0)).mean();
  for (const double poisson : {0.49, 0.499}) {
    for (const int across : meshes(quick, {3, 6, 9})) {
      if (poisson > 0.49 && across < 9 && !quick) continue;
      const std::string mesh = text("nu %.3f, %.0f across", poisson, across);
      const int n = (10 * across / 3 + 1) * (across + 1) * (across + 1);
      // Nothing fitted; E such that the heaviest load moves the first mark as far as measured; the same for its marker.
      for (const int fitted : {-1, 0, 3}) {
        double young = 263824.0;  // the authors'
        std::array<double, 4> heavy = beam_at_rest(across, young, poisson, beam_loads[2]);
        for (int k = 0; fitted >= 0 && k < 6 && std::abs(heavy[fitted] / target - 1) > 1e-4; ++k) {
          young *= heavy[fitted] / target;
          heavy = beam_at_rest(across, young, poisson, beam_loads[2]);
        }
        const std::string fit = fitted < 0 ? ", authors' E" : fitted == 3 ? ", marker 6 mm above" : "";
        if (fitted >= 0) table.row("beam", "E, kPa" + fit, mesh, n, 1e-3 * young, not_known);
        for (const double load : beam_loads) {
          const std::array<double, 4> down = load == beam_loads[2] ? heavy : beam_at_rest(across, young, poisson, load);
          if (fitted == 3) {
            table.row("beam", quantity(load, 0) + fit, mesh, n, down[3], table.measured("beam", quantity(load, 0)));
          }
          for (int mark = 0; fitted < 3 && mark < 3; ++mark) {
            table.row("beam", quantity(load, mark) + fit, mesh, n, down[mark],
                      table.measured("beam", quantity(load, mark)));
          }
        }
      }
    }
  }
}

// ---- B: brain tissue, cortex ---------------------------------------------------------------------------------------

/// Nominal stress, kPa, of a cube of mu = 1 kPa in an isochoric strain: the slope of its energy.
double stress_of_cube(const Model& cube, const TopologyTextures& tables, bool shear, double amount) {
  const auto energy = [&](double a) {
    Mat3 F = Mat3::Identity();
    if (shear) {
      F(0, 1) = a;
    } else {
      F.diagonal() = Vec3(a, 1 / std::sqrt(a), 1 / std::sqrt(a));
    }
    VecList at = cube.rest;
    for (Vec3& x : at) x = F * x;
    return elastic_energy(tables, at);
  };
  return 1e-3 * (energy(amount + 1e-4) - energy(amount - 1e-4)) / 2e-4;  // of 1 m^3
}

/// Nominal stress, kPa, of a cube of 1 m at rest: drawn along x between sides that let it narrow, or sheared by all of
/// its surface. From the force of its supports.
double stress_of_body(const Material& material, bool shear, double amount) {
  Simulation sim = simulation(make_block({1, 1, 1}, 2, 2, 2), material);
  Scene& scene = sim.scene();
  const Model& model = sim.model();
  if (shear) {
    for (const Index i : model.particles_in([](const Vec3& x) { return (x - Vec3::Constant(0.5)).norm() > 0.1; })) {
      impose(scene, {i}, {amount * model.rest[i].y(), 0, 0}, "x", "yz");
    }
  } else {
    impose(scene, model.group("x1"), {amount - 1, 0, 0}, "x");
    for (const std::string axis : {"x", "y", "z"}) impose(scene, model.group(axis + '0'), Vec3::Zero(), "", axis);
  }
  rest(sim, "brain");
  const std::vector<Index> face = model.group(shear ? "y1" : "x1");
  return 1e-3 * support(face, sim.solver().topology(), scene, sim.state().position).force.x();
}

/// Fits StrainEnergy::stiffening with some of its terms to `points` and measures bodies of what was found.
void fitted_brain(TruthTable& table, const std::vector<TestPoint>& points, const std::vector<std::string>& quantities,
                  const FitOptions& options, const std::string& name) {
  const MaterialFit fit = fit_material(points, {.poisson = 0.499, .density = 1040}, options);
  const Material& m = fit.material;
  const Stiffening& of = m.stiffening;
  table.row("brain", "E, kPa", name, 27, 1e-3 * m.young, not_known);
  for (const auto& [constant, value] : {std::pair{"exponential", of.exponential}, std::pair{"exponent", of.exponent},
                                        std::pair{"second", of.second}, std::pair{"second_fades", of.second_fades}}) {
    table.row("brain", constant, name, 27, value, not_known);
  }
  double largest = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto& [test, strain, stress] = points[k];
    const double ours = stress_of_body(m, test == StrainTest::shear, strain);
    table.row("brain", quantities[k], name, 27, ours);
    largest = std::max(largest, std::abs(1e3 * ours / stress - 1));
  }
  table.row("brain", "largest error, %", name, 27, 100 * largest, not_known);
}

void brain(TruthTable& table, bool) {
  Model cube = make_block({1, 1, 1}, 2, 2, 2);
  set_material(cube, {.young = 2e3 * 1.49, .poisson = 0.49, .density = 1000});
  const TopologyTextures tables = build_topology(cube);
  struct Point {
    std::string branch, quantity;
    double measured, unit;
  };
  std::vector<Point> points;
  const std::vector<std::pair<std::string, std::vector<double>>> branches{{"tension", {1.025, 1.05, 1.075, 1.1}},
                                                                          {"compression", {0.975, 0.95, 0.925, 0.9}},
                                                                          {"shear", {0.05, 0.1, 0.15, 0.2}}};
  for (const auto& [branch, amounts] : branches) {
    for (const double a : amounts) {
      const std::string quantity = branch + text(" %.4g", a);
      points.push_back({branch, quantity, table.measured("brain", quantity).mean(),
                        stress_of_cube(cube, tables, branch == "shear", a)});
      const double closed = branch == "shear" ? a : a - 1 / (a * a);
      table.row("brain", quantity + ", mu 1 kPa", "one cube", 27, points.back().unit, {closed, closed});
    }
  }
  // Least squares, of all branches together and of each alone.
  for (const std::string of : {"", "tension", "compression", "shear"}) {
    double above = 0.0, below = 0.0;
    for (const Point& p : points) {
      if (of.empty() || p.branch == of) above += p.measured * p.unit, below += p.unit * p.unit;
    }
    const double mu = above / below;
    const std::string fit = of.empty() ? "fit of all" : "fit of " + of;
    table.row("brain", "mu, kPa, " + fit, "one cube", 27, mu, not_known);
    for (const Point& p : points) {
      if (of.empty() || p.branch == of) table.row("brain", p.quantity, fit, 27, mu * p.unit);
    }
  }
  std::vector<TestPoint> tests;
  std::vector<std::string> quantities;
  for (const auto& [branch, amounts] : branches) {
    for (const double a : amounts) {
      quantities.push_back(branch + text(" %.4g", a));
      tests.push_back({branch == "shear" ? StrainTest::shear : StrainTest::uniaxial, a,
                       1e3 * table.measured("brain", quantities.back()).mean()});
    }
  }
  constexpr FitGoal least = FitGoal::largest_error;
  fitted_brain(table, tests, quantities, {least, false, false, false}, "neo-Hookean");
  fitted_brain(table, tests, quantities, {least, true, false, false}, "exponential");
  fitted_brain(table, tests, quantities, {least, true, true, false}, "exponential, second");
  fitted_brain(table, tests, quantities, {least, true, true, true}, "all constants");
  fitted_brain(table, tests, quantities, {}, "all constants, least squares");
}

// ---- C, D: Cook's membrane -----------------------------------------------------------------------------------------

/// n x n cells in `layers` of the thickness `thick`, m, in all, the left side held; the load's direction is +y.
Simulation cook(int n, int layers, bool lattice, double thick, const Material& material, double force) {
  Model model =
      lattice ? make_block({1, 1, thick}, n, n, layers) : make_tetrahedral_block({1, 1, thick}, n, n, layers, 0.2, 1);
  for (Vec3& x : model.rest) x = 1e-3 * Vec3(48 * x.x(), 44 * x.x() + x.y() * (44 - 28 * x.x()), 1e3 * x.z());
  Simulation sim = simulation(std::move(model), material);
  impose(sim.scene(), sim.model().group("x0"), Vec3::Zero(), "", "xy");
  sim.scene().add(push(LoadType::pressure, {0, force / (0.016 * thick), 0}, sim.model().group("x1")));
  return sim;
}

/// J: by how much the energy kappa / 4 (J^2 - 1 - 2 ln J) of the publication is above kappa / 2 (J - 1)^2.
double other_volume_law(const Simulation& sim, double kappa) {
  double sum = 0.0;
  for (const Cell& cell : sim.model().cells) {
    Model now;
    now.rest = sim.state().position;
    const double v0 = cell_volume(sim.model(), cell), J = cell_volume(now, cell) / v0;
    sum += v0 * kappa * ((J * J - 1 - 2 * std::log(J)) / 4 - (J - 1) * (J - 1) / 2);
  }
  return sum;
}

void cook_finite(TruthTable& table, bool quick) {
  const double mu = 422.5e3, nu = 0.3, kappa = 2 * mu * (1 + nu) / (3 * (1 - 2 * nu));
  const Material material{.young = 2 * mu * (1 + nu), .poisson = nu, .density = 1000};
  const Known limit = table.measured("cook finite", "limit");
  for (const bool lattice : {true, false}) {
    for (const int n : meshes(quick, {4, 8, 16, 32})) {
      const int layers = std::max(1, n / 8);
      const double thick = 0.048 / n * layers;
      double up[3] = {}, law[3] = {};
      for (int k = 0; k < 3; ++k) {
        const double force = (1.0 + 0.02 * (k - 1)) * thick / 1e-3;  // N, of 1 N per mm
        Simulation sim = cook(n, layers, lattice, thick, material, force);
        impose(sim.scene(), sim.model().particles_in([](const Vec3&) { return true; }), Vec3::Zero(), "", "z");
        rest(sim, "cook finite");
        up[k] = 1e3 * at_point(sim, {0.048, 0.052, thick / 2}).y();
        law[k] = 1e-3 / thick * other_volume_law(sim, kappa);  // of 1 mm
      }
      const int particles = (layers + 1) * (n + 1) * (n + 1);
      const std::string mesh = text("%.0f a side", n) + (lattice ? "" : ", tetrahedra");
      table.row("cook finite", "limit", mesh, particles, up[1], limit);
      if (lattice) table.row("cook finite", text("elements %.0f a side", n), mesh, particles, up[1]);
      // First order: the change of the load's path is minus the slope of the additional energy over the load.
      const double change = -1e3 * (law[2] - law[0]) / 0.04;
      if (lattice) table.row("cook finite", "with the other volume law", mesh, particles, up[1] + change, limit);
    }
  }
}

void cook_small(TruthTable& table, bool quick) {
  const double young = 1e4;
  for (const bool lattice : {true, false}) {
    for (const int n : meshes(quick, {4, 8, 16, 32})) {
      const int layers = std::max(1, n / 8);
      const double thick = layers * 0.048 / n, force = 1e-4 * young * thick;
      Simulation sim = cook(n, layers, lattice, thick, {.young = young, .poisson = 1.0 / 3, .density = 1000}, force);
      impose(sim.scene(), sim.model().group("z0"), Vec3::Zero(), "", "z");
      rest(sim, "cook small");
      const double up = at_point(sim, {0.048, 0.06, thick / 2}).y() * young * thick / force;
      table.row("cook small", "u E t / F", text("%.0f a side", n) + (lattice ? "" : ", tetrahedra"),
                (layers + 1) * (n + 1) * (n + 1), up);
    }
  }
}

// ---- E: roll-up ----------------------------------------------------------------------------------------------------

/// The force and the moment that the end of a strip needs, turned by `angle` with its middle at `middle` in the plane
/// of bending: (Fx, Fz, My).
Vec3 hold_end(Simulation& sim, std::size_t first_load, double angle, const Vec3& middle) {
  const std::vector<Index> end = sim.model().group("x1");
  Vec3 rest_middle = Vec3::Zero();
  for (const Index i : end) rest_middle += sim.model().rest[i] / static_cast<double>(end.size());
  const Mat3 turn = Eigen::AngleAxisd(-angle, Vec3::UnitY()).toRotationMatrix();
  for (std::size_t k = 0; k < end.size(); ++k) {
    const Vec3& X = sim.model().rest[end[k]];
    Load load = push(LoadType::translation, middle + turn * (X - rest_middle) - X, {end[k]});
    if (sim.scene().loads().size() <= first_load + k) {
      sim.scene().add(load);
    } else {
      sim.scene().replace(first_load + k, load);
    }
  }
  rest(sim, "roll-up", 1e-8);
  const Support found = support(end, sim.solver().topology(), sim.scene(), sim.state().position);
  const Vec3 moment = found.torque - (middle - rest_middle).cross(found.force);  // about the middle as it is now
  return {found.force.x(), found.force.z(), -moment.y()};
}

void roll_up(TruthTable& table, bool quick) {
  const double length = 0.4, height = 0.01, young = 1e5;
  for (const int across : meshes(quick, {2, 4, 6})) {
    Simulation sim = simulation(make_block({length, height, height}, 40 * across, across, across),
                                {.young = young, .poisson = 0, .density = 1000});
    sim.scene().fix("x0");
    // In the plane of bending: a bar as thick as high would find its way out of it, where twist is cheaper.
    const auto middle = [&](const Vec3& x) { return std::abs(x.y() - height / 2) < 1e-6 * height; };
    impose(sim.scene(), sim.model().particles_in(middle), Vec3::Zero(), "", "y");
    const std::size_t first = sim.scene().loads().size();
    const int parts = 32;
    Vec3 off = Vec3::Zero();  // of the middle of the end from where theory has it, m
    for (int k = 1; k <= (quick ? 4 : parts); ++k) {
      const double t = 2 * pi * k / parts, h = std::sin(t) / t - 1, v = (1 - std::cos(t)) / t;
      const Vec3 exact = Vec3(length * (1 + h), height / 2, height / 2 + length * v);
      Vec3 force = hold_end(sim, first, t, exact + off);
      if (k % 8 != 0) continue;
      // Newton's method for the place where the end needs no force, with differences of 1/250 of the length.
      for (int round = 0; round < 2; ++round) {
        Eigen::Matrix2d slope;
        for (const int axis : {0, 1}) {
          Vec3 aside = off;
          aside[2 * axis] += 4e-3 * length;
          slope.col(axis) = (hold_end(sim, first, t, exact + aside) - force).head<2>() / (4e-3 * length);
        }
        const Eigen::Vector2d change = slope.partialPivLu().solve(force.head<2>());
        off -= Vec3(change[0], 0, change[1]);
        force = hold_end(sim, first, t, exact + off);
      }
      const std::string mesh = text("%.0f across", across), at = text(" at %.2f pi", t / pi);
      const int n = sim.model().particle_count();
      const VecList now = sim.state().position;
      for (Index i = 0; across == 4 && i < sim.model().particle_count(); ++i) {  // the axis of the strip
        const Vec3 from_axis = sim.model().rest[i] - Vec3(sim.model().rest[i].x(), height / 2, height / 2);
        if (from_axis.norm() < 1e-6)
          table.curve("roll-up", at, now[i].x() / length, (now[i].z() - height / 2) / length);
      }
      const double moment = t * young * std::pow(height, 4) / 12 / length;
      table.row("roll-up", "moment L / (t E I)" + at, mesh, n, force[2] / moment, {1, 1});
      table.row("roll-up", "u / L" + at, mesh, n, h + off.x() / length, {h, h});
      table.row("roll-up", "v / L" + at, mesh, n, v + off.z() / length, {v, v});
      // Under the moment of theory the end turns by less, in the same ratio; from there, and from where the end is for
      // its angle, the distance from theory beside the length.
      const double less = t * moment / force[2];
      const Vec3 there(length * (std::sin(less) / less - 1 - h), 0, length * ((1 - std::cos(less)) / less - v));
      table.row("roll-up", "1 + distance / L" + at, mesh, n, 1 + (there + off).norm() / length, {1, 1});
    }
  }
}

}  // namespace

const std::map<std::string, TruthCase>& static_cases() {
  static const std::map<std::string, TruthCase> cases{
      {"beam", beam}, {"brain", brain}, {"cook finite", cook_finite}, {"cook small", cook_small}, {"roll-up", roll_up}};
  return cases;
}

}  // namespace phymul::bench
