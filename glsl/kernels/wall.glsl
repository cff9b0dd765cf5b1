// SPDX-License-Identifier: MIT
//
// A triangle of a wall (src/elastic/force_wall.h) as a difference from rest, exactly 0 there. T are its tangents at rest,
// orthonormal, H the mean gradient of displacements, F = T + H. In difference form, with q = s^2 - 1, e = J - 1 and
// z = J^2 f'(s) / (-2 s), which is (J / s^2)^2 while f is 1 / s^2:
//   stress = mu J^(-2/3) [(1 - z) I - z (cof(C) - I)],   C = F^T F,   1 - z = (q - e) (2 + q + e) / s^4
// Needs nothing but the words of the dialect.

struct WallFrame {
  real3 a1, a2;    // columns of F
  real3 normal;    // a1 x a2 over s, or over 0.03 where s is less
  real3 turn;      // normal less the one at rest
  real q, square;  // s^2 - 1 and s^2
  real held;       // s^2, at least 0.03^2
  real inverse;    // 1 / root(held)
};

KERNEL WallFrame wall_frame(real3 T1, real3 T2, real3 H1, real3 H2) {
  real one = literal(1.0f);
  real least = literal(0.0009f);
  real3 a1 = T1 + H1;
  real3 a2 = T2 + H2;
  real3 N = cross_product(T1, T2);
  real3 d = cross_product(H1, a2) + cross_product(T1, H2);
  real q = literal(2.0f) * inner_product(N, d) + inner_product(d, d);
  real square = one + q;
  real held = select(square > least, square, least);
  real root = square_root(held);
  real share = one / (root * (one + root));  // 1 / root less 1 is (1 - held) times this
  real inverse = (one + root) * share;
  real3 turn = inverse * d - (select(square > least, q, least - one) * share) * N;
  return WallFrame(a1, a2, N + turn, turn, q, square, held, inverse);
}

// f - 1, and z / J^2.
struct WallArea {
  real less, fall;
};

KERNEL WallArea wall_area(WallFrame now) {
  real inverse_square = now.inverse * now.inverse;
  real per_cube = literal(21.433470f);  // 1 / 0.36^3
  real far = per_cube * ((literal(1.08f) - literal(2.0f) * (now.held * now.inverse)) +
                         (now.held - now.square) * now.inverse) - literal(1.0f);
  return WallArea(select(now.square > literal(0.1296f), -(now.q * inverse_square), far),
                  select(now.square > literal(0.1296f), inverse_square * inverse_square, per_cube * now.inverse));
}

// J^(1/3) - 1 of plane stress. With y = J^(1/3) the stress across is 0 where R = y^5 e + c (J^2 f - |F|^2 / 2) is; trace:
// of C - I, halved; c = 2 mu / (3 K). Newton's method for R / y^4, which is nearly a straight line: four steps, the first
// from y = 1. Principal stretches of 0.4 to 2.5 leave 3e-6 of y for nu of -0.5 and above.
KERNEL real wall_swelling(real trace, real less, real c) {
  real one = literal(1.0f);
  real two = literal(2.0f);
  real three = literal(3.0f);
  real four = literal(4.0f);
  real f = one + less;
  real cf = c * f;
  real start = c * (less - trace);
  real w = -quotient(start, three + literal(6.0f) * cf - four * start);
  for (int k = 0; k < 3; ++k) {
    real y = one + w;
    real square = y * y;
    real cube = square * y;
    real e = w * (three + w * (three + w));
    real R = (square * cube) * e + (cf * (e * (two + e)) + start);
    real slope = (square * cube) * ((three * cube + literal(5.0f) * e) + (literal(6.0f) * cf) * y);
    w = w - quotient(R * y, slope - four * R);
  }
  return w;
}

// Derivatives of the membrane's energy by a1 . a1 / 2, a2 . a2 / 2 and a1 . a2.
struct WallStress {
  real S11, S22, S12;
  real swelling;  // J^(1/3) - 1
};

// shear: A t mu.
KERNEL WallStress wall_stress(WallFrame now, real3 T1, real3 T2, real3 H1, real3 H2, real shear, real compliance) {
  real one = literal(1.0f);
  real two = literal(2.0f);
  real half_ = literal(0.5f);
  real E11 = inner_product(T1, H1) + half_ * inner_product(H1, H1);
  real E22 = inner_product(T2, H2) + half_ * inner_product(H2, H2);
  real C12 = (inner_product(T1, H2) + inner_product(T2, H1)) + inner_product(H1, H2);
  WallArea area = wall_area(now);
  real w = wall_swelling(E11 + E22, area.less, compliance);
  real e = w * (literal(3.0f) + w * (literal(3.0f) + w));
  real J = one + e;
  real z = (J * J) * area.fall;
  real near_rest = ((now.q - e) * (two + now.q + e)) * area.fall;
  real rest = select(now.square > literal(0.1296f), near_rest, one - z);
  real scale = quotient(shear, (one + w) * (one + w));
  return WallStress(scale * (rest - two * (z * E22)), scale * (rest - two * (z * E11)), scale * (z * C12), w);
}

// By how much the membrane has stiffened along its shortest principal stretch, at a fixed J, over 4 mu at rest:
// J^(-2/3) (1 + 3 (J / s)^2 / stretch^2) / 4.
KERNEL real wall_stiffening(WallFrame now, WallStress stress) {
  real one = literal(1.0f);
  real y = one + stress.swelling;
  real size = inner_product(now.a1, now.a1) + inner_product(now.a2, now.a2);  // |F|^2
  real apart = size * size - literal(4.0f) * now.held;
  real per_shortest = (size + square_root(select(apart > literal(0.0f), apart, literal(0.0f)))) / (now.held * now.held);
  return literal(0.25f) * (one / (y * y) + literal(1.5f) * ((y * y) * (y * y)) * per_shortest);
}

// Derivatives of the energy by a1 and a2. by_normal: by the normal.
KERNEL void wall_pulls(WallFrame now, WallStress stress, real3 by_normal, OUT(real3) P1, OUT(real3) P2) {
  real along = select(now.square > literal(0.0009f), inner_product(now.normal, by_normal), literal(0.0f));
  real3 v = now.inverse * (by_normal - along * now.normal);
  P1 = (stress.S11 * now.a1 + stress.S12 * now.a2) + cross_product(now.a2, v);
  P2 = (stress.S12 * now.a1 + stress.S22 * now.a2) + cross_product(v, now.a1);
}
