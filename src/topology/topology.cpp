// SPDX-License-Identifier: MIT
#include <phymul/bodies.h>
#include <phymul/error.h>
#include <phymul/topology_textures.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "averaged_body.h"
#include "base/decimal.h"
#include "model/body_type.h"
#include "model/cell_geometry.h"
#include "neighbourhoods.h"
#include "topology_match.h"
#include "topology_terms.h"
#include "transpose.h"
#include "wall_terms.h"

namespace phymul {
namespace {

constexpr double most_stretched = 3.001;  // a lattice of just 3 passes

/// Mean of x x^T over the vertices, x from their middle.
Mat3 spread(const Cell& cell, const VecList& rest) {
  const auto count = static_cast<double>(cell.particles.size());
  Vec3 middle = Vec3::Zero();
  for (const Index i : cell.particles) middle += rest[i] / count;
  Mat3 sum = Mat3::Zero();
  for (const Index i : cell.particles) sum += (rest[i] - middle) * (rest[i] - middle).transpose() / count;
  return sum;
}

double ratio(const Mat3& spread, int dimension) {
  const Vec3 squares = Eigen::SelfAdjointEigenSolver<Mat3>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  const double least = squares[3 - dimension];  // they increase; in 2-D the first is none
  return least > 0.0 ? std::sqrt(squares[2] / least) : 1.0;
}

/// A sentence for each connected body whose cells are more than 3 times as long as thick
/// (docs/measurements/accuracy.md, "Stretched cells"). How long over how thick: of the vertices' root mean square
/// distances from their cell's middle the longest over the shortest, meant over the cells around a particle, so that
/// slivers among good cells do not count, and over the volume.
std::vector<std::string> notes_on_stretched_cells(const Model& model) {
  std::vector<Mat3> around(model.rest.size(), Mat3::Zero());
  std::vector<double> volume(model.rest.size(), 0.0), ratios(model.rest.size(), 1.0);
  for (const Cell& cell : model.cells) {
    if (!is_solid(model.dimension, cell) || cell.material < 0) continue;
    const double measure = std::abs(signed_measure(model.dimension, cell, model.rest));
    const Mat3 of_cell = measure * spread(cell, model.rest);
    for (const Index i : cell.particles) {
      around[i] += of_cell;
      volume[i] += measure;
    }
  }
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    if (volume[i] > 0.0) ratios[i] = ratio(around[i], model.dimension);
  }
  std::vector<std::string> notes;
  if (!std::ranges::any_of(ratios, [](double it) { return it > most_stretched; })) return notes;
  for (const ConnectedBody& body : connected_bodies(model)) {
    double sum = 0.0, whole = 0.0;
    for (const Index i : body.particles) {
      sum += volume[i] * ratios[i];
      whole += volume[i];
    }
    if (!(sum > most_stretched * whole)) continue;
    char stretch[32];
    std::snprintf(stretch, sizeof stretch, "%.1f", sum / whole);
    const std::string first = std::to_string(model.file_index(body.particles.front()));
    notes.push_back((body.name.empty() ? "the body of particle " + first : "body \"" + body.name + "\"") +
                    ": its cells are " + stretch +
                    " times as long as thick; it bends too little, whatever the stabiliser. Mesh it with cells that "
                    "are less than twice as long as thick");
  }
  return notes;
}

void require(bool holds, const std::string& sentence) {
  if (!holds) throw Error(sentence);
}

void check_options(const TopologyOptions& o) {
  const auto is_not_negative = [](double value) { return std::isfinite(value) && value >= 0.0; };
  require(o.min_quality >= 0.0 && o.min_quality < 1.0,
          "min_quality is " + to_decimal(o.min_quality) +
              "; expected at least 0 and below 1 (a regular triangle has 0.87)");
  require(o.max_barycentric > 0.0, "max_barycentric is " + to_decimal(o.max_barycentric) + "; expected above 0");
  require(is_not_negative(o.volume_stiffness),
          "volume_stiffness is " + to_decimal(o.volume_stiffness) + " Pa; expected 0 or more");
  if (o.stabiliser) {
    require(is_not_negative(*o.stabiliser),
            "stabiliser is " + to_decimal(*o.stabiliser) + "; expected 0 or more, or none, so that it is calibrated");
  }
  require(!o.runner || o.runner->width() >= 1,
          "TopologyOptions::runner must have a width() of 1 (the calling thread alone) or more");
}

// "particles 3, 7, 9 and 12 more", by the file's numbers where there are some.
std::string particle_names(const Model& model, const std::vector<Index>& particles) {
  constexpr std::size_t most = 5;
  std::string text = particles.size() == 1 ? "particle " : "particles ";
  for (std::size_t k = 0; k < std::min(particles.size(), most); ++k) {
    const Index i = particles[k];
    text += (k > 0 ? ", " : "") + std::to_string(model.file_index(i));
  }
  if (particles.size() > most) text += " and " + std::to_string(particles.size() - most) + " more";
  return text;
}

std::vector<Index> particles_without_base(const BaseTable& table) {
  std::vector<Index> result;
  for (Index i = 0; i + 1 < static_cast<Index>(table.offset.size()); ++i) {
    if (table.size(i) == 0) result.push_back(i);
  }
  return result;
}

/// Neither in a cell that fills space nor in a wall.
std::vector<Index> particles_without_volume(const TopologyTextures& topology) {
  std::vector<char> has(static_cast<std::size_t>(topology.particle_count), 0);
  for (const DomainTexel& domain : topology.domains) has[domain.particle] = 1;
  for (const WallTexel& wall : topology.walls) {
    for (int k = 0; k < 3; ++k) has[wall.vertex[k]] = 1;
  }
  std::vector<Index> result;
  for (Index i = 0; i < topology.particle_count; ++i) {
    if (has[i] == 0) result.push_back(i);
  }
  return result;
}

/// Cells that fill space and have a material, or a body of points.
bool has_tissue_in_space(const Model& model) {
  return is_body_of_points(model) || std::ranges::any_of(model.cells, [&](const Cell& cell) {
           return is_solid(model.dimension, cell) && cell.material >= 0;
         });
}

std::string how_to_get_bases(const Model& model, BaseSelection bases) {
  const std::string least =
      model.dimension == 3 ? "3 neighbours that are not on a line" : "2 neighbours at different places";
  if (bases == BaseSelection::all) return "one takes " + least + ". Give more neighbours";
  return "one takes " + least +
         ", and must pass the thresholds. Give more neighbours, loosen min_quality and max_barycentric";
}

void treat_sparse(const Model& model, std::vector<Index> sparse, TopologyTextures& topology) {
  std::erase_if(sparse, [&](Index i) { return model.mass[i] == 0.0; });  // removed
  if (sparse.empty()) return;
  const std::vector<char> without_tissue = particles_without_tissue(model);
  std::erase_if(sparse, [&](Index i) { return without_tissue[i] != 0; });
  if (sparse.empty()) return;
  const bool averaged = topology.options.law == Law::particle_averaged || topology.options.law == Law::walls;
  switch (topology.options.on_sparse) {
    case SparseParticle::error:
      throw Error(
          ErrorCode::invalid_model,
          particle_names(model, sparse) + (sparse.size() == 1 ? " has" : " have") +
              (averaged ? " no volume: put each in a cell that has a material (set_material), or set on_sparse to free"
                        : " no base: " + how_to_get_bases(model, topology.options.bases) +
                              ", or set on_sparse to springs or free"));
    case SparseParticle::springs:
      require(!averaged, particle_names(model, sparse) + (sparse.size() == 1 ? " is" : " are") +
                             " in no cell that has a material, and springs would need a stiffness in N/m. Set "
                             "on_sparse to free, or remove these particles");
      topology.springs = springs_around(model, sparse);
      break;
    case SparseParticle::free:
      break;
  }
}

void pack_neighbours(const RaggedList& rows, TopologyTextures& topology) {
  topology.neighbour_count = static_cast<Index>(rows.entry.size());
  topology.neighbours = rows.entry;
  topology.alpha.assign(topology.neighbours.size(), 0.0);
  for (Index i = 0; i < rows.rows(); ++i) {
    topology.index[i].neighbour_count = rows.size(i);
    topology.index[i].first_neighbour = rows.offset[i];
  }
}

void pack_bases(const BaseTable& table, TopologyTextures& topology) {
  topology.base_count = static_cast<Index>(table.base.size());
  topology.bases.reserve(table.base.size());
  topology.lambda.reserve(table.base.size());
  for (const RestBase& base : table.base) {
    topology.bases.push_back({base.vertex, base.beta});
    topology.lambda.push_back(base.lambda);
  }
  topology.weight = table.weight;
  topology.stiffness = table.stiffness;
  for (Index i = 0; i < topology.particle_count; ++i) {
    topology.index[i].base_count = static_cast<Index>(table.size(i));
    topology.index[i].first_base = static_cast<Index>(table.offset[i]);
  }
}

// alpha_ij = sum over t of w_t lambda_t at j.
void fill_alpha(TopologyTextures& topology) {
  std::vector<Index> row_of(static_cast<std::size_t>(topology.particle_count), none);
  for (Index i = 0; i < topology.particle_count; ++i) {
    const IndexTexel& texel = topology.index[i];
    for (Index r = texel.first_neighbour; r < texel.first_neighbour + texel.neighbour_count; ++r) {
      row_of[topology.neighbours[r]] = r;
    }
    for (Index t = texel.first_base; t < texel.first_base + texel.base_count; ++t) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const Index vertex = topology.bases[t].vertex[corner];
        if (vertex >= 0) topology.alpha[row_of[vertex]] += topology.weight[t] * topology.lambda[t][corner];
      }
    }
  }
}

