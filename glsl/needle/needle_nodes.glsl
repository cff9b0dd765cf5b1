// SPDX-License-Identifier: MIT
//
// The nodes of a needle's hole in one step, a lane each: where they are, how they move, how much of the shaft rubs
// there. Needs needle_motion.glsl.

shared float node_limit[MOST_NODES];  // N s of friction
shared vec4 team_rows[GROUP];

float own_along;  // of the lane's node

vec4 coupling(int k, int other) {
  int at = coupling_row(k, other);
  return intBitsToFloat(ivec4(needle_words[at], needle_words[at + 1], needle_words[at + 2], needle_words[at + 3]));
}

// Places and velocities of all nodes: weighted means, a team of lanes for each.
void gather(int lane) {
  int member = lane % TEAM;
  for (int first = 0; first < node_count; first += GROUP / TEAM) {
    int k = first + lane / TEAM;
    vec4 place = vec4(0.0);
    vec4 motion = vec4(0.0);
    if (k < node_count) {
      int end = around(k);
      for (int j = member; j < end; j += TEAM) {
        int i = particle_of(k, j);
        float weight = weight_of(k, j);
        place += vec4(weight * place_of(i), 0.0);
        motion += vec4(weight * motion_of(i), 0.0);
      }
    }
    group_rows[lane] = place;
    team_rows[lane] = motion;
    wait_for_group();
    if (member == 0 && k < node_count) {
      for (int m = 1; m < TEAM; ++m) {
        place += group_rows[lane + m];
        motion += team_rows[lane + m];
      }
      node_place[k] = vec4(place.xyz, inner_product(axis, place.xyz));
      node_motion[k] = vec4(motion.xyz, coupling(k, k).w);
    }
    wait_for_group();
  }
  if (lane >= node_count) return;
  own_place = node_place[lane].xyz;
  own_along = node_place[lane].w;
  own_motion = node_motion[lane].xyz;
  own_ease = node_motion[lane].w;
}

// Each node on the shaft rubs over half of the way to the next ones; the first up to the surface, the last to the tip
// or to where the shaft comes out. Of the lane's own node, m.
float rubbing_length(int lane) {
  float above = -1.0;  // along, of the border to the node before
  for (int k = 0; k < node_count; ++k) {
    if (!on_shaft(k)) continue;
    float along = node_place[k].w;
    if (above < 0.0) above = along;
    float end = through && is_last(k) ? along : 0.0;
    bool last = is_last(k) || !on_shaft(k + 1);
    float below = last ? end : 0.5 * (along + node_place[k + 1].w);
    if (k == lane) return max(0.0, above - below);
    above = below;
  }
  return 0.0;
}

// Friction acts against the whole sliding, of which a turning shaft has a part around it: what is left lengthwise is
// that much smaller.
void begin_limits(int lane) {
  own_rubbed = 0.0;
  own_pushed = 0.0;
  own_side = vec3(0.0);
  own_limit = 0.0;
  if (lane < node_count) {
    bool slides = turned != 0.0 || needle_words[node_words(lane) + 1] != 0;
    own_limit = (slides ? kinetic_friction : static_friction) * rubbing_length(lane) * dt;
    node_limit[lane] = own_limit;
  }
  wait_for_group();
}
