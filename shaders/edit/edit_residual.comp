// A step of the rows in the list, without taking it: residual = given - B (given + displacement) in
// differences, velocity = momentum * velocity + gain * residual; measures the residual.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "edit.glsl"
#include "read.glsl"
#include "square_bits.glsl"

READ(0, uvec2, entries)
READ(1, uint, chunks)
READ(2, uint, slots)
READ(3, vec4, given)
READ(4, vec4, moved)
layout(std430, set = 0, binding = 5) restrict buffer Velocity { vec4 velocity[]; };
layout(std430, set = 0, binding = 6) restrict buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 7) restrict buffer Work { uint work[]; };

vec3 residual_of(uint place, uint row) {
  uint slot = slots_at(row);
  uint head = slot / kChunkRows * kChunkWords;
  uint at = chunks_at(head) * kChunkRows + slot % kChunkRows;
  uint width = chunks_at(head + 1u);
  uint first = place - row + parameters.first_source;
  vec3 own = given_at(place).xyz;
  precise vec3 sum = vec3(0.0);
  for (uint k = 0u; k < width; ++k) {
    uvec2 entry = entries_at(at + k * kChunkRows);
    uint other = first + entry.x;
    precise vec3 difference = (own - given_at(other).xyz) - moved_at(other).xyz;
    sum += uintBitsToFloat(entry.y) * difference;
  }
  return sum;
}

void step_row(uint place) {
  uint instance = place / parameters.row_stride;
  uint step = parameters.step * parameters.instances + instance;
  // Errors before this step were complete with the last dispatch: stop without a host.
  if (parameters.step > 0u && uintBitsToFloat(steps[step - parameters.instances].max_square_bits) <=
                                  parameters.stop_square)
    return;
  vec3 residual = residual_of(place, place - instance * parameters.row_stride);
  precise vec3 next = steps[step].momentum * velocity[place].xyz + steps[step].gain * residual;
  velocity[place] = vec4(next, 0.0);
  precise float square =
      residual.x * residual.x + residual.y * residual.y + residual.z * residual.z;
  uint largest = square_bits(square);
  if (largest > steps[step].max_square_bits) atomicMax(steps[step].max_square_bits, largest);
}

void main() {
  uint count = work[kEditRows];
  // What comes next moves the rows that are there now, while the list grows.
  if (gl_GlobalInvocationID.x == 0u) {
    work[kEditSpread] = work[kEditHeld];
    work[kEditHeld] = count;
    work[kEditForHeld] = work[kEditForRows];
  }
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count())
    step_row(work[parameters.first_listed + i]);
}
