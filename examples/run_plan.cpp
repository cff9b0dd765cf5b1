// SPDX-License-Identifier: MIT
#include "run_plan.h"

#include <phymul/error.h>

#include <cstdio>
#include <utility>

#include "surface_body.h"

namespace {

/// The words without the options that the plan answers.
std::string command(const std::vector<std::string>& words, const phymul::PlanCandidate& chosen) {
  std::string result;
  for (std::size_t k = 0; k < words.size(); ++k) {
    const std::string name = words[k].substr(0, words[k].find('='));
    if (name == "--plan") continue;
    if (name == "--max-error" || name == "--rate" || name == "--probe-time" || name == "--backend" ||
        name == "--threads") {
      if (name == words[k]) ++k;
      continue;
    }
    result += quoted_word(words[k]) + ' ';
  }
  return result + "--spacing " + shortest_decimal(chosen.spacing) + " --backend " + chosen.backend + " --threads " +
         std::to_string(chosen.threads);
}

}  // namespace

int print_plan(const RunOptions& options, const std::vector<std::string>& words, phymul::SceneBuilder builder) {
  if (!is_surface(options.body) && !is_label_image(options.body)) {
    throw phymul::Error("--plan: expected a surface or a labelled image, which can be filled at any spacing, got " +
                        options.body);
  }
  if (options.tearing && options.probe_time == 0.0) {
    throw phymul::Error("--tear: a rest shape is found without tears; give --probe-time, s of motion to compare");
  }
  phymul::PlanOptions wishes{.max_error = options.max_error, .rate = options.rate, .probe_time = options.probe_time};
  if (options.backend != "auto") wishes.backends = {options.backend};
  if (options.threads > 0) wishes.most_threads = options.threads;
  const phymul::Plan plan = phymul::plan(std::move(builder), wishes);
  std::fputs(plan.report().c_str(), stdout);
  if (!plan.kept) return 3;
  std::printf("\n%s\n", command(words, plan.chosen.candidate).c_str());
  return 0;
}
