// SPDX-License-Identifier: MIT
//
// Motion: the beam of silicone released, natural frequencies of a cantilever, a wave in a bar.
#include <cmath>
#include <complex>
#include <numbers>

#include "truth_table.h"

namespace phymul::bench {
namespace {

using std::numbers::pi;

/// Mean time between the last crossings of `level` on the way down, s, and the amplitudes from it, by parabolas.
struct Swing {
  double period = 0.0;
  std::vector<double> amplitudes;
};

Swing swing_of(const std::vector<double>& y, double dt, double level) {
  Swing swing;
  std::vector<double> crossings;
  for (std::size_t k = 1; k + 1 < y.size(); ++k) {
    const double a = y[k - 1] - level, b = y[k] - level;
    if (a > 0 && b <= 0) crossings.push_back((static_cast<double>(k) - b / (b - a)) * dt);
    if (y[k] >= y[k - 1] && y[k] > y[k + 1] && y[k] > level) swing.amplitudes.push_back(y[k] - level);
  }
  swing.period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  return swing;
}

// ---- A: the beam of silicone, released -----------------------------------------------------------------------------

void beam_period(TruthTable& table, bool quick) {
  struct Law {
    std::string name;
    double strength, time;
  };
  // Fitted: a decay of 0.3 a swing is a loss of 0.3 / pi of the stiffness; with w tau = 0.96 the strength also raises
  // the stiffness by 10 %, the square of our period over the measured one.
  const std::vector<Law> laws{{"undamped", 0, 0}, {"relaxation", 0.208, 0.0197}};
  for (const int across : {3, 6, 9}) {
    if (quick && across > 3) break;
    for (const Law& law : laws) {
      for (const double share : {0.9, 0.45}) {
        if (across != 6 && (share < 0.9 || law.strength > 0.0)) continue;
        const Material material{.young = 263824,
                                .poisson = 0.49,
                                .density = 1070,
                                .relaxation_strength = law.strength,
                                .relaxation_time = law.time};
        Simulation still = silicone_beam(across, material);
        rest(still, "beam period");
        const double level = at_point(still, {0.1, 0.015, 0.03}).z();
        Simulation sim = silicone_beam(across, material, "cpu");
        const double dt = share * sim.solver().stable_step();
        const Skin mark(sim.model(), std::vector<Vec3>{{0.1, 0.015, 0.03}});
        std::vector<double> y;
        State state;
        const int every = std::max(1, static_cast<int>(1e-3 / dt));
        for (double t = 0; t < 0.9; t += every * dt) {
          if (!sim.unrecorded_solver().step(every, dt).ok()) throw Error("beam period: a step failed");
          sim.solver().read(state);
          y.push_back(mark.deform(state.position)[0].z() - 0.03);
          if (across == 6 && share == 0.9) table.curve("beam period", law.name, t + every * dt, 1e3 * y.back());
        }
        const Swing swing = swing_of(y, every * dt, level);
        const std::string mesh = text("%.0f across, step %.2f", across, share);
        table.row("beam period", "period s " + law.name, mesh, sim.model().particle_count(), swing.period,
                  table.measured("beam period", "period s"));
        const auto& a = swing.amplitudes;
        const Known decay = table.measured("beam period", "decay per swing");
        if (law.strength > 0.0 && a.size() > 5) {
          table.row("beam period", "decay per swing, " + law.name, mesh, sim.model().particle_count(),
                    std::log(a[0] / a[5]) / 5, decay);
        }
      }
    }
  }
}

// ---- F: natural frequencies of a cantilever ------------------------------------------------------------------------

/// Where the windowed transform of a signal is largest near a guess, Hz. The window is Hann's.
double frequency_of(const std::vector<double>& signal, double dt, double guess) {
  const auto size = [&](double f) {
    std::complex<double> sum = 0;
    const double n = static_cast<double>(signal.size());
    for (std::size_t k = 0; k < signal.size(); ++k) {
      const double at = (static_cast<double>(k) + 0.5) / n;
      sum += signal[k] * (1 - std::cos(2 * pi * at)) * std::polar(1.0, -2 * pi * f * dt * static_cast<double>(k));
    }
    return std::abs(sum);
  };
  double best = guess;
  for (double width = 0.1 * guess; width > 1e-7 * guess; width *= 0.2) {
    const double middle = best;
    for (int k = -8; k <= 8; ++k) {
      if (const double f = middle + k * width / 8; size(f) > size(best)) best = f;
    }
  }
  return best;
}

void cantilever(TruthTable& table, bool quick) {
  const double length = 0.2, height = 0.05;
  struct Mode {
    std::string name;
    Vec3 (*shape)(const Vec3& from_axis, double along);  // 1 at the free end
  };
  const auto sway = [](const Vec3&, double s) { return Vec3(0, 0, s * s * (6 - 4 * s + s * s) / 3); };
  const auto twist = [](const Vec3& x, double s) {
    return Vec3(Vec3(0, -x.z(), x.y()) * std::sin(pi * s / 2) / 0.025);
  };
  const auto wave = [](const Vec3&, double s) {  // the second mode of Euler's beam
    const double k = 4.694091 * s, c = 1.018466;
    return Vec3(0, 0, (std::cosh(k) - std::cos(k) - c * (std::sinh(k) - std::sin(k))) / 2);
  };
  const std::vector<Mode> modes{{"first bending Hz", sway}, {"first torsion Hz", twist}, {"second bending Hz", wave}};
  for (const bool lattice : {true, false}) {
    for (const int across : {3, 6, 8}) {
      if (quick && across > 3) break;
      for (const double share : {0.9, 0.45}) {
        if (share < 0.9 && across != 6) continue;
        for (const Mode& mode : modes) {
          Model body = lattice ? make_block({length, height, height}, 4 * across, across, across)
                               : make_tetrahedral_block({length, height, height}, 4 * across, across, across, 0.2, 1);
          Simulation sim = simulation(std::move(body), {.young = 10e3, .poisson = 0.3, .density = 1000}, "cpu");
          sim.scene().fix("x0");
          const Known known = table.measured("cantilever", mode.name);
          const Model& model = sim.model();
          VecList shape(model.rest.size());
          State state = rest_state(model);
          for (std::size_t i = 0; i < shape.size(); ++i) {
            const Vec3 x = model.rest[i] - Vec3(0, height / 2, height / 2);
            shape[i] = mode.shape(Vec3(0, x.y(), x.z()), x.x() / length);
            state.position[i] += 1e-3 * height * shape[i];
          }
          const double dt = share * sim.solver().stable_step();
          sim.unrecorded_solver().start(state, dt);
          std::vector<double> signal;
          const int every = std::max(1, static_cast<int>(0.05 / known.mean() / dt));
          for (double t = 0; t < 25 / known.mean(); t += every * dt) {
            if (!sim.unrecorded_solver().step(every, dt).ok()) throw Error("cantilever: a step failed");
            sim.solver().read(state);
            double sum = 0.0;
            for (std::size_t i = 0; i < shape.size(); ++i) {
              sum += model.mass[i] * shape[i].dot(state.position[i] - model.rest[i]);
            }
            signal.push_back(sum);
          }
          table.row("cantilever", mode.name,
                    text("%.0f across, step %.2f", across, share) + (lattice ? "" : ", tetrahedra"),
                    model.particle_count(), frequency_of(signal, every * dt, known.mean()), known);
        }
      }
    }
  }
}

// ---- F: a wave in a bar --------------------------------------------------------------------------------------------

void wave(TruthTable& table, bool quick) {
  const double length = 2.4, height = 0.05, young = 10e3, density = 1000, speed = std::sqrt(young / density);
  for (const double nu : {0.0, 0.3, 0.45}) {
    for (const int across : {2, 3, 4}) {
      if (quick && across > 2) break;
      for (const double share : {0.9, 0.45}) {
        if (share < 0.9 && across != 3) continue;
        Simulation sim = simulation(make_block({length, height, height}, 48 * across, across, across),
                                    {.young = young, .poisson = nu, .density = density}, "cpu");
        const Model& model = sim.model();
        // A pulse of a hundredth of a millimetre, long beside the height of the bar, on its way along it.
        const double wide = 3 * height, middle = 0.6;
        State state = rest_state(model);
        for (std::size_t i = 0; i < state.position.size(); ++i) {
          const double s = (model.rest[i].x() - middle) / wide, u = 1e-5 * std::exp(-s * s / 2);
          const Vec3 across_axis = model.rest[i] - Vec3(model.rest[i].x(), height / 2, height / 2);
          const double strain = -u * s / wide, change = u * (s * s - 1) / (wide * wide);  // du / dx, d2u / dx2
          state.position[i] += Vec3(u, 0, 0) - nu * strain * across_axis;
          state.velocity[i] = -speed * (Vec3(strain, 0, 0) - nu * change * across_axis);
        }
        const double dt = share * sim.solver().stable_step();
        sim.unrecorded_solver().start(state, dt);
        // When the energy of its motion passes two sections, on average.
        const double stations[] = {1.1, 1.7};
        double weight[2] = {}, moment[2] = {};
        std::vector<Index> sections[2];
        for (const int k : {0, 1}) {
          sections[k] = model.particles_in([&](const Vec3& x) { return std::abs(x.x() - stations[k]) < 1e-6; });
        }
        for (double t = dt; t < 0.55; t += dt) {
          if (!sim.unrecorded_solver().step(1, dt).ok()) throw Error("wave: a step failed");
          sim.solver().read(state);
          for (const int k : {0, 1}) {
            double v = 0.0;
            for (const Index i : sections[k]) v += state.velocity[i].x();
            weight[k] += v * v, moment[k] += v * v * t;
          }
        }
        // Love's rod, which has the inertia of its narrowing: the group speed at the mean square of the pulse's wave
        // number.
        const double rod = speed * (1 - 1.5 * nu * nu * height * height / 6 * 1.5 / (wide * wide));
        const double found = (stations[1] - stations[0]) / (moment[1] / weight[1] - moment[0] / weight[0]);
        table.row("wave", text("speed m/s nu %.2f", nu), text("%.0f across, step %.2f", across, share),
                  model.particle_count(), found, {rod, speed});
      }
    }
  }
}

}  // namespace

const std::map<std::string, TruthCase>& motion_cases() {
  static const std::map<std::string, TruthCase> cases{
      {"beam period", beam_period}, {"cantilever", cantilever}, {"wave", wave}};
  return cases;
}

}  // namespace phymul::bench
