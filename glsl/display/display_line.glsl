// SPDX-License-Identifier: MIT
//
// A line as a strip of constant width on the screen, six vertices: wide lines are not in every GL.
uniform vec2 viewport;      // pixels
uniform float half_width;   // pixels
uniform float lift;         // m towards the eye, so that a face does not hide its own edges

out float across;  // -1 ... 1
out float along;   // pixels from the first end
out float share;

vec4 lifted(vec3 point) {
  vec3 towards = projection[3][3] == 1.0 ? vec3(0.0, 0.0, 1.0) : normalize(-point);
  return projection * vec4(point + lift * towards, 1.0);
}

// Ends in the eye's axes. What is behind the near plane is cut off, for no pixel is there.
void draw_line(vec3 first, vec3 second, int vertex) {
  bool at_second = vertex == 1 || vertex == 2 || vertex == 4;
  float side = vertex == 2 || vertex == 4 || vertex == 5 ? 1.0 : -1.0;
  vec4 a = lifted(first);
  vec4 b = lifted(second);
  float a_depth = a.z + a.w;
  float b_depth = b.z + b.w;
  if (a_depth < 0.0 && b_depth > 0.0) a = mix(a, b, a_depth / (a_depth - b_depth));
  if (b_depth < 0.0 && a_depth > 0.0) b = mix(b, a, b_depth / (b_depth - a_depth));
  vec2 way = (b.xy / b.w - a.xy / a.w) * 0.5 * viewport;
  float pixels = length(way);
  vec2 unit = pixels > 0.0 ? way / pixels : vec2(1.0, 0.0);
  vec4 end = at_second ? b : a;
  across = side;
  along = at_second ? pixels : 0.0;
  vec2 offset = half_width * (side * vec2(-unit.y, unit.x) + (at_second ? 0.5 : -0.5) * unit);
  gl_Position = vec4(end.xy + offset * 2.0 / viewport * end.w, end.zw);
}

void draw_nothing() {
  across = 0.0;
  along = 0.0;
  share = 0.0;
  gl_Position = vec4(0.0, 0.0, 0.0, 1.0);  // all six in one point: no area
}
