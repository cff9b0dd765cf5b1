// SPDX-License-Identifier: MIT
//
// Per domain of a material that dissipates, the strains that it keeps for the next step. Needs domain_gradient.glsl,
// dissipation.glsl and kept_strains.glsl.

void strains_row(int d) {
  ivec4 rows = fetch_ivec4(domain_range, domain_range_place, d);
  vec3 spread;
  keep_strains(dissipated(d, domain_gradient(d, rows, fetch_vec4(domain_law, domain_law_place, LAW_TEXELS * d).x, spread)));
}

PASS_MAIN(strains_row)
