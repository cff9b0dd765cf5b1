// SPDX-License-Identifier: MIT
//
// Impulses on the nodes of a needle's hole within their limits: NeedlePath::settle of src/cpu, in its order. Drawn only, a
// row for each node: every fragment goes through all nodes, as many sweeps as a renderer has loops for, and tells of its
// own. Needs needle_sweeps.glsl,
// and needle_bent.glsl where BENDING is defined.

STORED(settled_sides, settled_sides_place);      // of the sweeps before: needle_settle_pass.glsl
STORED(settled_motions, settled_motions_place);
STORED(needle_twists, needle_twists_place);  // needle_twist_pass.glsl
uniform int first_sweep, end_sweep;

RESULT(0, vec4, side_row);     // sideways and along the shaft toward the hub, N s
RESULT(1, vec4, motion_row);   // m/s; forward by the tip, N s
RESULT(2, vec4, impulse_row);  // of all, N s; 1 where the needle touches. Between sweeps of a shaft that
                               // bends: m, off it
RESULT(3, vec4, node_end_row);  // m along the shaft; 1 where it slides; how many particles are touched; 1 +
                                // its row among those held sideways by a shaft that bends

void read_nodes() {
  for (int k = 0; k < node_count; ++k) {
    node_place[k] = fetch_changing(needle_places, needle_places_place, k);
    float ease = coupling(k, k).w;
    if (first_sweep == 0) {
      node_motion[k] = vec4(fetch_changing(needle_motions, needle_motions_place, k).xyz, ease);
      node_side[k] = vec4(0.0);
    } else {
      vec4 motion = fetch_changing(settled_motions, settled_motions_place, k);
      node_motion[k] = vec4(motion.xyz, ease);
      node_side[k] = fetch_changing(settled_sides, settled_sides_place, k);
      pushed = motion.w;
    }
  }
}

void take(int k) {
  own_place = node_place[k].xyz;
  own_motion = node_motion[k].xyz;
  own_ease = node_motion[k].w;
  own_limit = node_limit[k];
  own_side = node_side[k].xyz;
  own_rubbed = node_side[k].w;
  own_pushed = is_last(k) ? pushed : 0.0;
}

void give(int k, vec3 impulse) {
  node_side[k] = vec4(own_side, own_rubbed);
  if (is_last(k)) pushed = own_pushed;
  push_nodes(k, impulse);
}

void push_forward() {
  int last = node_count - 1;
  if (through || node_motion[last].w == 0.0) return;
  take(last);
  give(last, push_ahead());
}

void go_through(bool bends) {
  for (int k = 0; k < node_count; ++k) {
    if (node_motion[k].w == 0.0) continue;
    take(k);
    give(k, own_impulse(k, coupling(k, k).xyz, bends));
  }
}

void settle() {
#ifdef BENDING
  if (bending_stiffness > 0.0) {  // from where a sweep holds the nodes sideways to where the next one does
    if (first_sweep > 0) {
      take_holds();
      go_through(true);
    }
    if (first_sweep < sweeps) push_forward();
    return;
  }
#endif
  for (int sweep = first_sweep; sweep < end_sweep; ++sweep) {
    push_forward();
    go_through(false);
  }
}

void settle_row(int k) {
  begin_needle();
  if (k >= node_count) discard;
  begin_motion();
  pushed = 0.0;
  read_nodes();
  share_out_length();
  for (int node = 0; turned != 0.0 && node < node_count; ++node) {
    node_limit[node] *= fetch_changing(needle_twists, needle_twists_place, node).w;
  }
#ifdef BENDING
  held_count = 0;
  if (bending_stiffness > 0.0) read_held();
#endif
  settle();
  take(k);
  bool touches = on_shaft(k) || own_pushed > 0.0;
  side_row = vec4(own_side, own_rubbed);
  motion_row = vec4(own_motion, pushed);
  impulse_row = vec4(own_side + (own_rubbed - own_pushed) * end_axis, touches ? 1.0 : 0.0);
  bool slides = own_limit > 0.0 && abs(own_rubbed) >= own_limit;
  node_end_row = vec4(node_place[k].w, slides ? 1.0 : 0.0, touches ? float(around(k)) : 0.0, 0.0);
#ifdef BENDING
  for (int row = 0; row < held_count; ++row) {
    if (held_node[row] == k) node_end_row.w = float(row + 1);
  }
  if (bending_stiffness > 0.0 && first_sweep < sweeps) impulse_row = vec4(off_shaft(k), 0.0);
#endif
}

PASS_MAIN(settle_row)
