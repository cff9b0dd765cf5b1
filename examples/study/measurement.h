// SPDX-License-Identifier: MIT
//
// Measured displacements as CSV with the columns x,y,z,ux,uy,uz, m: where a point of the tissue is at rest, and how far
// it has moved.
#pragma once

#include <string>

#include "file.h"

/// `with_displacements`: false takes a file of x,y,z alone, too. Throws phymul::Error as "file:line: ...".
Measurement read_measurement(const std::string& path, bool with_displacements);

/// Throws phymul::Error where the file cannot be written.
void write_measurement(const std::string& path, const Measurement& measurement);
