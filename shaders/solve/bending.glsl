// What the kernels share that move given points to where the mesh bends least; twins of
// fair/least_bending.cpp. An invocation does every so many vertices of one instance.
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { BendingParameters parameters; };

#define FOR_VERTICES(v)                                                 \
  for (uint v = gl_GlobalInvocationID.x; v < parameters.count; \
       v += gl_NumWorkGroups.x * gl_WorkGroupSize.x)

READ(0, uvec4, vertices)
READ(1, uvec2, entries)

BendingVertex vertex_at(uint v) {
  uvec4 words = vertices_at(v);
  return BendingVertex(words.x, words.y, uintBitsToFloat(words.z), uintBitsToFloat(words.w));
}
uint end_of(BendingVertex vertex) { return vertex.first + (vertex.word >> kBendingCountShift); }
uint kind_of(BendingVertex vertex) { return vertex.word & kBendingKind; }
bool is_smooth(uint kind) { return kind == kSmooth || kind == kDart; }

// What a vertex may move by.
vec3 allowed(uint kind, vec3 direction, vec3 vector) {
  vec3 along = direction * dot(direction, vector);
  if (is_smooth(kind)) return along;
  return kind == kCrease ? vector - along : vec3(0.0);
}
