// SPDX-License-Identifier: MIT
//
// A liver of 1.5 litres that programs make themselves. m; x to the patient's right, y to the front, z to the head
// (RAS).
#pragma once

#include <phymul/body.h>

/// A large right lobe and a flat left one that run into each other, hollow from below.
phymul::Solid liver();

/// Its surface, with triangles of about `spacing`, m.
phymul::Surface liver_surface(double spacing);
