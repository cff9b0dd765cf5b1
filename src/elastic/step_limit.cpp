// SPDX-License-Identifier: MIT
#include <phymul/bodies.h>
#include <phymul/elasticity.h>
#include <phymul/error.h>
#include <phymul/step_limit.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <limits>

#include "dissipation.h"
#include "model/cell_geometry.h"
#include "scaled_tables.h"

namespace phymul {
namespace {

/// A vibration that moves more of the particles than this is the whole body's.
constexpr double local = 0.125;

double undamped_step(const TopologyTextures& topology, double largest) {
  return stable_step(topology, Spectrum{.largest = largest}, 1.0);
}

/// Kinetic energy of a vibration by particles, of sum 1. `shape` [3 N] in the coordinates of ScaledStiffness.
std::vector<double> shares(const Eigen::VectorXd& shape) {
  std::vector<double> share(static_cast<std::size_t>(shape.size() / 3));
  for (std::size_t i = 0; i < share.size(); ++i) {
    share[i] = shape.segment<3>(3 * static_cast<Eigen::Index>(i)).squaredNorm();
  }
  return share;
}

/// How many particles take part: 1 if all the energy is in one, n if n have as much each.
double taking_part(const std::vector<double>& share) {
  double squares = 0.0;
  for (const double s : share) squares += s * s;
  return 1.0 / squares;
}

LimitingPlace place_of(const Model& model, const std::vector<double>& share) {
  LimitingPlace place;
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    if (cell_edges(model.cells[c].type).empty() || model.cells[c].share == 0.0) continue;  // a list; removed
    double sum = 0.0;
    for (const Index i : model.cells[c].particles) sum += share[i];
    if (sum <= place.share) continue;
    place.share = sum;
    place.cell = static_cast<Index>(c);
    place.particles = model.cells[c].particles;
  }
  if (place.particles.empty()) {
    const auto most = std::ranges::max_element(share);
    place.share = *most;
    place.particles = {static_cast<Index>(most - share.begin())};
  }
  for (const Index i : place.particles) place.place += model.rest[i] / static_cast<double>(place.particles.size());
  return place;
}

// Extreme eigenvalues of M^-1 K: Lanczos works on the symmetric M^-1/2 K M^-1/2 (scaled_tables.h), Arnoldi on the
// same similarity transform of an unsymmetric K. Source: Golub & Van Loan, Matrix Computations, ch. 10.

using Vector = Eigen::VectorXd;

/// Arnoldi keeps every vector: as many as fit in this many bytes, within [12, 80].
constexpr double arnoldi_bytes = 4e8;

/// Of an upper Hessenberg matrix. Eigen::EigenSolver would reduce it to that form first, and takes far longer to
/// compile.
Spectrum spectrum_of(const Eigen::MatrixXd& hessenberg) {
  Spectrum found;
  const double scale = hessenberg.cwiseAbs().maxCoeff();
  if (scale == 0.0) return found;
  const Eigen::Index size = hessenberg.rows();
  const Eigen::MatrixXd scaled = hessenberg / scale;
  Eigen::RealSchur<Eigen::MatrixXd> schur(size);
  schur.computeFromHessenberg(scaled, scaled, false);
  const Eigen::MatrixXd T = schur.matrixT() * scale;
  for (Eigen::Index i = 0; i < size; ++i) {
    std::complex<double> value = T(i, i);
    if (i + 1 < size && T(i + 1, i) != 0.0) {  // a block of two rows on the diagonal: a conjugate pair
      const double half = 0.5 * (T(i, i) - T(i + 1, i + 1));
      const double most = std::max({std::abs(half), std::abs(T(i + 1, i)), std::abs(T(i, i + 1))});
      const double h = half / most;
      value = {T(i + 1, i + 1) + half, most * std::sqrt(std::abs(h * h + T(i + 1, i) / most * (T(i, i + 1) / most)))};
      ++i;
    }
    found.largest = std::max(found.largest, std::abs(value));
    found.most_negative = std::min(found.most_negative, value.real());
    found.largest_imaginary = std::max(found.largest_imaginary, std::abs(value.imag()));
  }
  return found;
}

Spectrum arnoldi(ScaledStiffness& A, const Vector& q) {
  const double vector_bytes = 8.0 * static_cast<double>(q.size());
  const auto steps = std::min<Eigen::Index>(
      q.size(), std::clamp<Eigen::Index>(static_cast<Eigen::Index>(arnoldi_bytes / vector_bytes), 12, 80));
  Eigen::MatrixXd basis(q.size(), steps + 1);
  Eigen::MatrixXd hessenberg = Eigen::MatrixXd::Zero(steps + 1, steps);
  basis.col(0) = q;
  Vector image(q.size());
  Eigen::Index used = steps;
  for (Eigen::Index step = 0; step < steps; ++step) {
    A.apply(basis.col(step), image);
    for (Eigen::Index k = 0; k <= step; ++k) {
      hessenberg(k, step) = basis.col(k).dot(image);
      image -= hessenberg(k, step) * basis.col(k);
    }
    const double beta = image.norm();
    // Stiffness over mass leaves the numbers: no step is small enough.
    if (!std::isfinite(beta)) return {.largest = std::numeric_limits<double>::infinity()};
    hessenberg(step + 1, step) = beta;
    if (beta <= 1e-12 * hessenberg.topLeftCorner(step + 1, step + 1).norm()) {
      used = step + 1;
      break;
    }
    basis.col(step + 1) = image / beta;
  }
  return spectrum_of(hessenberg.topLeftCorner(used, used));
}

}  // namespace

