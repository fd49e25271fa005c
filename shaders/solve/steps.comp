// The steps of the interpolation, one a dispatch, or all of a small instance in one; then what they came
// to, and whether there are to be more.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "surface/finite.glsl"
#include "shared.h"

#ifdef KERNEL_interpolation_step
// One step of the interpolation for every row: residual = initial - B d, step = momentum * last
// step + gain * residual, next d = d + step; measures the residual that it meets.
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
#endif

#ifdef KERNEL_all_steps
// All steps of the interpolation of a small instance, by a work group of its own: what
// interpolation_step does, with displacements in the group's memory, and what finish_solve says.
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
#endif

#ifdef KERNEL_reduce_rms
// Adds up the partial square sums of each step, one work group a step.
#include "group_fold.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Partials { float partials[]; };
layout(std430, set = 0, binding = 1) restrict buffer Steps { StepRecord steps[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

void main() {
  uint step = gl_WorkGroupID.x;
  if (step > 0u && uintBitsToFloat(steps[step - 1u].max_square_bits) <= parameters.stop_square)
    return;
  uint first = step * parameters.count;
  precise float sum = 0.0;
  for (uint i = gl_LocalInvocationIndex; i < parameters.count; i += kReduceLanes)
    sum += partials[first + i];
  sum = group_sum(sum);
  if (gl_LocalInvocationIndex == 0u) steps[step].square_sum = sum;
}
#endif

#ifdef KERNEL_finish_solve
// Says where the steps ended: how many were taken, why, at what error, and in which buffer.
layout(local_size_x = 1) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Status { SolveStatus statuses[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

void main() {
  uint instance = gl_WorkGroupID.y;
  uint instances = parameters.further_instances + 1u;
  uint state = kStateRunning;
  uint largest = 0u;
  uint step = 0u;
  for (; step < parameters.count; ++step) {
    largest = steps[step * instances + instance].max_square_bits;
    if (uintBitsToFloat(largest) <= parameters.stop_square) {
      state = kStateConverged;
      break;
    }
  }
  float square = uintBitsToFloat(largest);
  if (!is_finite(square)) state = kStateNotFinite;
  step = min(step, parameters.step_count);
  statuses[instance].iterations = step;
  statuses[instance].state = state;
  statuses[instance].residual = sqrt(square);
  statuses[instance].max_square_bits = largest;
  if (parameters.keeps_side == 0u)
    statuses[instance].side = (parameters.first_side + step) % 3u;
}
#endif

#ifdef KERNEL_stop_test
// Ends the steps to come where every instance's error was low enough: no work groups for their
// indirect dispatches.
layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

shared uint is_above;

void main() {
  uint lane = gl_LocalInvocationIndex;
  if (lane == 0u) is_above = 0u;
  barrier();
  uint instances = parameters.further_instances + 1u;
  uint first = (parameters.step_count - 1u) * instances;
  for (uint i = lane; i < instances; i += kReduceLanes)
    if (uintBitsToFloat(steps[first + i].max_square_bits) > parameters.stop_square)
      atomicOr(is_above, 1u);
  barrier();
  if (lane != 0u || is_above != 0u) return;
  for (uint i = 0u; i < parameters.count; ++i) arguments[kArgumentWords * i] = 0u;
}
#endif
