// SPDX-License-Identifier: MIT
//
// The strains that a domain keeps, as dissipation.glsl reads them: of the rate, then of the branch.

#ifdef STRAIN_RATE
RESULT(0, vec4, rate_normal);
RESULT(1, vec4, rate_shear);
#define BRANCH_NORMAL 2
#define BRANCH_SHEAR 3
#else
#define BRANCH_NORMAL 0
#define BRANCH_SHEAR 1
#endif
#ifdef STRAIN_BRANCH
RESULT(BRANCH_NORMAL, vec4, branch_normal);
RESULT(BRANCH_SHEAR, vec4, branch_shear);
#endif

void keep_strains(Dissipated of) {
#ifdef STRAIN_RATE
  rate_normal = vec4(of.rate.normal, 0.0);
  rate_shear = vec4(of.rate.shear, 0.0);
#endif
#ifdef STRAIN_BRANCH
  branch_normal = vec4(of.branch.normal, 0.0);
  branch_shear = vec4(of.branch.shear, 0.0);
#endif
}
