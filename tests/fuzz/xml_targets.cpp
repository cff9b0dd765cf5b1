// SPDX-License-Identifier: MIT
#include <phymul/lml.h>
#include <phymul/pml.h>
#include <phymul/shapes.h>

#include <sstream>

#include "fuzz_target.h"

namespace phymul::fuzz {

void pml(std::string_view bytes) {
  accepts_file("any.pml", [&] { check_model(read_pml_text(std::string(bytes), "any.pml")); });
}

void lml(std::string_view bytes) {
  static const Model body = make_block({0.04, 0.01, 0.01}, 4, 1, 1).add_group("Tip", {3, 1});
  std::vector<Load> loads;
  if (!accepts_file("any.lml", [&] { loads = read_lml_text(std::string(bytes), "any.lml", body); })) return;
  const bool is_taken = accepts([&] {
    Scene scene(body);
    for (const Load& load : loads) {
      if (load.type != LoadType::pressure) scene.add(load);  // only a scene knows whether there are facets to press on
    }
  });
  require(is_taken, "loads that a file may have, but not a scene");
  std::ostringstream out;
  if (!accepts([&] { write_lml(loads, body, out); })) return;
  require(read_lml_text(out.str(), "again.lml", body) == loads, "other loads after writing and reading:\n" + out.str());
}

}  // namespace phymul::fuzz
