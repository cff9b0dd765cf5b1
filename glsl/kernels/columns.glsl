// SPDX-License-Identifier: MIT
//
// Deformation gradients F = I + H, by columns.

KERNEL real3 times(Columns H, real3 t) {
  return t.x * H.c0 + t.y * H.c1 + t.z * H.c2;
}

KERNEL Columns scaled(real s, Columns A) {
  return Columns(s * A.c0, s * A.c1, s * A.c2);
}

KERNEL Columns minus(Columns A, Columns B) {
  return Columns(A.c0 - B.c0, A.c1 - B.c1, A.c2 - B.c2);
}

KERNEL Columns plus(Columns A, Columns B) {
  return Columns(A.c0 + B.c0, A.c1 + B.c1, A.c2 + B.c2);
}

// A + a (x) b
KERNEL Columns plus_outer(Columns A, real3 a, real3 b) {
  return Columns(A.c0 + b.x * a, A.c1 + b.y * a, A.c2 + b.z * a);
}

KERNEL real squared_norm(Columns A) {
  return inner_product(A.c0, A.c0) + inner_product(A.c1, A.c1) + inner_product(A.c2, A.c2);
}

KERNEL Columns plus_identity(Columns H) {
  real one = literal(1.0f);
  return Columns(real3(H.c0.x + one, H.c0.y, H.c0.z), real3(H.c1.x, H.c1.y + one, H.c1.z),
                 real3(H.c2.x, H.c2.y, H.c2.z + one));
}

KERNEL Columns cofactor(Columns H) {
  return Columns(cross_product(H.c1, H.c2), cross_product(H.c2, H.c0), cross_product(H.c0, H.c1));
}

// How F = I + H differs from the identity, without the cancellation that I + H would bring.
struct Change {
  Columns cof;  // cof(F) - I = tr(H) I - H^T + cof(H)
  real trace, minors, determinant;  // of H; det(F) - 1 is their sum
};

// det(F) - 1
KERNEL real volume_change(Change change) {
  return change.trace + change.minors + change.determinant;
}

// Sums that a compiler could shorten ((a + b + c) - a) are written out: not all of them keep to the text inside
// functions.
KERNEL Change change_of(Columns H) {
  Columns C = cofactor(H);
  real xy = H.c0.x + H.c1.y;
  real trace = xy + H.c2.z;
  real minors = C.c0.x + C.c1.y + C.c2.z;
  return Change(Columns(C.c0 + real3(H.c1.y + H.c2.z, -H.c1.x, -H.c2.x), C.c1 + real3(-H.c0.y, H.c0.x + H.c2.z, -H.c2.y),
                        C.c2 + real3(-H.c0.z, -H.c1.z, xy)),
                trace, minors, inner_product(H.c0, C.c0));
}
