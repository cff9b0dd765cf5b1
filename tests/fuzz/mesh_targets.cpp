// SPDX-License-Identifier: MIT
#include <phymul/check.h>
#include <phymul/state.h>
#include <phymul/writer.h>

#include <algorithm>
#include <optional>

#include "fuzz_target.h"
#include "io/mesh/mesh_parts.h"

namespace phymul::fuzz {
namespace {

std::optional<Model> read_as(const std::string& file, std::string_view bytes) {
  std::optional<Model> model;
  accepts_file(file, [&] { model = mesh_from_bytes(file, bytes, {}); });
  if (model) check_model(*model);
  return model;
}

/// What ParaView is given is read back as the same places and cells. Of a wedge without volume a file does not say how
/// it is wound.
void check_vtu(const Model& model) {
  const std::vector<Finding> flaws = find_flaws(model);
  if (std::ranges::any_of(flaws, [](const Finding& f) { return f.flaw == Flaw::degenerate_cell; })) return;
  const std::string path = file_with("", ".vtu");
  if (!accepts([&] { write_vtu(model, rest_state(model), path); })) return;
  try {
    const Model again = read_mesh(path);
    const bool same_cells = std::ranges::equal(again.cells, model.cells, [](const Cell& a, const Cell& b) {
      return a.type == b.type && a.particles == b.particles;
    });
    require(again.rest == model.rest && same_cells, "other places or cells after writing and reading a .vtu file");
  } catch (const Error& error) {
    throw Violation(std::string("written, but not read: ") + error.what());
  }
}

}  // namespace

void gmsh(std::string_view bytes) {
  read_as("any.msh", bytes);
}

void vtk(std::string_view bytes) {
  read_as("any.vtk", bytes);
}

void vtu(std::string_view bytes) {
  if (const std::optional<Model> model = read_as("any.vtu", bytes)) check_vtu(*model);
}

}  // namespace phymul::fuzz
