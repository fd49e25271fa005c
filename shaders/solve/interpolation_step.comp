// One step of the interpolation for every row: residual = initial - B d, step = momentum * last
// step + gain * residual, next d = d + step; measures the residual that it meets.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "table.glsl"
#include "group_fold.glsl"
#include "square_bits.glsl"

READ(2, vec4, previous)
READ(3, vec4, current)
READ(4, vec4, initial)
layout(std430, set = 0, binding = 5) restrict writeonly buffer Next { vec4 next[]; };
layout(std430, set = 0, binding = 6) restrict buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 7) restrict writeonly buffer Partials { float partials[]; };

// Each lane writes its own sum instead of sharing a group's: barriers cost much where the device is
// software.
layout(constant_id = 2) const bool kLaneSums = false;

// Returns |residual|^2 of the row, having written its next displacement.
float advance(ChunkRow at, float momentum, float gain) {
  uint first = gl_WorkGroupID.y * parameters.instance_rows;
  precise vec3 image = vec3(0.0);
  for (uint k = 0u; k < at.width; ++k) {
    uvec2 entry = entries_at(at.first + k * kChunkRows);
    image += uintBitsToFloat(entry.y) * current_at(first + entry.x).xyz;
  }
  uint own = first + (at.row - parameters.first_row);
  precise vec3 residual = initial_at(own).xyz - image;
  vec3 position = current_at(first + (at.row - parameters.first_source)).xyz;
  precise vec3 moved = position + (momentum * (position - previous_at(own).xyz) + gain * residual);
  next[own] = vec4(moved, 0.0);
  precise float square =
      residual.x * residual.x + residual.y * residual.y + residual.z * residual.z;
  return square;
}

void share_results(float own_sum, uint own_largest, uint step, uint place) {
  float sum = group_sum(own_sum);
  uint largest = group_max(own_largest);
  if (gl_LocalInvocationIndex != 0u) return;
  atomicMax(steps[step].max_square_bits, largest);
  if (parameters.partials_total > 0u) partials[place] = sum;
}

void main() {
  // The errors before this step were complete with the last dispatch: stop without a host.
  uint instances = parameters.further_instances + 1u;
  uint step = parameters.step * instances + gl_WorkGroupID.y;
  if (parameters.step > 0u &&
      uintBitsToFloat(steps[step - instances].max_square_bits) <= parameters.stop_square)
    return;

  float momentum = steps[step].momentum;
  float gain = steps[step].gain;
  precise float sum = 0.0;
  uint largest = 0u;
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) break;
    ChunkRow at = chunk_row(chunk);
    if (at.row == kNoRow) continue;
    float square = advance(at, momentum, gain);
    sum += square;
    largest = max(largest, square_bits(square));
  }
  uint place = parameters.step * parameters.partials_total;
  uint group = parameters.first_group + gl_WorkGroupID.x;
  if (kLaneSums) {
    if (largest > steps[step].max_square_bits) atomicMax(steps[step].max_square_bits, largest);
    if (parameters.partials_total > 0u)
      partials[place + group * kChunkRows + gl_LocalInvocationIndex] = sum;
  } else {
    share_results(sum, largest, step, place + group);
  }
}
