// SPDX-License-Identifier: MIT
//
// Stresses of materials that dissipate, and the strains that their domains keep: src/elastic/dissipation.h. STRAIN_RATE
// and STRAIN_BRANCH: the kinds that the body has. Needs tables.glsl and green_strain.glsl.

uniform float inverse_last_dt;  // 1/s, of the step before
uniform int strains_fresh;      // 1: a domain's strains are its own now, as after a reset

struct Dissipated {
  Columns stress;          // first Piola, Pa
  Symmetric rate, branch;  // strains to keep
};

// Two texels from `layer` on.
Symmetric kept_strain(int d, int layer, Symmetric now) {
  if (strains_fresh != 0) return now;
  return Symmetric(fetch_layer(strains, strains_place, d, layer).xyz,
                   fetch_layer(strains, strains_place, d, layer + 1).xyz);
}

Dissipated dissipated(int d, Columns H) {
  vec4 moduli = fetch_changing(dissipation, dissipation_place, 2 * d);
  Symmetric E = green_strain(H);
  Symmetric S = Symmetric(vec3(0.0), vec3(0.0));
  Symmetric branch = E;
#ifdef STRAIN_RATE
  Symmetric change = symmetric_minus(E, kept_strain(d, 0, E));
  S = symmetric_plus(S, inverse_last_dt, isotropic_stress(change, moduli.x, moduli.y));
#endif
#ifdef STRAIN_BRANCH
  Symmetric before = kept_strain(d, STRAIN_TEXELS - 2, E);
  Symmetric q = symmetric_minus(E, before);
  S = symmetric_plus(S, 1.0, isotropic_stress(q, moduli.z, moduli.w));
  branch = symmetric_plus(before, fetch_changing(dissipation, dissipation_place, 2 * d + 1).x, q);
#endif
  return Dissipated(first_piola(H, S), E, branch);
}
