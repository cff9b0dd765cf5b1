// SPDX-License-Identifier: MIT
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

#include "base/checked_file.h"
#include "fuzz_target.h"
#include "io/mesh/mesh_parts.h"
#include "session/scene_bytes.h"
#include "session/wire_codes.h"

namespace phymul::fuzz {
namespace {

constexpr Index most_particles = 3000;

/// What make_body() gives is a body that simulates: valid, in the limits asked for.
void check_body(const Model& body, const BodyReport& report) {
  check_model(body);
  require(body.particle_count() <= most_particles, "more particles than allowed");
  require(report.particles == body.particle_count() && report.volume > 0.0, "a report of another body");
}

void check_image(const LabelImage& image) {
  require(image.label.size() == std::size_t(image.size[0]) * std::size_t(image.size[1]) * std::size_t(image.size[2]),
          "an image of other sizes than its voxels");
  require(image.origin.allFinite(), "an image that is nowhere");
}

/// Places of all triangles' corners.
VecList corners(const Surface& surface) {
  VecList places;
  for (const auto& triangle : surface.triangles) {
    for (const Index corner : triangle) places.push_back(surface.vertices.at(corner));
  }
  return places;
}

/// Whether no edge has more than two triangles.
bool is_simple(const Surface& surface) {
  std::map<std::pair<Index, Index>, int> triangles;
  for (const auto& [a, b, c] : surface.triangles) {
    for (const auto& side : {std::minmax(a, b), std::minmax(b, c), std::minmax(c, a)}) ++triangles[side];
  }
  return std::ranges::all_of(triangles, [](const auto& edge) { return edge.second <= 2; });
}

void read_image(std::string_view bytes, const char* ending) {
  const std::string path = file_with(bytes, ending);
  accepts_file(path, [&] { check_image(read_labels(path)); });
}

}  // namespace

void nifti(std::string_view bytes) {
  read_image(bytes, ".nii");
}

void nrrd(std::string_view bytes) {
  // Not files that name others: teem would open whatever they name.
  if (bytes.find("file:") == std::string_view::npos) read_image(bytes, ".nrrd");
}

void surface(std::string_view bytes) {
  Numbers in(bytes);
  Surface any;
  const int vertices = in.between(0, 31), triangles = in.between(0, 63);
  for (int k = 0; k < vertices; ++k) any.vertices.push_back(0.1 * in.point());
  for (int k = 0; k < triangles; ++k) any.triangles.push_back({in.between(-1, 32), in.between(-1, 32), in.below(32)});
  const Surface before = any;
  if (!accepts([&] { mend_surface(any); })) {
    require(any.triangles == before.triangles && any.vertices.size() == before.vertices.size(), "refused, but changed");
    return;
  }
  Surface again = any;
  mend_surface(again);  // may number vertices anew, and nothing else
  // Shells that cross along an edge that they share are not found; what is outside of them is then any one's.
  require(!is_simple(any) || corners(again) == corners(any), "mended twice it is another one");
  BodyReport report;
  accepts([&] {
    const double spacing = 0.02 + 0.02 * std::abs(in.real());
    check_body(make_body(any, {.spacing = spacing, .most_particles = most_particles}, &report), report);
  });
}

void labels(std::string_view bytes) {
  Numbers in(bytes);
  LabelImage image;
  for (Index& size : image.size) size = in.between(1, 6);
  image.origin = 0.1 * in.point();
  for (Vec3& step : image.step) step += 1e-3 * in.point();
  image.label.resize(std::size_t(image.size[0]) * std::size_t(image.size[1]) * std::size_t(image.size[2]));
  LabelBodyOptions options{.spacing = 1e-3 * (0.5 + 4 * std::abs(in.real())), .most_particles = most_particles};
  options.most_volume_error = 0.01 * in.below(100);
  if (in.below(4) == 0) options.regions = {{1, "one"}, {2, in.below(2) == 0 ? "one" : "two"}};
  for (std::uint16_t& label : image.label) label = static_cast<std::uint16_t>(in.below(4));
  BodyReport report;
  accepts([&] { check_body(make_body(image, options, &report), report); });
}

namespace {

Model any_model(Numbers& in) {
  Model model;
  model.dimension = in.below(8) == 0 ? 2 : 3;
  const int particles = in.between(0, 24);
  for (int k = 0; k < particles; ++k) {
    Vec3 place = 0.1 * in.point();
    if (model.dimension == 2) place.z() = 0.0;
    model.rest.push_back(place);
  }
  model.mass.assign(model.rest.size(), in.below(16) == 0 ? in.real() : 1.0);
  model.stiffness.assign(model.rest.size(), in.below(16) == 0 ? in.real() : 1.0);
  for (int cells = in.between(0, 20); cells > 0; --cells) {
    Cell cell;
    cell.type = static_cast<CellType>(in.between(0, 9));
    const int size = cell_size(cell.type) > 0 && in.below(32) > 0 ? cell_size(cell.type) : in.below(10);
    for (int k = 0; k < size; ++k) cell.particles.push_back(in.below(64) == 0 ? in.between(-1, 40) : in.below(25));
    model.cells.push_back(cell);
  }
  if (in.below(2) == 0) {
    model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  } else if (in.below(2) == 0) {
    model.neighbours = nearest_neighbours(model.rest, in.between(1, 8));
  } else {
    for (int k = 0; k < particles; ++k) {
      std::vector<Index> row;
      for (int size = in.below(9); size > 0; --size) row.push_back(in.below(26));
      model.neighbours.push_row(row.begin(), row.end());
    }
  }
  return model;
}

void simulate(const Model& model, const TopologyOptions& options) {
  std::optional<TopologyTextures> built;
  if (!accepts([&] { built = build_topology(model, options); })) return;
  const auto tables = std::make_shared<const TopologyTextures>(std::move(*built));
  for (const char* backend : {"reference", "cpu"}) {
    accepts([&] {
      Scene scene = Scene(model).gravity({0, 0, -9.81});
      const auto solver = make_solver(backend, tables, scene, {.threads = 1});
      const double limit = solver->stable_step();
      solver->step(3, limit > 0.0 && limit < 1.0 ? 0.5 * limit : 1e-3);
      require(is_finite(solver->read()), std::string(backend) + ": a state that is not finite");
    });
  }
}

}  // namespace

void model(std::string_view bytes) {
  Numbers in(bytes);
  Model any;
  if (!accepts([&] {
        any = any_model(in);
        validate(any);
      })) {
    return;
  }
  find_flaws(any);
  surface_triangles(any);
  volume(any, any.rest);
  if (!accepts([&] { check_mesh(any); })) return;
  check_model(any);
  if (in.below(2) == 0) {
    Material material{.young = 1e3, .poisson = 0.45 * in.real(), .density = 1000};
    if (in.below(4) == 0) material = {in.real(), in.real(), in.real(), in.real()};
    if (in.below(4) == 0) material.retardation_time = in.real();
    if (in.below(4) == 0) material.stiffening = {in.real(), in.real(), in.real(), in.real()};
    accepts([&] { set_material(any, material); });
    check_model(any);
  }
  TopologyOptions options;
  if (in.below(2) == 0) options.law = static_cast<Law>(in.below(2));
  options.reaction = static_cast<Reaction>(in.below(5));
  options.bases = static_cast<BaseSelection>(in.below(2));
  options.strain_energy = static_cast<StrainEnergy>(in.below(3));
  options.on_sparse = static_cast<SparseParticle>(in.below(2));
  if (in.below(4) == 0) options.volume_stiffness = in.real();
  simulate(any, options);
}

namespace {

/// A file of sections with the checksums that its bytes have.
std::string with_checksums(std::string_view bytes) {
  std::string file(bytes);
  for (std::size_t start = 12; start + 16 <= file.size();) {
    ByteReader head("", std::string_view(file).substr(start + 4));
    const std::uint64_t length = head.u64("a length");
    if (length > file.size() - start - 16) break;
    const std::size_t end = start + 12 + static_cast<std::size_t>(length);
    ByteWriter sum;
    sum.u32(checksum(std::string_view(file).substr(start, end - start)));
    file.replace(end, 4, sum.bytes());
    start = end + 4;
  }
  return file;
}

std::string bytes_of(const Snapshot& snapshot) {
  ByteWriter out;
  put_snapshot(out, snapshot);
  return out.bytes();
}

/// Bits, so that 0 and -0 differ.
void check_snapshot(const Snapshot& snapshot) {
  require(is_finite(snapshot.state), "a state that is not finite");
  const std::string once = bytes_of(snapshot);
  ByteReader in("again", once);
  require(bytes_of(take_snapshot(in)) == once && in.remaining() == 0, "another state after writing and reading");
}

struct SmallBody {
  Model model = make_block({0.02, 0.02, 0.02}, 1, 1, 1);
  std::shared_ptr<const TopologyTextures> tables;
  SmallBody() {
    set_material(model, {.young = 1e4, .poisson = 0.3, .density = 1000});
    tables = std::make_shared<const TopologyTextures>(build_topology(model));
  }
};

const SmallBody& small_body() {
  static const SmallBody body;
  return body;
}

/// A recording may ask for any number of steps.
void shorten(Recording& recording) {
  if (recording.inputs.size() > 20) recording.inputs.resize(20);
  for (Input& input : recording.inputs) {
    input.times = 1;
    const bool steps =
        input.kind == input_kind::step || input.kind == input_kind::to_rest || input.kind == input_kind::to_rest_damped;
    if (!steps || input.bytes.size() < 4) continue;
    input.bytes.replace(1, 3, 3, '\0');  // n below 256
  }
}

}  // namespace

void state(std::string_view bytes) {
  const std::string file = with_checksums(bytes);
  Snapshot snapshot;
  if (!accepts_file("any.state", [&] { snapshot = read_state_bytes(file, "any.state"); })) return;
  check_snapshot(snapshot);
  for (const char* backend : {"reference", "cpu"}) {
    const Scene scene(small_body().model);
    const auto solver = make_solver(backend, small_body().tables, scene, {.threads = 1});
    snapshot.topology_hash = solver->topology_hash();
    const Snapshot before = solver->snapshot();
    if (accepts([&] { solver->restore(snapshot); })) {
      solver->step(2, 0.2 * solver->stable_step());
    } else {
      require(solver->snapshot() == before, "a state that was refused, but changed the solver");
    }
    require(is_finite(solver->read()), "a solver whose state is not finite");
  }
}

void recording(std::string_view bytes) {
  const std::string file = with_checksums(bytes);
  Recording read;
  if (!accepts_file("any.rec", [&] { read = read_recording_bytes(file, "any.rec"); })) return;
  check_snapshot(read.start);
  const std::string path = file_with("", ".rec");
  save_recording(read, path);
  require(read_recording(path) == read, "another recording after writing and reading");
  shorten(read);
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene(small_body().model);
    const auto solver = make_solver(backend, small_body().tables, scene, {.threads = 1});
    read.topology_hash = solver->topology_hash();
    read.options = recorded_options(*solver);
    accepts([&] { Replay(read, *solver, scene).run(); });
    require(is_finite(solver->read()), "a solver whose state is not finite");
  }
}

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
