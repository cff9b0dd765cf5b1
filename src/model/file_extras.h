// SPDX-License-Identifier: MIT
//
// FileExtras: what a file carried beside the model, kept for messages and for writing back. No computation uses it.
// The public Model holds it as an opaque pointer.
#pragma once

#include <phymul/model.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace phymul {

/// What a PML file said of a particle's neighbourhood beside the neighbours.
struct NeighbourhoodFields {
  Index particle = -1;
  std::vector<Attribute> attributes;
  std::optional<Colour> colour;
  bool operator==(const NeighbourhoodFields&) const = default;
};

struct FileExtras {
  std::vector<Index> particle_index;                    ///< [N] or empty: number of each particle in the file
  std::vector<std::string> particle_name;               ///< [N] or empty
  std::vector<std::vector<Attribute>> particle_fields;  ///< [N] or empty: further attributes
  std::vector<Index> cell_index;  ///< numbers of the first cells in the file, -1: none; later cells have none
  // Of PML only.
  std::vector<Attribute> attributes;       ///< further attributes of the root element
  Component atom_list;                     ///< name, attributes and colour of the list of atoms; the rest is unused
  std::vector<Index> neighbourhood_index;  ///< [N] or empty: number of each particle's neighbourhood cell; -1: none
  std::vector<NeighbourhoodFields> neighbourhood_fields;  ///< those that have any, by increasing particle
  bool operator==(const FileExtras&) const = default;

  /// Shared, in the one form that equal extras have; null if there are none.
  std::shared_ptr<const FileExtras> share() &&;
};

const FileExtras& extras_of(const Model& model);  ///< empty ones if the model has none

/// Changes the extras of this model alone; other models may share them.
template <class Change>
void change_extras(Model& model, Change change) {
  FileExtras extras = extras_of(model);
  change(extras);
  model.extras = std::move(extras).share();
}

}  // namespace phymul
