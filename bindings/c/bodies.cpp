// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cctype>

#include "handles.h"

using namespace phymul;
using namespace phymul::c;

static_assert(static_cast<int>(CellType::triangle) == PHYMUL_TRIANGLE);
static_assert(static_cast<int>(CellType::tetrahedron) == PHYMUL_TETRAHEDRON);
static_assert(static_cast<int>(CellType::wedge) == PHYMUL_WEDGE);
static_assert(static_cast<int>(CellType::pyramid) == PHYMUL_PYRAMID);
static_assert(static_cast<int>(CellType::hexahedron) == PHYMUL_HEXAHEDRON);
static_assert(static_cast<int>(StrainTest::shear) == PHYMUL_SHEAR);
static_assert(sizeof(std::array<Index, 3>) == 3 * sizeof(int32_t));

namespace {

/// Makes a body by a function that returns a Model.
template <class Builder>
phymul_status make(phymul_body** made, Builder&& builder) {
  return guarded([&] {
    need(made, "a place for the body");
    *made = new phymul_body{builder()};
  });
}

bool is_pml(const std::string& path) {
  std::string end = path.substr(path.size() < 4 ? 0 : path.size() - 4);
  for (char& letter : end) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return end == ".pml";
}

std::vector<Cell> cells_of(const int32_t* types, const int32_t* first, const int32_t* particles, int32_t count) {
  list(types, count, "types of cells");
  list(first, count, "first entries of cells");
  std::vector<Cell> cells(static_cast<std::size_t>(count));
  for (int32_t i = 0; i < count; ++i) {
    require_kind(types[i], PHYMUL_TETRAHEDRON, 4, "a type of cells");
    cells[i].type = static_cast<CellType>(types[i]);
    const int size = cell_size(cells[i].type);
    if (first[i] != (i > 0 ? first[i - 1] + cell_size(cells[i - 1].type) : 0) || first[i + 1] - first[i] != size)
      throw Error("cell " + std::to_string(i) + ", a " + cell_name(cells[i].type) + ": expected " +
                  std::to_string(size) + " entries after those of the cell before; got those from " +
                  std::to_string(first[i]) + " to " + std::to_string(first[i + 1]));
    need(particles, "particles of cells");
    cells[i].particles.assign(particles + first[i], particles + first[i + 1]);
  }
  return cells;
}

Model from_arrays(VecList rest, std::vector<Cell> cells) {
  Model model;
  model.rest = std::move(rest);
  model.cells = std::move(cells);
  model.mass.assign(model.rest.size(), 1.0);
  model.stiffness.assign(model.rest.size(), 1.0);
  model.neighbours = model.cells.empty() ? nearest_neighbours(model.rest, 20)
                                         : neighbours_from_cells(model.cells, model.particle_count());
  validate(model);
  check_mesh(model);
  return model;
}

Surface surface_of(const double* vertices, int32_t vertex_count, const int32_t* triangles, int32_t triangle_count) {
  return {.vertices = vectors(vertices, vertex_count, "vertices"),
          .triangles = triples(triangles, triangle_count, "triangles"),
          .notes = {}};
}

}  // namespace

phymul_status phymul_surface_read(const char* path, double metres_per_unit, phymul_surface** made) {
  return guarded([&] {
    need(made, "a place for the surface");
    need(path, "a path");
    *made = new phymul_surface{read_surface(path, metres_per_unit == 0.0 ? 1.0 : metres_per_unit)};
  });
}

void phymul_surface_free(phymul_surface* surface) {
  delete surface;
}

phymul_status phymul_surface_vertices(const phymul_surface* surface, const double** vertices, int32_t* count) {
  return guarded([&] {
    const VecList& all = need(surface, "a surface").surface.vertices;
    hand_out(doubles(all), all.size(), vertices, count, "a place for the vertices");
  });
}

phymul_status phymul_surface_triangles(const phymul_surface* surface, const int32_t** triangles, int32_t* count) {
  return guarded([&] {
    const auto& all = need(surface, "a surface").surface.triangles;
    hand_out(all.empty() ? nullptr : all.front().data(), all.size(), triangles, count, "a place for the triangles");
  });
}

phymul_status phymul_body_block(const double size[3], int32_t nx, int32_t ny, int32_t nz, phymul_body** made) {
  return make(made, [&] { return make_block(vector(size, "a size"), nx, ny, nz); });
}

phymul_status phymul_body_tetrahedral_block(const double size[3], int32_t nx, int32_t ny, int32_t nz, double jitter,
                                            uint32_t seed, phymul_body** made) {
  return make(made, [&] { return make_tetrahedral_block(vector(size, "a size"), nx, ny, nz, jitter, seed); });
}

phymul_status phymul_body_cylinder(double radius, double length, int32_t rings, int32_t sectors, int32_t discs,
                                   phymul_body** made) {
  return make(made, [&] { return make_cylinder(radius, length, rings, sectors, discs); });
}

