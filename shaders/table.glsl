// Walking a stencil table; see shared.h for its layout. The including kernel declares `parameters`.
layout(local_size_x = 64) in;
layout(constant_id = 1) const uint kChunksPerGroup = 1u;

layout(std430, set = 0, binding = 0) restrict readonly buffer Entries { uvec2 entries[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Chunks { uint chunks[]; };
layout(push_constant) uniform Parameters { TableParameters parameters; };

struct ChunkRow {
  uint row;
  uint first;
  uint width;
};

ChunkRow chunk_row(uint chunk) {
  uint head = chunk * kChunkWords;
  ChunkRow result;
  result.first = chunks[head] * kChunkRows + gl_LocalInvocationIndex;
  result.width = chunks[head + 1u];
  result.row = chunks[head + 2u + gl_LocalInvocationIndex];
  return result;
}