// A corner of a transposed list must be a 32-bit number.
Index checked_rows(std::size_t rows, int corners, const char* table) {
  const std::size_t most =
      static_cast<std::size_t>(std::numeric_limits<Index>::max()) / static_cast<std::size_t>(corners);
  require(rows <= most, "the table of " + std::string(table) + " has " + std::to_string(rows) + " rows; " +
                            std::to_string(most) + " fit 32-bit numbers. Use fewer particles or cells");
  return static_cast<Index>(rows);
}

void fill_transposes(TopologyTextures& topology) {
  const TopologyOptions& options = topology.options;
  const Index n = topology.particle_count;
  if (topology.base_count > 0) {
    if (options.reaction == Reaction::averaged || options.reaction == Reaction::conservative) {
      topology.base_of = transpose(n, topology.base_count, 3,
                                   [&](Index row, Index corner) { return topology.bases[row].vertex[corner]; });
      topology.base_owner.resize(static_cast<std::size_t>(topology.base_count));
      for (Index i = 0; i < n; ++i) {
        std::fill_n(topology.base_owner.begin() + topology.index[i].first_base, topology.index[i].base_count, i);
      }
    } else {
      topology.neighbour_of =
          transpose(n, topology.neighbour_count, 1, [&](Index row, Index) { return topology.neighbours[row]; });
      topology.neighbour_owner.resize(static_cast<std::size_t>(topology.neighbour_count));
      for (Index i = 0; i < n; ++i) {
        std::fill_n(topology.neighbour_owner.begin() + topology.index[i].first_neighbour,
                    topology.index[i].neighbour_count, i);
      }
    }
  }
  if (!topology.springs.empty()) {
    topology.spring_of = transpose(n, checked_rows(topology.springs.size(), 2, "springs"), 2,
                                   [&](Index row, Index end) { return topology.springs[row].end[end]; });
  }
  if (!topology.volumes.empty()) {
    topology.volume_of = transpose(n, checked_rows(topology.volumes.size(), 4, "volume terms"), 4,
                                   [&](Index row, Index corner) { return topology.volumes[row].vertex[corner]; });
  }
}

