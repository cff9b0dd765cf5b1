// SPDX-License-Identifier: MIT
//
// The vector backend against the double reference, for every term, instruction set and number of threads.
#include <gtest/gtest.h>

#include <cstdlib>

#include "allocation_count.h"
#include "bodies.h"
#include "cpu/mirror.h"
#include "cpu/simd/instruction_set.h"
#include "message_of.h"

namespace phymul::test {
namespace {

/// The environment variable that names an instruction set, for as long as this lives.
class InstructionSet {
 public:
  explicit InstructionSet(const char* name) { setenv("PHYMUL_CPU_ISA", name, 1); }
  ~InstructionSet() { unsetenv("PHYMUL_CPU_ISA"); }
};

std::vector<const char*> instruction_sets() {
  std::vector<const char*> names;
  for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) names.push_back(kernels->name);
  return names;
}

/// Those of conservative_variants() and the reactions that have no energy.
std::vector<Variant> all_variants() {
  std::vector<Variant> all = conservative_variants();
  for (const Reaction reaction : {Reaction::full, Reaction::shared, Reaction::barycentric}) {
    for (const double p : {0.0, 1.0}) {
      for (const BaseSelection bases : {BaseSelection::thresholded, BaseSelection::all}) {
        Variant v;
        v.name = "reaction " + std::to_string(static_cast<int>(reaction)) + " p=" + std::to_string(p) +
                 (bases == BaseSelection::all ? " all" : "");
        v.options.reaction = reaction;
        v.options.area_exponent = p;
        v.options.bases = bases;
        v.options.volume_stiffness = bases == BaseSelection::all ? 50.0 : 0.0;
        all.push_back(v);
      }
    }
  }
  for (Variant& v : all) v.options.on_sparse = SparseParticle::springs;
  return all;
}

State random_state(const Model& model, double amount, std::uint32_t seed) {
  State state = rest_state(model);
  state.position = random_positions(model, amount, seed);
  std::mt19937 bits(seed + 1);
  for (Vec3& v : state.velocity) v = 0.01 * mean_spacing(model) * random_vector(bits, model.dimension);
  return state;
}

SolverOptions any_step() {
  SolverOptions options;
  options.on_unstable = UnstableStep::allow;
  return options;
}

/// Largest difference in velocity after a step.
double velocity_error(const State& a, const State& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.velocity.size(); ++i) {
    largest = std::max(largest, (a.velocity[i] - b.velocity[i]).norm());
  }
  return largest;
}

TEST(CpuBackend, OneStepIsTheReferencesWithinRounding) {
  double worst = 0.0;
  for (const Body& body : bodies()) {
    for (const Variant& variant : all_variants()) {
      if (!applies(variant, body)) continue;
      const Model model = prepared(variant, body);
      const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, variant.options));
      Scene scene(model);
      scene.gravity({0.1, -0.2, model.dimension == 2 ? 0.0 : 0.3});
      const auto reference = make_solver("reference", tables, scene, any_step());
      SolverOptions known = any_step();
      known.spectrum = estimate_spectrum(*tables, tables->rest);
      const auto mirror = cpu::make_mirror_solver(tables, scene, known);
      const double dt = 0.5 * std::min(reference->stable_step(), 1e3);
      for (const char* isa : instruction_sets()) {
        const InstructionSet chosen(isa);
        const auto solver = make_solver("cpu", tables, scene, known);
        for (const double amount : {1e-4, 0.05, 0.4}) {
          SCOPED_TRACE(body.name + ", " + variant.name + ", " + isa + ", " + std::to_string(amount));
          // What both start from is exactly a float's.
          mirror->reset(random_state(model, amount, 3));
          const State start = mirror->read();
          for (Solver* s : {reference.get(), mirror.get(), solver.get()}) {
            s->reset(start);
            ASSERT_TRUE(s->step(1, dt).ok());
          }
          const State exact = reference->read();
          const double error = velocity_error(solver->read(), exact), scalar = velocity_error(mirror->read(), exact);
          double change = 0.0;
          for (std::size_t i = 0; i < exact.velocity.size(); ++i) {
            change = std::max(change, (exact.velocity[i] - start.velocity[i]).norm());
          }
          EXPECT_LE(error, 2.0 * scalar + 4e-7 * change) << "scalar " << scalar << ", change " << change;
          worst = std::max(worst, error / change);
        }
      }
    }
  }
  RecordProperty("worst_relative_error", std::to_string(worst));
  std::printf("worst error of a velocity change, relative: %.3g\n", worst);
}

}  // namespace
}  // namespace phymul::test
