// One step of the interpolation for every row: residual = initial - B d, step = momentum * last
// step + gain * residual, next d = d + step; measures the residual that it meets.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "table.glsl"

layout(std430, set = 0, binding = 2) restrict readonly buffer Previous { float previous[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Current { float current[]; };
layout(std430, set = 0, binding = 4) restrict writeonly buffer Next { float next[]; };
layout(std430, set = 0, binding = 5) restrict readonly buffer Initial { float initial[]; };
layout(std430, set = 0, binding = 6) restrict buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 7) restrict writeonly buffer Partials { float partials[]; };

shared float group_sums[kChunkRows];
shared uint group_maxima[kChunkRows];

// Returns |residual|^2 of the row, having written its next displacement.
float advance(ChunkRow at) {
  precise vec3 image = vec3(0.0);
  for (uint k = 0u; k < at.width; ++k) {
    uvec2 entry = entries[at.first + k * kChunkRows];
    uint place = 3u * entry.x;
    image += uintBitsToFloat(entry.y) *
             vec3(current[place], current[place + 1u], current[place + 2u]);
  }
  uint own = 3u * (at.row - parameters.first_row);
  uint source = 3u * (at.row - parameters.first_source);
  precise vec3 residual = vec3(initial[own], initial[own + 1u], initial[own + 2u]) - image;
  vec3 position = vec3(current[source], current[source + 1u], current[source + 2u]);
  vec3 before = vec3(previous[own], previous[own + 1u], previous[own + 2u]);
  precise vec3 moved = position + (steps[parameters.step].momentum * (position - before) +
                                   steps[parameters.step].gain * residual);
  next[own] = moved.x;
  next[own + 1u] = moved.y;
  next[own + 2u] = moved.z;
  precise float square =
      residual.x * residual.x + residual.y * residual.y + residual.z * residual.z;
  return square;
}

void main() {
  // The errors before this step were complete with the last dispatch: stop without a host.
  if (parameters.step > 0u && uintBitsToFloat(steps[parameters.step - 1u].max_square_bits) <=
                                  parameters.stop_square)
    return;

  uint lane = gl_LocalInvocationIndex;
  precise float sum = 0.0;
  uint largest = 0u;
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) break;
    ChunkRow at = chunk_row(chunk);
    if (at.row == kNoRow) continue;
    float square = advance(at);
    sum += square;
    largest = max(largest, min(floatBitsToUint(square) & 0x7fffffffu, 0x7f800000u));
  }
  group_sums[lane] = sum;
  group_maxima[lane] = largest;
  barrier();
  // Two short serial levels: few barriers, and a fixed order.
  if ((lane & 7u) == 0u) {
    for (uint i = 1u; i < 8u; ++i) {
      sum += group_sums[lane + i];
      largest = max(largest, group_maxima[lane + i]);
    }
    group_sums[lane] = sum;
    group_maxima[lane] = largest;
  }
  barrier();
  if (lane == 0u) {
    for (uint i = 8u; i < kChunkRows; i += 8u) {
      sum += group_sums[i];
      largest = max(largest, group_maxima[i]);
    }
    atomicMax(steps[parameters.step].max_square_bits, largest);
    partials[parameters.step * parameters.group_total + parameters.first_group +
             gl_WorkGroupID.x] = sum;
  }
}
