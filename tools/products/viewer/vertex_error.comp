#version 450
// Writes beside each vertex of the surface the distance from the surface of the given points nearest
// to it: the mean over them.
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

layout(local_size_x = kErrorGroup) in;
layout(push_constant) uniform Push { uint vertex_count; };
layout(set = 0, binding = kGivenBinding) readonly buffer Given { float given[]; };
layout(set = 0, binding = kVerticesBinding) buffer Vertices { float vertices[]; };
layout(set = 0, binding = kUsedBinding) readonly buffer Used { uint used[]; };
layout(set = 0, binding = kOffsetsBinding) readonly buffer Offsets { uint offsets[]; };
layout(set = 0, binding = kNearestBinding) readonly buffer Nearest { uint nearest[]; };

vec3 given_point(uint row) {
  uint first = 3u * used[row];
  return vec3(given[first], given[first + 1u], given[first + 2u]);
}

vec3 limit_point(uint row) {
  uint first = kVertexFloats * row;
  return vec3(vertices[first], vertices[first + 1u], vertices[first + 2u]);
}

void main() {
  // Devices limit the number of groups, not the number of vertices.
  uint stride = kErrorGroup * gl_NumWorkGroups.x;
  for (uint vertex = gl_GlobalInvocationID.x; vertex < vertex_count; vertex += stride) {
    float sum = 0.0;
    for (uint k = offsets[vertex]; k < offsets[vertex + 1u]; ++k)
      sum += distance(given_point(nearest[k]), limit_point(nearest[k]));
    vertices[kVertexFloats * vertex + kErrorFloat] =
        sum / float(offsets[vertex + 1u] - offsets[vertex]);
  }
}
