// SPDX-License-Identifier: MIT
//
// The table of backends: one row each.
#include <phymul/error.h>
#include <phymul/solver.h>
#include <phymul/topology_textures.h>

#include <array>

#include "cpu/reference_solver.h"
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

/// What "auto" takes, and why.
struct Choice {
  const char* backend;
  std::string reason;
};

#ifdef PHYMUL_HAS_GL
/// Below, a step on a GPU costs more to start than it saves: the passes of one take some 5 to 8 us to launch.
constexpr Index gl_particles = 200;

std::unique_ptr<Solver> make_gl_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                       const SolverOptions& options) try {
  return load_gl_module().make(std::move(topology), scene, options);
} catch (const Error& error) {
  throw Error(std::string("backend \"gl\": ") + error.what());
}

std::string why_gl_unavailable(const SolverOptions& options) try {
  load_gl_module().probe(options.gl);
  return {};
} catch (const Error& error) {
  return error.what();
}

constexpr std::array backends{Backend{"reference", cpu::make_reference_solver, always_available},
                              Backend{"gl", make_gl_solver, why_gl_unavailable}};

Choice choose(Index particle_count, const SolverOptions& options) try {
  if (particle_count < gl_particles) {
    return {"reference",
            "reference: " + std::to_string(particle_count) + " particles are too few for a GPU to gain on"};
  }
  const GlDevice device = load_gl_module().probe(options.gl);
  if (device.software) return {"reference", "reference: GL has a software renderer only (" + device.name + ")"};
  return {"gl", "gl: " + std::to_string(particle_count) + " particles, on " + device.name};
} catch (const Error& error) {
  return {"reference", std::string("reference: GL is not available: ") + error.what()};
}
#else
constexpr std::array backends{Backend{"reference", cpu::make_reference_solver, always_available}};

Choice choose(Index, const SolverOptions&) {
  return {"reference", "reference: this build has no GL backend (PHYMUL_WITH_GL)"};
}
#endif

const Backend& find_backend(std::string_view name) {
  for (const Backend& backend : backends) {
    if (name == backend.name) return backend;
  }
  std::string known = "auto";
  for (const Backend& backend : backends) known += std::string(", ") + backend.name;
  throw Error("unknown backend \"" + std::string(name) + "\"; this build has: " + known);
}

}  // namespace

std::unique_ptr<Solver> make_solver(std::string_view backend, std::shared_ptr<const TopologyTextures> topology,
                                    const Scene& scene, const SolverOptions& options) {
  if (!topology) throw Error("make_solver: the topology is null; build_topology makes one");
  if (backend != "auto") return find_backend(backend).make(std::move(topology), scene, options);
  Choice choice = choose(topology->particle_count, options);
  std::unique_ptr<Solver> solver;
  try {
    solver = find_backend(choice.backend).make(topology, scene, options);
  } catch (const Error& error) {
    if (choice.backend == backends.front().name) throw;
    // Where the fault is the caller's, the reference backend finds it again.
    choice = {backends.front().name, std::string(backends.front().name) + ": " + error.what()};
    solver = backends.front().make(std::move(topology), scene, options);
  }
  solver->choice_ = std::move(choice.reason);
  return solver;
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
