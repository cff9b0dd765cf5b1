// SPDX-License-Identifier: MIT
//
// Brings the entries of each list of compressed rows into ascending order, so that nothing depends on which lane was
// first, and tells each value its rank in its list. A lane an entry. Needs contact_tables.glsl.

layout(local_size_x = GROUP) in;

uniform int first_list, owner_count, raw_list, owner_list;  // words
uniform int to_list, rank_list;                             // words; the latter by value

void main() {
  int entry = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (entry >= load_words[first_list + owner_count]) return;
  int owner = load_words[owner_list + entry];
  int value = load_words[raw_list + entry];
  int first = load_words[first_list + owner];
  int end = load_words[first_list + owner + 1];
  int rank = 0;
  for (int k = first; k < end; ++k) rank += load_words[raw_list + k] < value ? 1 : 0;
  load_words[to_list + first + rank] = value;
  load_words[rank_list + value] = rank;
}