TopologyTextures start(const Model& model, const TopologyOptions& options) {
  TopologyTextures topology;
  topology.options = options;
  if (!options.law) {
    topology.options.law = model.materials.empty()                           ? Law::shape_memory
                           : has_walls(model) && !has_tissue_in_space(model) ? Law::walls
                                                                             : Law::particle_averaged;
  }
  topology.dimension = model.dimension;
  topology.model = model_fingerprint(model);
  topology.particle_count = model.particle_count();
  topology.index.resize(model.rest.size());
  topology.rest = model.rest;
  topology.mass = model.mass;
  return topology;
}

BaseTable no_bases(const Model& model) {
  BaseTable table;
  table.offset.assign(model.rest.size() + 1, 0);
  table.stiffness = model.stiffness;
  return table;
}

void build_averaged(const Model& model, TopologyTextures& topology) {
  const TopologyOptions& options = topology.options;
  require(!model.materials.empty(), "Law::particle_averaged needs a material: call set_material, or use another law");
  require(!has_walls(model) || has_tissue_in_space(model),
          "a body of walls alone needs Law::walls; leave TopologyOptions::law empty");
  require(
      options.reaction == Reaction::conservative,
      "a material needs Reaction::conservative: the other reactions have no stiffness against uniform strain inside "
      "a body. Use it, or clear Model::materials and set stiffness in N/m");
  require(options.volume_stiffness == 0.0,
          "volume_stiffness is for models without a material; with one it follows from Poisson's ratio. Set it to 0");
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    const Cell& cell = model.cells[row];
    if (!is_solid(model.dimension, cell) || cell.material < 0 || model.materials[cell.material].thickness == 0.0)
      continue;
    throw Error(ErrorCode::invalid_model,
                cell_label(model, row) + " fills space, but its material has a thickness, which is for triangles");
  }
  add_averaged_terms(model, topology);
  topology.walls = wall_terms(model);
  treat_sparse(model, particles_without_volume(topology), topology);
  topology.notes = notes_on_stretched_cells(model);
}

