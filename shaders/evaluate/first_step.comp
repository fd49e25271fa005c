// Control points of level 1 from those of the cage, as offsets from the given vertices: sums of
// differences between neighbours, which keep their digits wherever the model lies.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 3) const uint kStep = kStepFaces;
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

void write_point(uint point, uint vertex, vec3 offset) {
  state[gl_WorkGroupID.y * parameters.instance_points + (point - parameters.first_target)] =
      vec4(offset, uintBitsToFloat(vertex | kVertexTag));
}

uint vertex_of(uint corner) { return vertices_at(corner - parameters.first_corner); }

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

const uint kStepLanes = 64u;
shared vec3 means[kStepLanes], evens[kStepLanes], odds[kStepLanes];

vec2 turn_at(uint place, uint i) {
  return vec2(uintBitsToFloat(words_at(place + 2u * i)),
              uintBitsToFloat(words_at(place + 2u * i + 1u)));
}

// refine_large_face() of patches/first_step.cpp.
void step_large_face(uint head, uint lane) {
  uint first = words_at(head), size = words_at(head + 1u), turns = words_at(head + 2u);
  vec3 origin = origin_of(vertex_of(first));
  precise vec3 mean = vec3(0.0), even = vec3(0.0), odd = vec3(0.0);
  for (uint i = lane; i < size; i += kStepLanes) {
    vec3 x = from(origin, vertex_of(first + i));
    vec2 turn = turn_at(turns, i);
    mean += x;
    even += turn.x * x;
    odd += turn.y * x;
  }
  means[lane] = mean, evens[lane] = even, odds[lane] = odd;
  for (uint half_count = kStepLanes / 2u; half_count > 0u; half_count /= 2u) {
    barrier();
    if (lane < half_count) {
      means[lane] += means[lane + half_count];
      evens[lane] += evens[lane + half_count];
      odds[lane] += odds[lane + half_count];
    }
  }
  barrier();
  float share = 1.0 / float(size), swing = 2.0 * parameters.turn * share;
  mean = means[0] * share, even = evens[0] * swing, odd = odds[0] * swing;
  for (uint i = lane; i < size; i += kStepLanes) {
    uint vertex = vertex_of(first + i);
    uint before = vertex_of(first + (i == 0u ? size : i) - 1u);
    uint after = vertex_of(first + (i + 1u == size ? 0u : i + 1u));
    vec3 own = origin_of(vertex);
    vec2 turn = turn_at(turns, i);
    precise vec3 offset = parameters.own * from(own, vertex) +
                          parameters.beside * (from(own, before) + from(own, after)) +
                          parameters.mean * (mean - (own - origin)) +
                          (turn.x * even + turn.y * odd);
    write_point(first + i, vertex, offset);
  }
  // Before the next face's sums take their places.
  barrier();
}

void main() {
  if (kStep == kStepLargeFaces) {
    for (uint face = gl_WorkGroupID.x; face < parameters.count; face += gl_NumWorkGroups.x)
      step_large_face(parameters.first_word + kLargeFaceWords * face, gl_LocalInvocationIndex);
    return;
  }
  uint i = gl_GlobalInvocationID.x;
  if (i >= parameters.count) return;
  if (kStep == kStepSharp)
    step_sharp(parameters.first_point + i, parameters.first_word + 2u * i);
  else
    step_corner(parameters.first_point + i);
}
