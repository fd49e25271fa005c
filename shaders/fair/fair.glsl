// What the kernels of the fair construction share. An invocation does every so many elements, so
// that the device's limit on work groups bounds nothing.
#include "surface/finite.glsl"
#include "fair/shared_fair.h"
#include "read.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { FairParameters parameters; };

#define FOR_ELEMENTS(i)                                                 \
  for (uint i = gl_GlobalInvocationID.x; i < parameters.count; \
       i += gl_NumWorkGroups.x * gl_WorkGroupSize.x)

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
  return FairVertex(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, 0u, 0u);
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
  return FairFace(a.x, a.y, a.z, 0u);
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