void build_walls(const Model& model, TopologyTextures& topology) {
  const TopologyOptions& options = topology.options;
  require(has_walls(model),
          "Law::walls needs triangles whose material has a thickness: call make_wall or set_material");
  require(options.reaction == Reaction::conservative && options.volume_stiffness == 0.0 &&
              options.strain_energy == StrainEnergy::neo_hookean,
          "Law::walls takes no other reaction, volume_stiffness or strain_energy than the defaults; leave them");
  require(!has_tissue_in_space(model),
          "Law::walls is for walls alone, but volume cells of the model have a material; leave TopologyOptions::law "
          "empty");
  topology.walls = wall_terms(model);
  treat_sparse(model, particles_without_volume(topology), topology);
}

BaseTable build_plain(const Model& model, TopologyTextures& topology) {
  const TopologyOptions& options = topology.options;
  require(model.materials.empty(),
          "springs and bases take their stiffness in N/m and cannot carry a material; clear Model::materials, or use "
          "Law::particle_averaged");
  if (options.volume_stiffness > 0.0) topology.volumes = volume_terms(model, options.volume_stiffness);
  if (options.law == Law::springs) {
    topology.springs = neighbour_springs(model);
    return no_bases(model);
  }
  BaseTable table = select_bases(model, options);
  treat_sparse(model, particles_without_base(table), topology);
  return table;
}

}  // namespace

TopologyTextures build_topology(const Model& model, const TopologyOptions& options) {
  validate(model);
  check_options(options);
  TopologyTextures topology = start(model, options);
  BaseTable table = no_bases(model);
  if (topology.options.law == Law::particle_averaged) {
    build_averaged(model, topology);
  } else if (topology.options.law == Law::walls) {
    build_walls(model, topology);
  } else {
    table = build_plain(model, topology);
  }
  pack_bases(table, topology);
  if (topology.base_count > 0) {
    pack_neighbours(model.neighbours, topology);
    fill_alpha(topology);
  }
  fill_transposes(topology);
  return topology;
}

TextureShape fit_texture(std::int64_t rows, int limit, const char* table) {
  if (limit < 1) {
    throw Error("the longest side of a texture is " + std::to_string(limit) + "; one has at least 1 x 1 texels");
  }
  const std::int64_t wanted = std::max<std::int64_t>(rows, 1);
  const std::int64_t widest = static_cast<std::int64_t>(std::bit_floor(static_cast<std::uint64_t>(limit)));
  std::int64_t width = 1;
  while (width < widest && width * width < wanted) width *= 2;
  const std::int64_t height = (wanted + width - 1) / width;
  if (height > limit) {
    throw Error(ErrorCode::not_supported,
                "the table of " + std::string(table) + " needs " + std::to_string(rows) + " rows; textures of up to " +
                    std::to_string(limit) + " texels a side hold " + std::to_string(widest * limit) +
                    " (widths are powers of two). Use fewer particles or neighbours, or a sparser base selection");
  }
  return {static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace phymul
