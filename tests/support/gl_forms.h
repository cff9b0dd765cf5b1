// SPDX-License-Identifier: MIT
//
// What a GL backend can be asked for, and the fixture of tests that every form runs.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "gl_twins.h"

namespace phymul::test {

struct GlForm {
  const char* name;
  GlBackend backend;
  GlCompute compute;
  int passes;
};

inline auto all_gl_forms() {
  return testing::Values(GlForm{"gl", GlBackend::fragment, GlCompute::automatic, 2},
                         GlForm{"gl_four_passes", GlBackend::fragment, GlCompute::automatic, 4},
                         GlForm{"gl_compute", GlBackend::compute, GlCompute::workgroup, 2},
                         GlForm{"gl_compute_store", GlBackend::compute, GlCompute::store, 2});
}

/// A block of soft tissue, 3 x 2 x 2 cm.
class GlBlockTest : public GlTest, public testing::WithParamInterface<GlForm> {
 protected:
  GlBlockTest() : model_(make_block({0.03, 0.02, 0.02}, 6, 4, 4)) { set_material(model_, soft_tissue()); }
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    PHYMUL_SKIP_OR_FAIL(why_not_here(name_of(GetParam().backend)));
    tables_ = tables_of(model_, {});
    options_.damping.rate = 30.0;
    options_.gl.compute = GetParam().compute;
    options_.gl.passes = GetParam().passes;
    options_.gl.debug = true;
    options_.spectrum = estimate_spectrum(*tables_, tables_->rest);
    dt_ = 0.4 * stable_step(*options_.spectrum, 1.0);
  }
  GlTwins twins(const Scene& scene) const { return {tables_, scene, options_, GetParam().backend}; }
  std::unique_ptr<gl::DeviceSolver> make(const Scene& scene) const {
    return std::make_unique<gl::DeviceSolver>(GetParam().backend, tables_, scene, options_);
  }

  Model model_;
  std::shared_ptr<const TopologyTextures> tables_;
  SolverOptions options_;
  double dt_ = 0.0;
};

/// What draws or dispatches, and how often; 0 for what runs once a batch, of which the clock makes more or fewer.
inline std::vector<std::pair<std::string, std::int64_t>> runs_of(Solver& solver) {
  std::vector<std::pair<std::string, std::int64_t>> runs;
  for (const PassProfile& pass : solver.profile()) {
    const bool of_batch =
        pass.name.starts_with("report") || pass.name.starts_with("workgroup") || pass.name.starts_with("tool_sums");
    runs.emplace_back(pass.name, of_batch ? 0 : pass.runs);
  }
  return runs;
}

}  // namespace phymul::test

#define PHYMUL_IN_ALL_GL_FORMS(suite) \
  INSTANTIATE_TEST_SUITE_P(All, suite, all_gl_forms(), [](const auto& form) { return form.param.name; })
