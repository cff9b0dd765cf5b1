// SPDX-License-Identifier: MIT
//
// The loads of a scene in the arrays the moving kernel reads. A scene without forces, or without imposed positions, has
// no array for them; constant loads are written once.
#pragma once

#include <phymul/load_frame.h>
#include <phymul/scene.h>

#include "packed_body.h"

namespace phymul::cpu {

class PackedLoads {
 public:
  PackedLoads(const Scene& scene, const PackedBody& body);

  /// Forces and accelerations, at the old time. `changed`: null, or [SleepBlocks] to be set to 1 for the blocks of
  /// particles whose force is another than at the last call.
  void act_at(const Scene& scene, double time, std::uint8_t* changed);
  void impose_at(const Scene& scene, double time, std::uint8_t* changed);  ///< positions, at the new time; likewise

  bool imposes() const { return !target_.empty(); }
  void point(simd::Move& move) const;
  Vec3 gravity() const { return gravity_; }

 private:
  /// Sums of value[mode] * vector over each particle that has any.
  class Sums {
   public:
    Sums() = default;
    Sums(const std::vector<Index>& offset, const std::vector<LoadModes::Part>& parts, const PackedBody& body);
    bool empty() const { return at_.empty(); }
    const char* data() const { return reinterpret_cast<const char*>(at_.data()); }
    void evaluate(const std::vector<double>& value, std::uint8_t* changed);

   private:
    struct Row {
      std::size_t quad;
      Index first, last;  // parts_
    };
    std::vector<Row> rows_;
    std::vector<LoadModes::Part> parts_;
    std::vector<double> evaluated_;  // the values of at_
    Floats at_;                      // [places][4] by quad
  };

  std::vector<LoadModes::Part> acceleration_;
  Vec3 steady_gravity_, gravity_;
  std::vector<double> value_;
  Sums force_, target_;
  Offsets fixed_;  // [places] or empty
};

}  // namespace phymul::cpu
