// Walking a stencil table; see shared.h for its layout. PLANISH_PARAMETERS names the push constants
// of kernels that do not take TableParameters.
layout(local_size_x = 64) in;
layout(constant_id = 1) const uint kChunksPerGroup = 1u;

#include "read.glsl"

READ(0, uvec2, entries)
READ(1, uint, chunks)

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
  result.first = chunks_at(head) * kChunkRows + gl_LocalInvocationIndex;
  result.width = chunks_at(head + 1u);
  result.row = chunks_at(head + 2u + gl_LocalInvocationIndex);
  return result;
}
