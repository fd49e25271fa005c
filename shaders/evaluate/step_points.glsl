// One point of the first step by one lane: a corner's of a small face, or one beside a sharp edge.
// The including kernel declares words, links, vertices, given, moved and state[].

// Where the instance's vertices and points begin.
uint first_row, first_point;

uint next_corner(uint corner) { return links_at(corner).y; }

// A control point of the cage seen from a given vertex.
vec3 from(vec3 origin, uint vertex) {
  uint i = first_row + vertex;
  precise vec3 x = (given_at(i).xyz - origin) + moved_at(i).xyz;
  return x;
}
vec3 origin_of(uint vertex) {
  return given_at(first_row + vertex).xyz;
}

void write_point(uint point, uint vertex, vec3 offset) {
  state[first_point + point] = vec4(offset, uintBitsToFloat(vertex | kVertexTag));
}

uint vertex_of(uint corner) { return vertices_at(corner); }

// The words begin with the place of each size's weights. Large faces are left to others.
void step_corner(uint corner) {
  uint size = 0u;
  uint vertex = vertex_of(corner);
  for (uint c = corner; size < kStepLargeFace;) {
    ++size;
    c = next_corner(c);
    if (c == corner) break;
  }
  if (size == kStepLargeFace) return;
  uint weight = words_at(size);
  vec3 origin = origin_of(vertex);
  vec3 sum = vec3(0.0);
  uint c = corner;
  for (uint i = 0u; i < size; ++i) {
    sum += uintBitsToFloat(words_at(weight + i)) * from(origin, vertex_of(c));
    c = next_corner(c);
  }
  write_point(corner, vertex, sum);
}

// Each point's vertex and where its pairs of a vertex and its weight begin.
void step_sharp(uint point, uint head) {
  uint vertex = words_at(head);
  vec3 origin = origin_of(vertex);
  vec3 sum = vec3(0.0);
  for (uint i = words_at(head + 1u); i < words_at(head + 3u); i += 2u)
    sum += uintBitsToFloat(words_at(i + 1u)) * from(origin, words_at(i));
  write_point(point, vertex, sum);
}
