// SPDX-License-Identifier: MIT
#include "file_extras.h"

namespace phymul {

std::shared_ptr<const FileExtras> FileExtras::share() && {
  while (!cell_index.empty() && cell_index.back() < 0) cell_index.pop_back();
  return *this == FileExtras{} ? nullptr : std::make_shared<const FileExtras>(std::move(*this));
}

const FileExtras& extras_of(const Model& model) {
  static const FileExtras empty;
  return model.extras ? *model.extras : empty;
}

Index Model::file_index(Index particle) const {
  const std::vector<Index>& index = extras_of(*this).particle_index;
  return index.empty() ? particle : index[particle];
}

Index Model::cell_file_index(Index cell) const {
  const std::vector<Index>& index = extras_of(*this).cell_index;
  return static_cast<std::size_t>(cell) < index.size() ? index[cell] : -1;
}

}  // namespace phymul
