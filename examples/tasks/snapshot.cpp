// SPDX-License-Identifier: MIT
//
// A simulation saved to a file, loaded from it, rewound in memory, and replayed from a recording.
#include <phymul/phymul.h>

#include <cstdio>

int main() try {
  phymul::Simulation sim(phymul::make_cylinder(0.010, 0.040, 3, 8, 11),
                         {.material = {.young = 5e3, .poisson = 0.45, .density = 1000}, .backend = "cpu"});
  sim.scene().fix("bottom").gravity({9.81, 0, 0});

  sim.keep_history(50);
  sim.record();
  sim.advance(0.1);
  sim.save("saved.phymul");
  sim.advance(0.1);
  const phymul::Snapshot later = sim.snapshot();
  sim.load("saved.phymul");  // back to 0.1 s
  sim.advance(0.1);          // the same steps again
  const bool same = sim.snapshot() == later;
  const bool rewound = sim.rewind(0.05);  // to the newest snapshot at or before 0.05 s
  const phymul::Recording recording = sim.recording();
  const phymul::Snapshot end = sim.snapshot();
  sim.replay(recording);  // all of it again
  const bool replayed = sim.snapshot() == end;

  std::printf("loaded: %s, rewound: %s, replayed: %s\n", same ? "yes" : "no", rewound ? "yes" : "no",
              replayed ? "yes" : "no");
  return same && rewound && replayed ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
