// SPDX-License-Identifier: MIT
//
// Per kept volume, how far its particles go. Needs kept_tables.glsl and volume_root.glsl.

uniform int kept_first_total;  // the volumes' sums over all their facets, one after another
OF_STEP(int, kept_step);       // of the batch, from 1

RESULT(0, vec4, kept_root);

void root_row(int volume) {
  vec4 total = (1.0 / 6.0) * fetch_load_vec4(kept_sums, kept_sums_place, kept_first_total + volume);
  vec4 law = kept_law(volume, 1);
  float missing = law.x - total.x;
  VolumeRoot root = root_of_cubic(total.yzw, missing);
  float lost = kept_step == 1 ? 0.0 : fetch_load_vec4(kept_roots, kept_roots_place, volume).y;
  // Where nothing is free to make up for it, what is rounded is not a loss; nor is what is no number.
  bool kept = root.found || !(abs(missing) > law.y);
  if (!kept && lost == 0.0) lost = float(kept_step);
  kept_root = vec4(root.found ? kept_law(volume, 0).x * root.s : 0.0, lost, 0.0, 0.0);
}

PASS_MAIN(root_row)
