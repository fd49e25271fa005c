// How many points the host has moved, for the dispatch that takes them.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

layout(local_size_x = 1) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Moves { uint moves[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Work { uint work[]; };
layout(push_constant) uniform Parameters { EditParameters parameters; };

void main() {
  uint count = min(moves[parameters.moves_shift], parameters.most_moves);
  work[kEditMoves] = count;
  work[kEditForMoves] = min((count + (kChunkRows - 1u)) / kChunkRows, parameters.max_groups);
}
