// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

#include <cstddef>
#include <string>

namespace phymul {

/// What messages call a cell: "cell 2 (HEXAHEDRON, file index 7) \"name\"", by its row.
std::string cell_label(const Model& model, std::size_t row);

}  // namespace phymul
