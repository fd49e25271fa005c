// What the kernels of the fair construction share. An invocation does every so many elements, so
// that the device's limit on work groups bounds nothing.
#include "shared.h"

layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { FairParameters parameters; };

#define FOR_ELEMENTS(i)                                                 \
  for (uint i = gl_GlobalInvocationID.x; i < parameters.count; \
       i += gl_NumWorkGroups.x * gl_WorkGroupSize.x)

#define READ(number, Item, name) \
  layout(std430, set = 0, binding = number) restrict readonly buffer name##_block { Item name[]; }
#define WRITE(number, Item, name) \
  layout(std430, set = 0, binding = number) restrict writeonly buffer name##_block { Item name[]; }
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
