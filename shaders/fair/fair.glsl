// What the kernels of the fair construction share. An invocation does every so many elements, so
// that the device's limit on work groups bounds nothing; where a group does an element, a group does.
#include "surface/finite.glsl"
#include "fair/shared_fair.h"
#include "read.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { FairParameters parameters; };

// Whether each element has a work group, not a lane; fair_walk.glsl.
layout(constant_id = 3) const uint kSharedWord = 0u;
const bool kShared = kSharedWord != 0u;

#define FOR_ELEMENTS(i)                                                                            \
  for (uint i = kShared ? gl_WorkGroupID.x : gl_GlobalInvocationID.x; i < parameters.count; \
       i += gl_NumWorkGroups.x * (kShared ? 1u : gl_WorkGroupSize.x))

#ifdef PLANISH_TEXEL
#define SAMPLER_FairVertex usamplerBuffer
#define SAMPLER_FairPlace usamplerBuffer
#define SAMPLER_FairLinks usamplerBuffer
#define SAMPLER_FairFace usamplerBuffer
#define SAMPLER_FairEdge usamplerBuffer
FairVertex fetch_FairVertex(usamplerBuffer from, uint i) {
  int first = 3 * int(i);
  uvec4 a = texelFetch(from, first), b = texelFetch(from, first + 1);
  uvec4 c = texelFetch(from, first + 2);
  return FairVertex(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z, c.w);
}
FairPlace fetch_FairPlace(usamplerBuffer from, uint i) {
  uvec4 a = texelFetch(from, int(i));
  return FairPlace(a.x, a.y, a.z, a.w);
}
FairLinks fetch_FairLinks(usamplerBuffer from, uint i) {
  uvec4 a = texelFetch(from, int(i));
  return FairLinks(a.x, a.y, a.z, a.w);
}
FairFace fetch_FairFace(usamplerBuffer from, uint i) {
  uvec4 a = texelFetch(from, int(i));
  return FairFace(a.x, a.y, a.z, a.w);
}
FairEdge fetch_FairEdge(usamplerBuffer from, uint i) {
  int first = 2 * int(i);
  uvec4 a = texelFetch(from, first);
  uvec2 b = texelFetch(from, first + 1).xy;
  return FairEdge(a.x, a.y, a.z, a.w, b.x, b.y, 0u, 0u);
}
#endif
// Small arrays, as storage buffers everywhere.
#define READ_STORED(number, Item, name) \
  layout(std430, set = 0, binding = number) restrict readonly buffer name##_block { Item name[]; }
#define UPDATE(number, Item, name) \
  layout(std430, set = 0, binding = number) restrict buffer name##_block { Item name[]; }

// Whose items lanes read that others of the group have written; fair_walk.glsl.
#define UPDATE_TOGETHER(number, Item, name) \
  layout(std430, set = 0, binding = number) coherent restrict buffer name##_block { Item name[]; }

bool has_polygon(FairVertex vertex) { return vertex.kind == kSmooth || vertex.kind == kDart; }

// The length, wherever that is a float.
float safe_length(vec3 v) {
  float size = max(max(abs(v.x), abs(v.y)), abs(v.z));
  return size > 0.0 ? size * length(v / size) : 0.0;
}
vec3 normalised(vec3 v) {
  float size = safe_length(v);
  return size > 0.0 ? v / size : vec3(0.0, 0.0, 1.0);
}

// At a crease or boundary vertex, a quarter of the two sharp edges; fair/vertex_polygon.h.
struct CreaseArms {
  vec3 before, after;
};
