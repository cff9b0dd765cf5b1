// SPDX-License-Identifier: MIT
//
// Bodies whose cells are so much longer than thick that no stabiliser makes them bend as they should.
#pragma once

#include <phymul/model.h>

#include <string>
#include <vector>

namespace phymul {

/// A sentence for each connected body whose cells are more than 3 times as long as thick
/// (docs/measurements/accuracy.md, "Stretched cells"). How long over how thick: of the vertices' root mean square
/// distances from their cell's middle the longest over the shortest, meant over the cells around a particle, so that
/// slivers among good cells do not count, and over the volume.
std::vector<std::string> notes_on_stretched_cells(const Model& model);

}  // namespace phymul