StepLimit describe_limit(const Model& model, const TopologyTextures& topology, int most_places,
                         std::span<const std::uint8_t> fixed) {
  const auto count = static_cast<std::size_t>(topology.particle_count);
  if (model.rest.size() != count || (!fixed.empty() && fixed.size() != count)) {
    throw Error("describe_limit: expected a model of " + std::to_string(count) +
                " particles, as the tables have, and as many fixed marks or none; got " +
                std::to_string(model.rest.size()) + " and " + std::to_string(fixed.size()));
  }
  const Reaction reaction = topology.options.reaction;
  if (topology.base_count > 0 && reaction != Reaction::conservative && reaction != Reaction::averaged) {
    throw Error(
        "describe_limit: the reactions full, shared and barycentric have no vibrations; expected conservative or "
        "averaged");
  }
  std::vector<std::uint8_t> held(fixed.begin(), fixed.end());
  held.resize(count, 0);
  StepLimit limit;
  for (int k = 0;; ++k) {
    ScaledStiffness A(topology, topology.rest, held);
    const Eigen::VectorXd start = A.start_vector();
    const bool moves = A.spacing() > 0.0 && !start.isZero(0.0);
    const Lanczos found = moves ? lanczos(A, start) : Lanczos{};
    limit.without = undamped_step(topology, found.spectrum.largest);
    if (k == 0) limit.stable_step = limit.without;
    if (k >= most_places || !(limit.without < std::numeric_limits<double>::infinity()) || limit.without == 0.0) break;
    const std::vector<double> share = shares(fastest_vibration(A, start, found));
    const auto free = std::ranges::count_if(held, [](std::uint8_t axes) { return axes != 7; });
    if (taking_part(share) > local * static_cast<double>(free)) break;
    LimitingPlace place = place_of(model, share);
    place.stable_step = limit.without;
    for (const Index i : place.particles) held[i] = 7;
    limit.places.push_back(std::move(place));
  }
  return limit;
}

