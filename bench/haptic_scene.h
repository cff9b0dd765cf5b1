// SPDX-License-Identifier: MIT
//
// What a haptic loop moves: a soft block of about so many particles, lower face held, spacing 5 mm (warped between its
// faces, or not), with something in it that follows a hand.
#pragma once

#include <phymul/phymul.h>

#include <string>

namespace phymul::bench {

inline constexpr double tick = 1e-3;            // s
inline constexpr double haptic_spacing = 5e-3;  // m

class HapticScene {
 public:
  HapticScene(int particles, bool warped);
  virtual ~HapticScene() = default;
  HapticScene(const HapticScene&) = delete;
  HapticScene& operator=(const HapticScene&) = delete;

  const Model& model() const { return model_; }
  Scene& scene() { return scene_; }

  /// To where the hand is a tick later.
  virtual void drive(double date) = 0;
  /// What a device asks for after a tick; `state` is the solver's.
  virtual void answer(const Solver& solver, const State& state) = 0;
  virtual std::string what() const = 0;  ///< moves
  virtual void forget() {}               ///< what the answers so far were
  /// In all answers, for people; may be empty. Throws Error where they are of `seconds` s or more than one motion of
  /// the hand and what should have been touched was not: what is measured then is another scene.
  virtual std::string found(double seconds) const = 0;

 protected:
  Vec3 top(double x, double y) const;  ///< of the upper face, by shares of its sides

 private:
  Model model_;

 protected:
  Scene scene_;
};

/// The particles near the middle of the upper face, moved by three translations, one an axis.
class MovedParticles final : public HapticScene {
 public:
  MovedParticles(int particles, bool warped);
  void drive(double date) override;
  void drive_by_replacing(double date);  ///< the same by Scene::replace, for what that would cost
  void answer(const Solver&, const State&) override {}
  std::string what() const override;
  std::string found(double) const override { return {}; }

 private:
  std::size_t count_ = 0;
};

/// A ball of 2 cm that presses and rubs the upper face, and beside it, once a second, a needle that pierces it, goes
/// 50 mm down and comes out again (in a low body less deep).
class ProbeAndNeedle final : public HapticScene {
 public:
  ProbeAndNeedle(int particles, bool warped);
  void drive(double date) override;
  void answer(const Solver& solver, const State& state) override;
  std::string what() const override { return "a ball of 2 cm and a needle"; }
  void forget() override { seen_ = {}; }
  std::string found(double seconds) const override;

 private:
  struct Seen {
    double on_probe = 0.0, on_needle = 0.0, pulled = 0.0;  // N, greatest; pulled: least
    double deepest = 0.0;                                  // m of hole
    std::size_t nodes = 0;                                 // of it, at most
    int pressed = 0;                                       // particles under the ball, at most
    long answers = 0, inserted = 0;                        // ticks; with the needle in the body
    int entered = 0, left = 0;                             // times
  };
  ToolPose probe_at(double time) const;
  ToolPose needle_at(double time) const;

  double needle_deep_ = 0.0;  // m below the upper face at rest
  Seen seen_;
  bool in_ = false;
};

}  // namespace phymul::bench