phymul_status phymul_body_read(const char* path, double metres_per_unit, phymul_body** made) {
  return make(made, [&] {
    const std::string file = &need(path, "a path");
    if (!is_pml(file)) return read_mesh(file, {.length_unit = metres_per_unit == 0.0 ? 1.0 : metres_per_unit});
    return read_pml(file, {.length_unit = metres_per_unit == 0.0 ? 1e-3 : metres_per_unit});
  });
}

phymul_status phymul_body_fill(const double* vertices, int32_t vertex_count, const int32_t* triangles,
                               int32_t triangle_count, double spacing, const phymul_fine_place* places,
                               int32_t place_count, phymul_body** made) {
  return make(made, [&] {
    std::vector<SpacingField> fields;
    for (const phymul_fine_place& at : list(places, place_count, "places")) {
      fields.push_back(fine_near(vector(at.place, "a place"), at.radius, at.spacing, spacing));
    }
    const auto finest = [fields, spacing](const Vec3& place) {
      double least = spacing;
      for (const SpacingField& field : fields) least = std::min(least, field(place));
      return least;
    };
    const Surface surface = surface_of(vertices, vertex_count, triangles, triangle_count);
    return make_body(surface, {.spacing = spacing, .spacing_at = fields.empty() ? SpacingField() : finest});
  });
}

phymul_status phymul_body_wall(const double* vertices, int32_t vertex_count, const int32_t* triangles,
                               int32_t triangle_count, double spacing, const phymul_material* material,
                               phymul_body** made) {
  return make(made, [&] {
    WallOptions options{.material = material_of(material)};
    if (spacing != 0.0) options.spacing = spacing;
    return make_wall(surface_of(vertices, vertex_count, triangles, triangle_count), options);
  });
}

phymul_status phymul_body_from_arrays(const double* rest, int32_t particle_count, const int32_t* types,
                                      const int32_t* first, const int32_t* particles, int32_t cell_count,
                                      phymul_body** made) {
  return make(made, [&] {
    return from_arrays(vectors(rest, particle_count, "particles"), cells_of(types, first, particles, cell_count));
  });
}

phymul_status phymul_body_moved(const phymul_body* body, const double by[3], phymul_body** made) {
  return make(made, [&] { return moved(need(body, "a body").model, vector(by, "a displacement")); });
}

void phymul_body_free(phymul_body* body) {
  delete body;
}

phymul_status phymul_body_rest(phymul_body* body, const double** rest, int32_t* particle_count) {
  return guarded([&] {
    phymul_body& own = need(body, "a body");
    if (own.rest.empty()) own.rest = own.model.rest;
    hand_out(doubles(own.rest), own.rest.size(), rest, particle_count, "a place for the positions");
  });
}

phymul_status phymul_body_masses(const phymul_body* body, double* masses) {
  return guarded([&] {
    need(masses, "a place for the masses");
    std::ranges::copy(need(body, "a body").model.mass, masses);
  });
}

phymul_status phymul_body_cells(phymul_body* body, const int32_t** types, const int32_t** first,
                                const int32_t** particles, int32_t* cell_count) {
  return guarded([&] {
    phymul_body& own = need(body, "a body");
    if (own.first.size() != own.model.cells.size() + 1) {  // a capsule has added some
      std::vector<int32_t> begins{0};
      own.types.clear();
      own.particles.clear();
      for (const Cell& cell : own.model.cells) {
        own.types.push_back(static_cast<int32_t>(cell.type));
        own.particles.insert(own.particles.end(), cell.particles.begin(), cell.particles.end());
        begins.push_back(static_cast<int32_t>(own.particles.size()));
      }
      own.first = std::move(begins);
    }
    need(first, "a place for the first entries");
    need(particles, "a place for the particles");
    hand_out(own.types.data(), own.types.size(), types, cell_count, "a place for the types");
    *first = own.first.data();
    *particles = own.particles.data();
  });
}

phymul_status phymul_body_triangles(phymul_body* body, const int32_t** triangles, int32_t* count) {
  return guarded([&] {
    phymul_body& own = need(body, "a body");
    if (own.triangles.empty()) own.triangles = surface_triangles(own.model);
    hand_out(own.triangles.empty() ? nullptr : own.triangles.front().data(), own.triangles.size(), triangles, count,
             "a place for the triangles");
  });
}

phymul_status phymul_body_notes(phymul_body* body, const char** notes) {
  return guarded([&] {
    phymul_body& own = need(body, "a body");
    need(notes, "a place for the notes");
    own.notes = lines(own.model.notes);
    *notes = own.notes.c_str();
  });
}

phymul_status phymul_body_groups(phymul_body* body, const char** names) {
  return guarded([&] {
    phymul_body& own = need(body, "a body");
    need(names, "a place for the names");
    std::vector<std::string> all;
    for (const Component& component : own.model.components) {
      if (!component.name.empty() && std::ranges::find(all, component.name) == all.end()) all.push_back(component.name);
    }
    own.groups = lines(all);
    *names = own.groups.c_str();
  });
}