std::string StepLimit::message() const {
  char text[320];
  if (places.empty()) {
    std::snprintf(text, sizeof text, "The stable step of %.3g s is set by the whole body: no single cell stands out.",
                  stable_step);
    return text;
  }
  const LimitingPlace& first = places.front();
  const std::string cell =
      first.cell < 0 ? "particle " + std::to_string(first.particles.front()) : "cell " + std::to_string(first.cell);
  std::snprintf(
      text, sizeof text,
      "The stable step of %.3g s is set by %s, at (%.3g, %.3g, %.3g) m, with %.0f %% of the fastest vibration's "
      "energy. Without %s it would be %.3g s.",
      stable_step, cell.c_str(), first.place.x(), first.place.y(), first.place.z(), 100.0 * first.share,
      places.size() == 1
          ? "it"
          : ("it and " + std::to_string(places.size() - 1) + (places.size() == 2 ? " other place" : " other places"))
                .c_str(),
      without);
  return text;
}

std::vector<BodyLimit> body_limits(const Model& model, const TopologyTextures& topology, double damping_factor) {
  std::vector<BodyLimit> limits;
  for (const ConnectedBody& body : connected_bodies(model)) {
    std::vector<std::uint8_t> fixed(model.rest.size(), 7);
    for (const Index i : body.particles) fixed[i] = 0;
    const Spectrum spectrum = estimate_spectrum(topology, topology.rest, fixed);
    limits.push_back({body.name, body.particles.front(), stable_step(topology, spectrum, damping_factor)});
  }
  return limits;
}

std::string describe(std::span<const BodyLimit> limits) {
  const auto least = std::min_element(limits.begin(), limits.end(), [](const BodyLimit& a, const BodyLimit& b) {
    return a.stable_step < b.stable_step;
  });
  if (least == limits.end()) return "there is no body";
  const auto named = [](const BodyLimit& limit) {
    return limit.name.empty() ? "the body of particle " + std::to_string(limit.first) : '"' + limit.name + '"';
  };
  char step[32];
  const auto seconds = [&](const BodyLimit& limit) {
    std::snprintf(step, sizeof step, "%.3g s", limit.stable_step);
    return std::string(step);
  };
  std::string text = named(*least) + " sets the stable step of " + seconds(*least);
  for (const BodyLimit& limit : limits) {
    if (&limit != &*least) text += ", " + named(limit) + " by itself allows " + seconds(limit);
  }
  return text;
}

Spectrum estimate_spectrum(const TopologyTextures& topology, std::span<const Vec3> position,
                           std::span<const std::uint8_t> fixed) {
  const auto count = static_cast<std::size_t>(topology.particle_count);
  if (position.size() != count || (!fixed.empty() && fixed.size() != count)) {
    throw Error("estimate_spectrum: expected " + std::to_string(count) +
                " positions and as many fixed marks or none, got " + std::to_string(position.size()) + " and " +
                std::to_string(fixed.size()));
  }
  for (Index i = 0; i < topology.particle_count; ++i) {
    if (!position[i].allFinite()) {
      throw Error("estimate_spectrum: the position of particle " + std::to_string(i) + " is not finite");
    }
  }
  ScaledStiffness A(topology, position, fixed);
  const Vector q = A.start_vector();
  if (A.spacing() == 0.0 || q.isZero(0.0)) return {};

  const Reaction reaction = topology.options.reaction;
  const bool symmetric =
      topology.base_count == 0 || reaction == Reaction::conservative || reaction == Reaction::averaged;
  if (symmetric) return lanczos(A, q).spectrum;
  Spectrum found = arnoldi(A, q);
  if (found.most_negative > -rigid_motion * found.largest) found.most_negative = 0.0;
  return found;
}

double stable_step(const Spectrum& spectrum, double damping_factor) {
  if (spectrum.largest <= 0.0) return std::numeric_limits<double>::infinity();
  return std::sqrt(2.0 * (1.0 + damping_factor) / spectrum.largest);
}

double stable_step(const TopologyTextures& topology, const Spectrum& spectrum, double damping_factor) {
  return largest_step(step_bound(topology, spectrum), damping_factor);
}

}  // namespace phymul
