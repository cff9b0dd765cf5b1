// SPDX-License-Identifier: MIT
#include <phymul/solver.h>

#include <cstdio>

namespace phymul {

std::string StepReport::message() const {
  char text[1024];
  int length = 0;
  switch (status) {
    case StepStatus::ok:
      length = std::snprintf(text, sizeof text, "%s %d steps to t = %.6g s, residual %.3g N, speed %.3g m/s%s%s%s%s",
                             to_rest && !at_rest ? "not at rest after" : "ok:", steps, time, residual, max_speed,
                             at_rest ? ", at rest" : "", stopped ? "; stopped by SolverOptions::progress" : "",
                             beyond_limit ? "; the step is beyond the stable step" : "",
                             force_clamped ? "; elastic forces were clamped, the body was far out of shape" : "");
      if (collapsed >= 0) {
        length += std::snprintf(
            text + length, sizeof text - static_cast<std::size_t>(length),
            "; a base of particle %d has collapsed and has no direction: move some of its particles apart",
            static_cast<int>(collapsed));
      }
      if (folded >= 0) {
        std::snprintf(text + length, sizeof text - static_cast<std::size_t>(length),
                      "; cell %d is flat or inside out: the body rests folded, which is not its rest shape",
                      static_cast<int>(folded));
      }
      break;
    case StepStatus::invalid_step:
      std::snprintf(text, sizeof text, "invalid_step: dt = %g s: %s; nothing was done", dt, cause);
      break;
    case StepStatus::unstable_step:
      std::snprintf(
          text, sizeof text,
          "unstable_step: dt = %.6g s is above the stable step %.6g s of this body at rest; nothing was done. "
          "Use at most half of it, or UnstableStep::allow",
          dt, stable_step);
      break;
    case StepStatus::not_finite:
      std::snprintf(text, sizeof text,
                    "not_finite: particle %d ran away (a million times the wave speed, or not a number) after t = %.6g "
                    "s (step %d of this call, "
                    "dt = %.6g s, stable step at rest %.6g s); the state at that time is kept. Likely cause: %s",
                    static_cast<int>(particle), time, steps + 1, dt, stable_step, cause);
      break;
    case StepStatus::not_supported:
      std::snprintf(text, sizeof text, "not_supported: %s; nothing was done", cause);
      break;
    case StepStatus::device_lost:
      std::snprintf(text, sizeof text, "device_lost: the device went away after t = %.6g s", time);
      break;
    case StepStatus::needle_full:
      std::snprintf(text, sizeof text,
                    "needle_full: a needle's hole is longer, or the tissue around it denser, than the device has room "
                    "for after t = %.6g s (step %d of this call); the state at that time is kept. %s",
                    time, steps + 1, cause);
      break;
    case StepStatus::volume_lost:
      std::snprintf(text, sizeof text,
                    "volume_lost: the volume of the closed surface at particle %d could not be restored after t = %.6g "
                    "s (step %d of this call); the state at that time is kept. Likely cause: %s",
                    static_cast<int>(particle), time, steps + 1, cause);
      break;
  }
  return text;
}

}  // namespace phymul
