// SPDX-License-Identifier: MIT
//
// The table of backends, and what "auto" takes of them.
#include <phymul/error.h>
#include <phymul/solver.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <limits>

#include "cpu/reference_solver.h"
#include "cpu/vector_solver.h"
#ifdef PHYMUL_HAS_GL
#include "gl_module.h"
#endif

namespace phymul {
namespace {

struct Backend {
  const char* name;
  std::unique_ptr<Solver> (*make)(std::shared_ptr<const TopologyTextures>, const Scene&, const SolverOptions&);
  std::string (*why_unavailable)(const SolverOptions&);  ///< empty where it can run
};

std::string always_available(const SolverOptions&) {
  return {};
}

#ifdef PHYMUL_HAS_GL
template <GlBackend backend>
std::unique_ptr<Solver> make_gl_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                       const SolverOptions& options) try {
  return load_gl_module().make(backend, std::move(topology), scene, options);
} catch (const Error& error) {
  throw Error("backend \"" + std::string(name_of(backend)) + "\": " + error.what());
}

template <GlBackend backend>
std::string why_gl_unavailable(const SolverOptions& options) try {
  load_gl_module().probe(backend, options.gl);
  return {};
} catch (const Error& error) {
  return error.what();
}
#endif

constexpr std::array backends{
    Backend{"reference", cpu::make_reference_solver, always_available},
    Backend{"cpu", cpu::make_vector_solver, always_available},
#ifdef PHYMUL_HAS_GL
    Backend{"gl", make_gl_solver<GlBackend::fragment>, why_gl_unavailable<GlBackend::fragment>},
    Backend{"gl-compute", make_gl_solver<GlBackend::compute>, why_gl_unavailable<GlBackend::compute>},
#endif
};

const Backend& find_backend(std::string_view name) {
  for (const Backend& backend : backends) {
    if (name == backend.name) return backend;
  }
  std::string known = "auto";
  for (const Backend& backend : backends) known += std::string(", ") + backend.name;
  throw Error("unknown backend \"" + std::string(name) + "\"; this build has: " + known);
}

struct Choice {
  std::unique_ptr<Solver> solver;
  std::string reason;
};

#ifdef PHYMUL_HAS_GL
/// Below, a step on a GPU costs more to start than it saves: two passes take some 5 to 8 us to launch, in which a
/// processor moves that many particles.
constexpr Index gl_particles = 1000;
constexpr int timed_steps = 8;

/// Seconds a step takes, from the rest shape and back to it; infinite where one fails. The first call, which may set
/// things up, is not counted.
double seconds_a_step(Solver& solver) {
  const double dt = std::min(0.1 * solver.stable_step(), 1.0);
  double best = 0.0;
  for (int round = 0; round < 4; ++round) {
    const auto start = std::chrono::steady_clock::now();
    if (!solver.step(timed_steps, dt).ok()) return std::numeric_limits<double>::infinity();
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / timed_steps;
    if (round == 1 || (round > 1 && seconds < best)) best = seconds;
  }
  solver.reset();
  return best;
}

/// The faster of the processor and the GPU on this very body.
Choice faster_of(std::unique_ptr<Solver>& cpu, std::unique_ptr<Solver>& gl) {
  const double on_cpu = seconds_a_step(*cpu), on_gl = seconds_a_step(*gl);
  char measured[96];
  std::snprintf(measured, sizeof measured, ": a step took %.3g us, on the %s %.3g us; ", 1e6 * std::min(on_cpu, on_gl),
                on_gl < on_cpu ? "processor" : "GPU", 1e6 * std::max(on_cpu, on_gl));
  const std::string device = gl->device();
  if (on_gl < on_cpu) return {std::move(gl), "gl" + (measured + device)};
  return {std::move(cpu), "cpu" + (measured + device)};
}
#endif

Choice choose(const std::shared_ptr<const TopologyTextures>& topology, const Scene& scene,
              const SolverOptions& options) {
  std::unique_ptr<Solver> cpu;
  try {
    cpu = cpu::make_vector_solver(topology, scene, options);
  } catch (const Error& error) {
    // Where the fault is the caller's, the reference backend finds it again.
    return {cpu::make_reference_solver(topology, scene, options), std::string("reference: ") + error.what()};
  }
#ifdef PHYMUL_HAS_GL
  if (!scene.tools().empty()) return {std::move(cpu), "cpu: the scene has tools, which \"gl\" does not take yet"};
  if (topology->particle_count < gl_particles) {
    return {std::move(cpu),
            "cpu: " + std::to_string(topology->particle_count) + " particles are too few for a GPU to gain on"};
  }
  try {
    const GlDevice device = load_gl_module().probe(GlBackend::fragment, options.gl);
    if (device.software) return {std::move(cpu), "cpu: GL has a software renderer only (" + device.name + ")"};
    std::unique_ptr<Solver> gl = make_gl_solver<GlBackend::fragment>(topology, scene, options);
    return faster_of(cpu, gl);
  } catch (const Error& error) {
    return {std::move(cpu), std::string("cpu: GL is not available: ") + error.what()};
  }
#else
  return {std::move(cpu), "cpu: this build has no GL backend (PHYMUL_WITH_GL)"};
#endif
}

}  // namespace

std::unique_ptr<Solver> make_solver(std::string_view backend, std::shared_ptr<const TopologyTextures> topology,
                                    const Scene& scene, const SolverOptions& options) {
  if (!topology) throw Error("make_solver: the topology is null; build_topology makes one");
  if (backend != "auto") return find_backend(backend).make(std::move(topology), scene, options);
  Choice choice = choose(topology, scene, options);
  choice.solver->choice_ = std::move(choice.reason);
  return std::move(choice.solver);
}

std::unique_ptr<Solver> make_solver(std::string_view backend, const Model& model, const Scene& scene,
                                    const TopologyOptions& topology, const SolverOptions& options) {
  if (&scene.model() != &model) throw Error("make_solver: the scene was made for another model");
  validate(model);
  return make_solver(backend, std::make_shared<const TopologyTextures>(build_topology(model, topology)), scene,
                     options);
}

std::string why_unavailable(std::string_view backend, const SolverOptions& options) {
  if (backend == "auto") return {};
  return find_backend(backend).why_unavailable(options);
}

std::vector<std::string> backend_names() {
  std::vector<std::string> names;
  for (const Backend& backend : backends) names.emplace_back(backend.name);
  return names;
}

}  // namespace phymul
