// SPDX-License-Identifier: MIT
//
// Analytic bodies, for tests, benches and first steps. Lengths in m. Every body comes with cells, named groups
// and, unless changed afterwards, mass 1 kg and stiffness 1 N/m per particle (set_material gives real ones).
#pragma once

#include <phymul/model.h>

#include <cstdint>

namespace phymul {

/// Regular tetrahedron of four particles, each neighbour to all others. Groups: "base", "apex".
Model make_tetrahedron(double edge);

/// A box of nx * ny * nz hexahedra from the origin, (nx+1)(ny+1)(nz+1) particles, x fastest. `valence` is the
/// number of neighbours inside: 6 (faces), 14 (faces and corners), 18 (faces and edges) or 26 (all).
/// Groups: "x0", "x1", "y0", "y1", "z0", "z1" (the six sides). Throws Error for another valence.
Model make_block(const Vec3& size, int nx, int ny, int nz, int valence = 6);

/// A cylinder on the z axis from z = 0: `discs` discs of 1 + rings * sectors particles, wedges around the axis,
/// hexahedra outside; neighbours are cell edges. make_cylinder(0.010, 0.040, 3, 8, 11) has 275 particles, laid
/// out as the sample body cylinder_275.pml. Groups: "bottom", "top", "side".
Model make_cylinder(double radius, double length, int rings, int sectors, int discs);

/// Two-dimensional strip of nx * ny quads in the plane z = 0; neighbours are edges, and diagonals where `diagonals`.
/// Groups: "x0", "x1", "y0", "y1".
Model make_strip(double width, double height, int nx, int ny, bool diagonals = false);

/// An unstructured tetrahedral box: the lattice of make_block split into tetrahedra, its inner particles moved
/// at random by up to `jitter` spacings (surface particles stay on their side), so that no two tetrahedra are
/// alike. Each lattice cell is cut in six around a diagonal drawn at random per cell where conforming allows. No
/// tetrahedron has less than `least` of the volume it would have unmoved: 0.02 with a jitter of 0.45 makes slivers.
/// Neighbours: all pairs of each tetrahedron. Groups as make_block.
Model make_tetrahedral_block(const Vec3& size, int nx, int ny, int nz, double jitter, std::uint32_t seed,
                             double least = 0.1);

/// Moves every particle off its place by a uniform random vector of length up to `amount` spacings; neighbours and
/// cells stay. For the jittered bodies of tests and charts.
void jitter(Model& model, double amount, std::uint32_t seed);

}  // namespace phymul
