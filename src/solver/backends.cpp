// SPDX-License-Identifier: MIT
//
// The table of backends, and what "auto" takes of them.
#include <phymul/backend.h>
#include <phymul/error.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <limits>

#include "base/files.h"
#include "cpu/cpu_backends.h"
#include "cpu/simd/job.h"
#include "topology/neighbourhoods.h"
#ifdef PHYMUL_HAS_GL
#include "device/float_tables.h"
#include "gl_module.h"
#include "scene/tool_state.h"
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
  throw with_prefix("backend \"" + std::string(name_of(backend)) + "\": ", error);
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
    Backend{"cpu", cpu::make_simd_solver, always_available},
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
  const char* const hint = name == "gl" || name == "gl-compute" ? "; build phymul with PHYMUL_WITH_GL=ON for it" : "";
  throw Error(ErrorCode::unknown_name,
              "unknown backend \"" + std::string(name) + "\"; this build has: " + known + hint);
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
    if (!solver.step(timed_steps, dt).ok()) {
      best = std::numeric_limits<double>::infinity();
      break;
    }
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / timed_steps;
    if (round == 1 || (round > 1 && seconds < best)) best = seconds;
  }
  solver.reset();
  return best;
}
#endif

std::string layout_text(const TopologyTextures& topology, bool enumerated) {
  return topology.base_count == 0 ? "no bases" : enumerated ? "bases enumerated" : "bases by table";
}

/// Threads, vectors and layout.
std::string processor_text(const Solver& cpu) {
  return cpu.device() + ", " + layout_text(cpu.topology(), is_enumerable(cpu.topology(), cpu::simd::most_enumerated));
}

Choice processor_because(std::unique_ptr<Solver> cpu, const std::string& reason) {
  const std::string processor = processor_text(*cpu);
  return {std::move(cpu), "cpu: " + reason + "; processor: " + processor};
}

#ifdef PHYMUL_HAS_GL
/// The faster of the processor and the GPU on this very body.
Choice faster_of(std::unique_ptr<Solver>& cpu, std::unique_ptr<Solver>& gl, const SolverOptions& options) {
  const double on_cpu = seconds_a_step(*cpu), on_gl = seconds_a_step(*gl);
  const FloatLayout layout = choose_layout(options.gl.layout, gl->topology());
  const std::string on_gpu = gl->device() + ", " + layout_text(gl->topology(), layout == FloatLayout::enumerated);
  const std::string devices = processor_text(*cpu) + "; GPU: " + on_gpu;
  std::unique_ptr<Solver>& faster = on_gl < on_cpu ? gl : cpu;
  const std::unique_ptr<Solver>& slower = on_gl < on_cpu ? cpu : gl;
  std::array<char, 120> measured{};
  std::snprintf(measured.data(), measured.size(),
                "%s: a step took %.3g us, by %s %.3g us; processor: ", std::string(faster->name()).c_str(),
                1e6 * std::min(on_cpu, on_gl), std::string(slower->name()).c_str(), 1e6 * std::max(on_cpu, on_gl));
  return {std::move(faster), measured.data() + devices};
}

/// Of the GL backends the one of compute shaders, where a GPU has them, is measured against the processor; the other
/// one where not. A software renderer is none to measure.
Choice choose_with_gl(std::unique_ptr<Solver>& cpu, const std::shared_ptr<const TopologyTextures>& topology,
                      const Scene& scene, const SolverOptions& options) {
  std::string no_compute, no_gl;
  const auto measured = [&](GlBackend backend, auto make, std::string& why_not) -> Choice {
    try {
      const GlDevice device = load_gl_module().probe(backend, options.gl);
      if (device.software) {
        why_not = "GL has a software renderer only (" + device.name + ")";
        return {};
      }
      std::unique_ptr<Solver> gl = make(topology, scene, options);
      return faster_of(cpu, gl, options);
    } catch (const Error& error) {
      why_not = std::string("GL is not available: ") + error.what();
      return {};
    }
  };
  Choice choice = measured(GlBackend::compute, make_gl_solver<GlBackend::compute>, no_compute);
  if (choice.solver) return choice;
  choice = measured(GlBackend::fragment, make_gl_solver<GlBackend::fragment>, no_gl);
  if (choice.solver) {
    choice.reason += "; not gl-compute: " + no_compute;
    return choice;
  }
  return processor_because(std::move(cpu), no_gl);
}
#endif

Choice choose(const std::shared_ptr<const TopologyTextures>& topology, const Scene& scene,
              const SolverOptions& options) {
  std::unique_ptr<Solver> cpu;
  try {
    cpu = cpu::make_simd_solver(topology, scene, options);
  } catch (const Error& error) {
    // Where the fault is the caller's, the reference backend finds it again.
    return {cpu::make_reference_solver(topology, scene, options), std::string("reference: ") + error.what()};
  }
#ifdef PHYMUL_HAS_GL
  if (has_needle(scene.tools())) {
    return processor_because(
        std::move(cpu), "the scene has needles, and what they cost a GPU no trial shows before they are in tissue");
  }
  if (touches_surface(scene.tools())) {
    return processor_because(
        std::move(cpu),
        "the scene has a Blade or a tool with ToolContact::surface, and no trial shows what it costs the "
        "processor before it touches");
  }
  if (!scene.threads().empty()) {
    return processor_because(std::move(cpu), "the scene has threads, which act on the processor in every step");
  }
  if (scene.contacts()) {
    return processor_because(std::move(cpu),
                             "the scene has contacts, and what they cost a GPU no trial shows before bodies touch");
  }
  if (topology->particle_count < gl_particles) {
    return processor_because(std::move(cpu),
                             std::to_string(topology->particle_count) + " particles are too few for a GPU to gain on");
  }
  return choose_with_gl(cpu, topology, scene, options);
#else
  return processor_because(std::move(cpu), "this build has no GL backend (PHYMUL_WITH_GL)");
#endif
}

}  // namespace

std::unique_ptr<Solver> make_solver(std::string_view backend, std::shared_ptr<const TopologyTextures> topology,
                                    const Scene& scene, const SolverOptions& options) {
  if (!topology) throw Error("make_solver: the topology is null; build_topology makes one");
  if (backend != "auto") return find_backend(backend).make(std::move(topology), scene, options);
  // What is tried out in between is none of the caller's calls.
  SolverOptions quiet = options;
  quiet.progress = {};
  Choice choice = choose(topology, scene, quiet);
  auto& chosen = static_cast<SolverBackend&>(*choice.solver);
  chosen.options_.progress = options.progress;
  chosen.clear_profile();
  chosen.backend_reason_ = std::move(choice.reason);
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
