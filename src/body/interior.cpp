// SPDX-License-Identifier: MIT
#include "interior.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/place_text.h"
#include "root_between.h"

namespace phymul {

double SolidInterior::at(const Vec3& x) const {
  const double value = clipped_distance(solid_, x);
  if (std::isnan(value)) throw Error("make_body: the solid's distance is not a number at " + place_text(x));
  return value;
}

std::vector<char> PlaceInterior::inside(const CentredLattice& lattice) const {
  std::vector<char> in(lattice.points());
  for (std::size_t i = 0; i < in.size(); ++i) in[i] = contains(lattice.place(static_cast<Index>(i)));
  return in;
}

std::vector<char> PlaceInterior::inside(const VecList& places) const {
  std::vector<char> in(places.size());
  std::ranges::transform(places, in.begin(), [&](const Vec3& x) { return contains(x); });
  return in;
}

double SolidInterior::exit(const Vec3& in, const Vec3& out) const {
  return root_between([&](double share) { return at(share == 1.0 ? out : Vec3(in + share * (out - in))); });
}

double SolidInterior::volume(const CentredLattice& lattice, bool is_graded) const {
  const auto& n = lattice.count;
  // Parts of a graded lattice are finer than this one: there lines are as dense as a few samples allow.
  const double fine = is_graded ? std::cbrt(3e5 / (1.0 * n[0] * n[1] * n[2])) : 0.0;
  const int parts = static_cast<int>(std::clamp(fine, 4.0, 32.0));
  const double step = lattice.edge / parts;
  // Lines in rows and columns would see the sides of a box as steps: each row is shifted, and each column.
  const auto shift = [](int row) { return std::fmod(row * std::numbers::phi, 1.0); };
  double length = 0.0;  // of all lines inside, in steps
  for (int k = 0; k < parts * n[2]; ++k) {
    for (int j = 0; j < parts * n[1]; ++j) {
      const Vec3 start(-0.5, j + shift(k), k + shift(j));
      Vec3 last = lattice.origin + step * start;
      bool was_inside = false;  // the first and last points lie outside the solid's box
      for (int i = 0; i < parts * n[0]; ++i) {
        const Vec3 x = lattice.origin + step * (start + (i + 1) * Vec3::UnitX());
        const bool is_inside = at(x) < 0.0;
        if (is_inside && was_inside) length += 1.0;
        if (is_inside != was_inside) length += is_inside ? exit(x, last) : exit(last, x);
        was_inside = is_inside;
        last = x;
      }
    }
  }
  return length * step * step * step;
}

}  // namespace phymul
