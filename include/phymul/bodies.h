// SPDX-License-Identifier: MIT
//
// Several bodies in one model, and so in one solver: each with its own material, found by its name.
#pragma once

#include <phymul/model.h>
#include <phymul/scene.h>

#include <span>
#include <string>
#include <vector>

namespace phymul {

struct TopologyTextures;

struct NamedBody {
  std::string name;  ///< group of all its particles; with '/' before the name of each of its groups: "liver/x0"
  const Model* model = nullptr;
};

/// All bodies as one model, particles and cells in their order, body after body. Spare particles (with_spare_particles)
/// come after those of all bodies, and a cut of any body uses them. Nothing joins the bodies: no neighbour list, cell
/// or base crosses from one to another, so each moves as it would alone (to the last bit in "reference", unless forces
/// are clamped: SolverOptions::max_displacement_per_step is of the mean spacing). File indices and what only a file
/// knows stay behind: loads go by name or row. Throws Error for a name that is empty or taken, is "Bodies" or has a
/// '/', for bodies of different dimensions, for some with and some without a material, and for a model that is not
/// valid.
Model merge_models(std::span<const NamedBody> bodies);

Model moved(Model model, const Vec3& by);  ///< its rest shape elsewhere, m

/// A load of a body by itself, for the model it was merged into; `first`: the row of the body's first particle there.
Load for_merged(Load load, Index first);

/// Particles that neighbours and cells hold together; where cells are cut or removed, cells alone. Faces and edges of a
/// mesh file that lie on cells of tissue hold nothing. Particles all of whose cells are removed are in none.
struct ConnectedBody {
  std::string name;              ///< the shortest one of a group of just these particles; empty: there is none
  std::vector<Index> particles;  ///< sorted
  std::vector<Index> cells;      ///< those that hold it together: rows of Model::cells, ascending
  double volume = 0.0;           ///< m^3 (2-D: m^2), at rest; walls by their thickness
};
std::vector<ConnectedBody> connected_bodies(const Model& model);  ///< by first particle

/// Largest stable step of each connected body by itself, at rest; that of the model is the smallest of them.
struct BodyLimit {
  std::string name;          ///< as ConnectedBody::name
  Index first = 0;           ///< its first particle
  double stable_step = 0.0;  ///< s
};
std::vector<BodyLimit> body_limits(const Model& model, const TopologyTextures& topology, double damping_factor = 1.0);

/// "organ" sets the stable step of 1.2e-4 s; the others' are ...: a sentence for a person.
std::string describe(std::span<const BodyLimit> limits);

}  // namespace phymul
