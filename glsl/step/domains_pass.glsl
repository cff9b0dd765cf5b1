// SPDX-License-Identifier: MIT
//
// Per domain of the particle-averaged law: the first Piola stress of its mean deformation, less the stabiliser's part,
// Pa, by columns. The fourth components are the force of its spread on its particle, N. Needs domain_gradient.glsl and
// an energy of kernels/; with DISSIPATES dissipation.glsl, whose stress is added. With SCALED_STIFFNESS all of it is
// multiplied by the domain's factor.

RESULT(0, vec4, domain_column_0);
RESULT(1, vec4, domain_column_1);
RESULT(2, vec4, domain_column_2);

void domain_row(int d) {
  ivec4 rows = fetch_ivec4(domain_range, domain_range_place, d);
  vec4 law = fetch_vec4(domain_law, domain_law_place, LAW_TEXELS * d);
  float p[energy_constants];
  for (int k = 0; k < energy_constants; ++k) {
    p[k] = fetch_vec4(domain_law, domain_law_place, LAW_TEXELS * d + (k + 2) / 4)[(k + 2) % 4];
  }
  vec3 spread;
  Columns H = domain_gradient(d, rows, law.x, spread);
  Columns Q = minus(energy_stress(H, p), scaled(law.y, H));
#if DIMENSION == 2  // nothing leaves the plane, not even by rounding
  Q.c0.z = 0.0;
  Q.c1.z = 0.0;
#endif
  domain_column_0 = vec4(Q.c0, spread.x);
  domain_column_1 = vec4(Q.c1, spread.y);
  domain_column_2 = vec4(Q.c2, spread.z);
#ifdef DISSIPATES
  Dissipated of = dissipated(d, H);
#if DIMENSION == 2
  of.stress.c0.z = 0.0;
  of.stress.c1.z = 0.0;
  of.stress.c2.z = 0.0;
#endif
  domain_column_0 = domain_column_0 + vec4(of.stress.c0, 0.0);
  domain_column_1 = domain_column_1 + vec4(of.stress.c1, 0.0);
  domain_column_2 = domain_column_2 + vec4(of.stress.c2, 0.0);
#ifdef SLICED  // fragments have a pass of their own for it: strains_pass.glsl
  keep_strains(of);
#endif
#endif
#ifdef SCALED_STIFFNESS
  float factor = fetch_load_float(stiffness_factor, stiffness_factor_place, d);
  domain_column_0 = factor * domain_column_0;
  domain_column_1 = factor * domain_column_1;
  domain_column_2 = factor * domain_column_2;
#endif
}

PASS_MAIN(domain_row)
