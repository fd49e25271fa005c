// All steps of the interpolation of a small instance, by a work group of its own: what
// interpolation_step does, with displacements in the group's memory, and what finish_solve says.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "surface/finite.glsl"
#include "shared.h"
#define PLANISH_PARAMETERS AllStepsParameters
#include "table.glsl"
#include "square_bits.glsl"

// The three sides of all instances.
layout(std430, set = 0, binding = 2) restrict buffer Side0 { vec4 side0[]; };
layout(std430, set = 0, binding = 3) restrict buffer Side1 { vec4 side1[]; };
layout(std430, set = 0, binding = 4) restrict buffer Side2 { vec4 side2[]; };
READ(5, vec4, initial)
layout(std430, set = 0, binding = 6) restrict readonly buffer Plan { StepRecord plan[]; };
layout(std430, set = 0, binding = 7) restrict writeonly buffer Status { SolveStatus statuses[]; };

// Of this step and of the next, in turn; and the largest squares met by them.
shared vec3 displacements[2][kSmallRows];
shared uint maxima[2];

#define FOR_CHUNKS(chunk) \
  for (uint chunk = 0u; chunk < kSmallRows / kChunkRows && chunk < parameters.chunk_count; ++chunk)

vec3 side_at(uint side, uint i) {
  if (side == 0u) return side0[i].xyz;
  return side == 1u ? side1[i].xyz : side2[i].xyz;
}
void write_side(uint side, uint i, vec3 value) {
  if (side == 0u)
    side0[i] = vec4(value, 0.0);
  else if (side == 1u)
    side1[i] = vec4(value, 0.0);
  else
    side2[i] = vec4(value, 0.0);
}

void main() {
  uint instance = gl_WorkGroupID.y, first = instance * parameters.instance_rows;
  // Of the rows of this lane, a chunk each: what the last step came from.
  vec3 previous[kSmallRows / kChunkRows];
  FOR_CHUNKS(chunk) {
    uint row = chunk_row(chunk).row;
    if (row == kNoRow) continue;
    displacements[0][row] = side_at(parameters.first_side, first + row);
    previous[chunk] = side_at((parameters.first_side + 2u) % 3u, first + row);
  }
  if (gl_LocalInvocationIndex == 0u) maxima[0] = 0u;
  uint now = 0u, step = 0u, largest = 0u, state = kStateRunning;
  for (; step < parameters.measured; ++step) {
    barrier();
    uint other = (step + 1u) % 2u;
    if (gl_LocalInvocationIndex == 0u) maxima[other] = 0u;
    // The step behind those of the plan measures only.
    bool moves = step < parameters.step_count;
    float momentum = 0.0, gain = 0.0;
    if (moves) {
      StepRecord wanted = plan[step * parameters.instances + instance];
      momentum = wanted.momentum;
      gain = wanted.gain;
    }
    uint own_largest = 0u;
    FOR_CHUNKS(chunk) {
      ChunkRow at = chunk_row(chunk);
      if (at.row == kNoRow) continue;
      precise vec3 image = vec3(0.0);
      for (uint k = 0u; k < at.width; ++k) {
        uvec2 entry = entries_at(at.first + k * kChunkRows);
        image += uintBitsToFloat(entry.y) * displacements[now][entry.x];
      }
      precise vec3 residual = initial_at(first + at.row).xyz - image;
      precise float square =
          residual.x * residual.x + residual.y * residual.y + residual.z * residual.z;
      own_largest = max(own_largest, square_bits(square));
      vec3 position = displacements[now][at.row];
      precise vec3 moved =
          position + (momentum * (position - previous[chunk]) + gain * residual);
      displacements[1u - now][at.row] = moved;
    }
    atomicMax(maxima[step % 2u], own_largest);
    barrier();
    largest = maxima[step % 2u];
    if (uintBitsToFloat(largest) <= parameters.stop_square) {
      state = kStateConverged;
      break;
    }
    if (!moves) continue;
    FOR_CHUNKS(chunk) {
      uint row = chunk_row(chunk).row;
      if (row != kNoRow) previous[chunk] = displacements[now][row];
    }
    now = 1u - now;
  }
  step = min(step, parameters.step_count);
  uint side = (parameters.first_side + step) % 3u;
  FOR_CHUNKS(chunk) {
    uint row = chunk_row(chunk).row;
    if (row == kNoRow) continue;
    write_side(side, first + row, displacements[now][row]);
    write_side((side + 2u) % 3u, first + row, previous[chunk]);
  }
  if (gl_LocalInvocationIndex != 0u) return;
  float square = uintBitsToFloat(largest);
  if (!is_finite(square)) state = kStateNotFinite;
  statuses[instance].iterations = step;
  statuses[instance].state = state;
  statuses[instance].residual = sqrt(square);
  statuses[instance].max_square_bits = largest;
  statuses[instance].side = side;
}
