// SPDX-License-Identifier: MIT
//
// A GL module whose GPU takes no time, or with PHYMUL_TEST_SLOW_GPU=1 more than any processor; PHYMUL_TEST_OLD_GPU=1:
// one without compute shaders. What "auto" makes of a GPU that is not here.
#include <phymul/error.h>

#include <chrono>
#include <cstdlib>
#include <string_view>
#include <thread>

#include "solver/gl_module.h"
#include "support/outside_backend.h"

namespace phymul {
namespace {

bool is_set(const char* name) {
  const char* value = std::getenv(name);
  return value && std::string_view(value) == "1";
}

class InstantSolver final : public test::StandingBackend {
 public:
  InstantSolver(GlBackend backend, std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                const SolverOptions& options)
      : StandingBackend(name_of(backend), std::move(topology), scene, options) {
    reset();
  }

 private:
  const char* do_cannot() const override { return beyond_devices(); }
  Motion do_step(const StepPlan& plan) override {
    if (is_set("PHYMUL_TEST_SLOW_GPU")) std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return StandingBackend::do_step(plan);
  }
  std::string do_device() const override { return "Instant GPU"; }
};

GlDevice probe(GlBackend backend, const GlOptions&) {
  if (backend == GlBackend::compute && is_set("PHYMUL_TEST_OLD_GPU")) throw Error("Instant GPU is too old");
  return {.name = "Instant GPU"};
}

std::unique_ptr<Solver> make(GlBackend backend, std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                             const SolverOptions& options) {
  return std::make_unique<InstantSolver>(backend, std::move(topology), scene, options);
}

}  // namespace
}  // namespace phymul

extern "C" const phymul::GlModule* phymul_gl_module() {
  static const phymul::GlModule module{.stamp = {}, .probe = phymul::probe, .make = phymul::make};
  return &module;
}
