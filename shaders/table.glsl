// Walking a stencil table; see shared.h for its layout. PLANISH_PARAMETERS names the push constants
// of kernels that do not take TableParameters. Read-only arrays come as storage buffers, or
// with PLANISH_TEXEL as uniform texel buffers, which software devices gather from many times faster.
layout(local_size_x = 64) in;
layout(constant_id = 1) const uint kChunksPerGroup = 1u;

#ifdef PLANISH_TEXEL
layout(set = 0, binding = 0) uniform usamplerBuffer entries;
layout(set = 0, binding = 1) uniform usamplerBuffer chunks;
uvec2 entry_at(uint i) { return texelFetch(entries, int(i)).xy; }
uint chunk_word(uint i) { return texelFetch(chunks, int(i)).x; }
#define POINTS_BINDING(number, name)                               \
  layout(set = 0, binding = number) uniform samplerBuffer name;    \
  vec3 name##_at(uint i) { return texelFetch(name, int(i)).xyz; }
#define PAIRS_BINDING(number, name)                                \
  layout(set = 0, binding = number) uniform samplerBuffer name;    \
  vec2 name##_at(uint i) { return texelFetch(name, int(i)).xy; }
#define FLOATS_BINDING(number, name)                               \
  layout(set = 0, binding = number) uniform samplerBuffer name;    \
  float name##_at(uint i) { return texelFetch(name, int(i)).x; }
#else
layout(std430, set = 0, binding = 0) restrict readonly buffer Entries { uvec2 entries[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Chunks { uint chunks[]; };
uvec2 entry_at(uint i) { return entries[i]; }
uint chunk_word(uint i) { return chunks[i]; }
#define POINTS_BINDING(number, name)                                                          \
  layout(std430, set = 0, binding = number) restrict readonly buffer name##_block { vec4 name[]; }; \
  vec3 name##_at(uint i) { return name[i].xyz; }
#define PAIRS_BINDING(number, name)                                                           \
  layout(std430, set = 0, binding = number) restrict readonly buffer name##_block { vec2 name[]; }; \
  vec2 name##_at(uint i) { return name[i]; }
// May be the buffer that the kernel writes, so nothing is promised about its neighbours.
#define FLOATS_BINDING(number, name)                                                          \
  layout(std430, set = 0, binding = number) readonly buffer name##_block { float name[]; };    \
  float name##_at(uint i) { return name[i]; }
#endif

#ifndef PLANISH_PARAMETERS
#define PLANISH_PARAMETERS TableParameters
#endif
layout(push_constant) uniform Parameters { PLANISH_PARAMETERS parameters; };

struct ChunkRow {
  uint row;
  uint first;
  uint width;
};

ChunkRow chunk_row(uint chunk) {
  uint head = chunk * kChunkWords;
  ChunkRow result;
  result.first = chunk_word(head) * kChunkRows + gl_LocalInvocationIndex;
  result.width = chunk_word(head + 1u);
  result.row = chunk_word(head + 2u + gl_LocalInvocationIndex);
  return result;
}
