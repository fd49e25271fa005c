// What kernels read, write, and over which items they go.
#ifndef PLANISH_READ
#define PLANISH_READ

// READ(number, Item, name) declares an array that is only read, whose items name_at(i) gives: as a
// storage buffer, or with PLANISH_TEXEL as a uniform texel buffer, which software devices gather
// from many times faster. No semicolon after it. READ_OF_WRITTEN is the same of a buffer that the
// kernel may write elsewhere: nothing is promised about its neighbours.
#ifdef PLANISH_TEXEL
#define SAMPLER_float samplerBuffer
#define SAMPLER_vec2 samplerBuffer
#define SAMPLER_vec4 samplerBuffer
#define SAMPLER_uint usamplerBuffer
#define SAMPLER_uvec2 usamplerBuffer
#define SAMPLER_uvec4 usamplerBuffer
float fetch_float(samplerBuffer from, uint i) { return texelFetch(from, int(i)).x; }
vec2 fetch_vec2(samplerBuffer from, uint i) { return texelFetch(from, int(i)).xy; }
vec4 fetch_vec4(samplerBuffer from, uint i) { return texelFetch(from, int(i)); }
uint fetch_uint(usamplerBuffer from, uint i) { return texelFetch(from, int(i)).x; }
uvec2 fetch_uvec2(usamplerBuffer from, uint i) { return texelFetch(from, int(i)).xy; }
uvec4 fetch_uvec4(usamplerBuffer from, uint i) { return texelFetch(from, int(i)); }
#define READ(number, Item, name)                                              \
  layout(set = 0, binding = number) uniform SAMPLER_##Item name##_texels;     \
  Item name##_at(uint i) { return fetch_##Item(name##_texels, i); }
#define READ_OF_WRITTEN(number, Item, name) READ(number, Item, name)
#else
#define READ(number, Item, name)                                                                   \
  layout(std430, set = 0, binding = number) restrict readonly buffer name##_block { Item name[]; }; \
  Item name##_at(uint i) { return name[i]; }
#define READ_OF_WRITTEN(number, Item, name)                                                \
  layout(std430, set = 0, binding = number) readonly buffer name##_block { Item name[]; }; \
  Item name##_at(uint i) { return name[i]; }
#endif
#define WRITE(number, Item, name) \
  layout(std430, set = 0, binding = number) restrict writeonly buffer name##_block { Item name[]; }

// The item of each lane of a dispatch over any number of them: work groups go on in z where x may not
// be as many.
const uint kItemLanes = 64u;
uint group_of_items() { return gl_WorkGroupID.z * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uint item_of_lane() { return group_of_items() * kItemLanes + gl_LocalInvocationIndex; }
#endif
