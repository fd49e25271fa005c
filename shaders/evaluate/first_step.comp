// Control points of level 1 from those of the cage, as offsets from the given vertices: sums of
// differences between neighbours, which keep their digits wherever the model lies.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;
// The points beside sharp edges and at corner vertices, or those of the faces' corners.
layout(constant_id = 3) const uint kIsSharp = 0u;
layout(push_constant) uniform Parameters { FirstStepParameters parameters; };

READ(0, uint, words)
READ(1, uvec2, links)
READ(2, uint, vertices)
READ(3, vec4, given)
READ(4, vec4, moved)
WRITE(5, vec4, state);

uint next_corner(uint corner) { return links_at(corner - parameters.first_corner).y; }

// A control point of the cage seen from a given vertex.
vec3 from(vec3 origin, uint vertex) {
  uint i = gl_WorkGroupID.y * parameters.instance_rows + (vertex - parameters.first_vertex);
  precise vec3 x = (given_at(i).xyz - origin) + moved_at(i).xyz;
  return x;
}
vec3 origin_of(uint vertex) {
  return given_at(gl_WorkGroupID.y * parameters.instance_rows + (vertex - parameters.first_vertex))
      .xyz;
}

// The words begin with the place of each size's weights.
vec3 of_face(uint corner, vec3 origin) {
  uint size = 0u;
  for (uint c = corner;;) {
    ++size;
    c = next_corner(c);
    if (c == corner) break;
  }
  uint weight = words_at(size);
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < size; ++i) {
    sum += uintBitsToFloat(words_at(weight + i)) *
           from(origin, vertices_at(corner - parameters.first_corner));
    corner = next_corner(corner);
  }
  return sum;
}

// Pairs of a vertex and its weight.
vec3 of_list(uint first, uint end, vec3 origin) {
  vec3 sum = vec3(0.0);
  for (uint i = first; i < end; i += 2u)
    sum += uintBitsToFloat(words_at(i + 1u)) * from(origin, words_at(i));
  return sum;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= parameters.count) return;
  uint point = parameters.first_point + i;
  uint vertex;
  vec3 offset;
  if (kIsSharp != 0u) {
    // Each one's vertex and where its pairs begin.
    uint head = parameters.first_word + 2u * i;
    vertex = words_at(head);
    offset = of_list(words_at(head + 1u), words_at(head + 3u), origin_of(vertex));
  } else {
    vertex = vertices_at(point - parameters.first_corner);
    offset = of_face(point, origin_of(vertex));
  }
  state[gl_WorkGroupID.y * parameters.instance_points + (point - parameters.first_target)] =
      vec4(offset, uintBitsToFloat(vertex | kVertexTag));
}