phymul_status phymul_body_group(phymul_body* body, const char* name, const int32_t** particles, int32_t* count) {
  return guarded([&] {
    phymul_body& own = need(body, "a body");
    need(particles, "a place for the particles");
    need(count, "a place for the number");
    own.group = own.model.group(&need(name, "a name of the group"));
    hand_out(own.group.data(), own.group.size(), particles, count, "a place for the particles");
  });
}

phymul_status phymul_body_add_group(phymul_body* body, const char* name, const int32_t* particles, int32_t count) {
  return guarded([&] {
    require_name(name, "a name of the group");
    const auto rows = list(particles, count, "particles");
    need(body, "a body").model.add_group(name, {rows.begin(), rows.end()});
  });
}

phymul_status phymul_body_add_cell_group(phymul_body* body, const char* name, const int32_t* cells, int32_t count) {
  return guarded([&] {
    require_name(name, "a name of the group");
    Model& model = need(body, "a body").model;
    Component group;
    group.name = name;
    group.exclusive = false;
    for (const int32_t cell : list(cells, count, "cells")) {
      if (cell < 0 || cell >= std::ssize(model.cells))
        throw Error("group \"" + group.name + "\": expected cells from 0 to " +
                    std::to_string(std::ssize(model.cells) - 1) + ", got " + std::to_string(cell));
      group.cell_refs.push_back(cell);
    }
    model.components.push_back(std::move(group));
  });
}

phymul_status phymul_body_cut(const phymul_body* body, const double point[3], const double normal[3],
                              const double* front_point, const double* front_normal, phymul_body** made) {
  return make(
      made, [&] { return cut_body(need(body, "a body").model, cut_behind(point, normal, front_point, front_normal)); });
}

phymul_status phymul_body_with_spare_particles(const phymul_body* body, int32_t count, phymul_body** made) {
  return make(made, [&] { return with_spare_particles(need(body, "a body").model, count); });
}

phymul_status phymul_fit_material(const phymul_material* start, const int32_t* tests, const double* strains,
                                  const double* stresses, int32_t count, int32_t terms, int32_t goal,
                                  phymul_material* fitted, double* error, double* fitted_stresses) {
  return guarded([&] {
    const Place<phymul_material> place(fitted, "a place for the material");
    list(tests, count, "kinds of tests");
    list(strains, count, "strains");
    list(stresses, count, "stresses");
    std::vector<TestPoint> points(static_cast<std::size_t>(count));
    for (int32_t n = 0; n < count; ++n) {
      require_kind(tests[n], PHYMUL_UNIAXIAL, 2, "a kind of tests");
      points[n] = {static_cast<StrainTest>(tests[n]), strains[n], stresses[n]};
    }
    require_kind(terms, 0, 8, "terms of the stiffening");
    const FitOptions options{.goal = goal ? FitGoal::largest_error : FitGoal::least_squares,
                             .exponential = (terms & PHYMUL_FIT_EXPONENTIAL) != 0,
                             .second = (terms & PHYMUL_FIT_SECOND) != 0,
                             .second_fades = (terms & PHYMUL_FIT_FADES) != 0};
    const MaterialFit fit = fit_material(points, material_of(start), options);
    const Material& m = fit.material;
    const Stiffening& of = m.stiffening;
    place.fill({0,
                m.young,
                m.poisson,
                m.density,
                m.retardation_time,
                m.relaxation_strength,
                m.relaxation_time,
                {of.exponential, of.exponent, of.second, of.second_fades},
                m.thickness});
    if (error) *error = fit.largest_error;
    if (fitted_stresses) std::ranges::copy(fit.stress, fitted_stresses);
  });
}

phymul_status phymul_body_add_capsule(phymul_body* body, const phymul_material* material) {
  return guarded([&] { add_capsule(need(body, "a body").model, material_of(material)); });
}

phymul_status phymul_body_set_material(phymul_body* body, const phymul_material* material, const char* group) {
  return guarded([&] {
    Model& model = need(body, "a body").model;
    const Material given = material_of(material);
    group ? set_material(model, given, group) : set_material(model, given);
  });
}

phymul_status phymul_body_parts(phymul_body* body, const int32_t** parts, int32_t* particle_count,
                                const double** volumes, int32_t* count) {
  return guarded([&] {
    phymul_body& own = need(body, "a body");
    need(parts, "a place for the parts");
    need(particle_count, "a place for the number of particles");
    need(count, "a place for the number");
    need(volumes, "a place for the volumes");
    own.parts.assign(own.model.rest.size(), -1);
    own.volumes.clear();
    for (const ConnectedBody& part : connected_bodies(own.model)) {
      for (const Index i : part.particles) own.parts[i] = static_cast<int32_t>(own.volumes.size());
      own.volumes.push_back(part.volume);
    }
    hand_out(own.parts.data(), own.parts.size(), parts, particle_count, "a place for the parts");
    hand_out(own.volumes.data(), own.volumes.size(), volumes, count, "a place for the volumes");
  });
}
