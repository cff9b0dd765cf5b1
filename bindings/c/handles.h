// SPDX-License-Identifier: MIT
//
// What the handles of phymul_c.h hold, and what all its functions share: checks of arguments, and no exception that
// gets out.
#pragma once

#include <phymul/phymul.h>

#include <array>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "phymul_c.h"

struct phymul_surface {
  phymul::Surface surface;
};

struct phymul_body {
  phymul::Model model;
  // What was handed out. Rest positions too: set_material() moves those of the model to other memory.
  phymul::VecList rest{};
  std::vector<int32_t> types{}, first{}, particles{};
  std::vector<std::array<phymul::Index, 3>> triangles{};
  std::vector<phymul::Index> group{};
  std::string notes{}, groups{};
  std::vector<int32_t> parts{};
  std::vector<double> volumes{};
};

struct phymul_simulation {
  phymul::Simulation simulation;
  phymul::VecList positions{}, velocities{}, forces{};  // [N] from the first call on: their memory never moves
  std::string message{}, warnings{}, backend{}, body_types{};
  phymul::ThreadState thread{};  // the last one that was handed out
  std::vector<int32_t> broken{}, slides{};
  std::vector<phymul_knot> knots{};
  bool moved = false;  // particles may be elsewhere than at rest
};

struct phymul_snapshot {
  phymul::Snapshot snapshot;
};

struct phymul_skin {
  phymul::Skin skin;
  std::vector<std::array<phymul::Index, 3>> triangles;
  phymul::VecList points{}, normals{};
};

struct phymul_jaws {
  phymul::Jaws jaws;
};

struct phymul_plan {
  phymul::Plan plan;
  std::string report;
  std::vector<phymul_trial> trials;
};

namespace phymul::c {

/// What has no ErrorCode: a step that failed, a builder that ends the planning. It is no std::exception, because plan()
/// takes those of a builder for a candidate that cannot be had.
struct Failure {
  phymul_status status;
  std::string message;
};

std::string& last_error();  ///< of this thread

/// Turns the exception that is being handled into a status and the text of last_error().
phymul_status status_of_exception() noexcept;

template <class Function>
phymul_status guarded(Function&& function) noexcept {
  try {
    function();
    return PHYMUL_OK;
  } catch (...) {
    return status_of_exception();
  }
}

/// What a pointer points to. Throws Error for null.
template <class T>
T& need(T* pointer, const char* what) {
  if (!pointer) throw Error(std::string("expected ") + what + ", got NULL");
  return *pointer;
}

/// Throws Error for a negative count, and for null unless the count is 0.
template <class T>
std::span<const T> list(const T* data, int32_t count, const char* what) {
  if (count < 0 || (count > 0 && !data))
    throw Error(std::string("expected ") + what + " and their number, 0 or more; got " +
                (data ? "the number " + std::to_string(count) : std::string("NULL")));
  return {data, static_cast<std::size_t>(count)};
}

inline Vec3 vector(const double* xyz, const char* what) {
  need(xyz, what);
  return {xyz[0], xyz[1], xyz[2]};
}

/// A plane, behind that of a front or, without one, everywhere.
inline CutSurface cut_behind(const double* point, const double* normal, const double* front,
                             const double* front_normal) {
  CutSurface cut = cut_plane(vector(point, "a point"), vector(normal, "a normal"));
  if (front || front_normal)
    cut.front =
        cut_plane(vector(front, "a point of the front"), vector(front_normal, "a normal of the front")).distance;
  return cut;
}

VecList vectors(const double* data, int32_t count, const char* what);
std::vector<std::array<Index, 3>> triples(const int32_t* data, int32_t count, const char* what);

inline const double* doubles(const VecList& list) {
  return list.empty() ? nullptr : list.front().data();
}

inline void store(const Vec3& from, double* to) {
  std::copy_n(from.data(), 3, to);
}

/// Size of a struct where the program was compiled, which is its first member. Throws Error for null, for a size below
/// that of the first member, and for one above that of this version's struct.
template <class Struct>
uint32_t size_of(const Struct* given, const char* what) {
  const uint32_t size = need(given, what).size;
  if (size < sizeof(uint32_t) || size > sizeof(Struct))
    throw Error(std::string("expected ") + what + " whose size is sizeof of the struct, at most " +
                std::to_string(sizeof(Struct)) + " in this version; got the size " + std::to_string(size));
  return size;
}

/// Options of a program: what lies beyond their size is 0.
template <class Options>
Options options_of(const Options* given, const char* what) {
  Options options{};
  std::memcpy(&options, given, size_of(given, what));
  return options;
}

inline Material material_of(const phymul_material* given) {
  const phymul_material from = options_of(given, "a material");
  return {.young = from.young,
          .poisson = from.poisson,
          .density = from.density,
          .retardation_time = from.retardation_time,
          .relaxation_strength = from.relaxation_strength,
          .relaxation_time = from.relaxation_time,
          .thickness = from.thickness,
          .stiffening = {from.stiffening[0], from.stiffening[1], from.stiffening[2], from.stiffening[3]}};
}

/// A result for a program, as far as its struct has room. To be made before anything happens.
template <class Result>
class Place {
 public:
  Place(Result* to, const char* what) : to_(to), size_(size_of(to, what)) {}
  void fill(Result result) const {
    result.size = size_;
    std::memcpy(to_, &result, size_);
  }

 private:
  Result* to_;
  uint32_t size_;
};

/// The same of a result that the program may not want.
template <class Result>
std::optional<Place<Result>> place_if_wanted(Result* to, const char* what) {
  return to ? std::optional<Place<Result>>(std::in_place, to, what) : std::nullopt;
}

/// Hands out a list: both outputs are there before one changes.
template <class T>
void hand_out(const T* data, std::size_t count, const T** list, int32_t* number, const char* what) {
  need(list, what);
  need(number, "a place for the number") = static_cast<int32_t>(count);
  *list = data;
}

/// Throws Error unless the number is one of an enumeration of `count` values from `first` on.
void require_kind(int32_t kind, int32_t first, int32_t count, const char* what);

/// Throws Error unless it is one line, not empty.
void require_name(const char* name, const char* what);

std::string lines(const std::vector<std::string>& sentences);

}  // namespace phymul::c
