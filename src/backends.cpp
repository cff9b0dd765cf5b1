// SPDX-License-Identifier: MIT
//
// The table of backends: one row each, in the order "auto" prefers them.
#include <phymul/error.h>
#include <phymul/solver.h>
#include <phymul/topology_textures.h>

#include <array>

#include "cpu/reference_solver.h"
#include "cpu/vector_solver.h"

namespace phymul {
namespace {

struct Backend {
  const char* name;
  std::unique_ptr<Solver> (*make)(std::shared_ptr<const TopologyTextures>, const Scene&, const SolverOptions&);
};

constexpr std::array backends{Backend{"reference", cpu::make_reference_solver},
                              Backend{"cpu", cpu::make_vector_solver}};

const Backend& find_backend(std::string_view name) {
  if (name == "auto") return backends.front();
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
  return find_backend(backend).make(std::move(topology), scene, options);
}

std::unique_ptr<Solver> make_solver(std::string_view backend, const Model& model, const Scene& scene,
                                    const TopologyOptions& topology, const SolverOptions& options) {
  if (&scene.model() != &model) throw Error("make_solver: the scene was made for another model");
  validate(model);
  return make_solver(backend, std::make_shared<const TopologyTextures>(build_topology(model, topology)), scene,
                     options);
}

std::string why_unavailable(std::string_view backend, const SolverOptions&) {
  find_backend(backend);
  return {};
}

std::vector<std::string> backend_names() {
  std::vector<std::string> names;
  for (const Backend& backend : backends) names.emplace_back(backend.name);
  return names;
}

}  // namespace phymul
