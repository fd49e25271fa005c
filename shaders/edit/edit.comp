// An edit, a frame of some moved points: takes them, steps the rows that they reach, which are listed as
// they are reached, and says where that has moved points and which patches are to be evaluated.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

#ifdef KERNEL_edit_begin
layout(local_size_x = 1) in;
#else
layout(local_size_x = 64) in;
#endif
layout(push_constant) uniform Parameters { EditParameters parameters; };

uint lane_count() { return gl_NumWorkGroups.x * kChunkRows; }
// Of a slot's list of stale rows.
uint stale_head(uint slot) { return slot * kStaleWords; }
uint stale_list(uint slot) {
  return parameters.slot_count * kStaleWords + slot * parameters.most_stale;
}
uint groups_of(uint lanes) {
  return min((lanes + (kChunkRows - 1u)) / kChunkRows, parameters.max_groups);
}

#include "surface/finite.glsl"
#include "read.glsl"

#ifdef KERNEL_edit_begin
// How many points the host has moved, for the dispatch that takes them.
layout(std430, set = 0, binding = 0) restrict readonly buffer Moves { uint moves[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Work { uint work[]; };

void main() {
  uint count = min(moves[parameters.moves_shift], parameters.most_moves);
  work[kEditMoves] = count;
  work[kEditForMoves] = min((count + (kChunkRows - 1u)) / kChunkRows, parameters.max_groups);
}
#endif

#ifdef KERNEL_edit_take
layout(std430, set = 0, binding = 0) restrict readonly buffer Moves { uint moves[]; };
READ(1, uint, vertices)
layout(std430, set = 0, binding = 2) restrict readonly buffer Source { float source[]; };
WRITE(3, vec4, given);
WRITE(4, vec4, velocity);
layout(std430, set = 0, binding = 5) buffer Flags { uint flags[]; };
layout(std430, set = 0, binding = 6) buffer Work { uint work[]; };
#endif
#ifdef KERNEL_edit_advance
READ(0, uint, places)
READ(1, uvec2, links)
READ(2, uint, vertices)
layout(std430, set = 0, binding = 3) restrict buffer Moved { vec4 moved[]; };
layout(std430, set = 0, binding = 4) buffer Velocity { vec4 velocity[]; };
layout(std430, set = 0, binding = 5) restrict readonly buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 6) buffer Flags { uint flags[]; };
layout(std430, set = 0, binding = 7) buffer Work { uint work[]; };
#endif

#if defined(KERNEL_edit_take) || defined(KERNEL_edit_advance)
// The list grows. True where the row was not yet in it.
bool wake(uint row) {
  // Most have been woken before: a look is cheaper than an exchange.
  if ((flags[row] & kRowListed) != 0u || (atomicOr(flags[row], kRowListed) & kRowListed) != 0u)
    return false;
  velocity[row] = vec4(0.0);
  uint place = atomicAdd(work[kEditRows], 1u);
  work[parameters.first_listed + place] = row;
  atomicMax(work[kEditForRows], groups_of(place + 1u));
  return true;
}
#endif

#ifdef KERNEL_edit_take
// Takes the moved points from the host's, and lists their rows. What the host names may be anything.

// kNone where no face names the vertex. Rows ascend with their vertices.
uint row_of(uint vertex) {
  uint low = 0u, high = min(vertex, parameters.row_count - 1u);
  if (vertices_at(high) == vertex) return high;
  while (low < high) {
    uint middle = (low + high) / 2u;
    if (vertices_at(middle) < vertex)
      low = middle + 1u;
    else
      high = middle;
  }
  return vertices_at(low) == vertex ? low : kNone;
}

void take(uint move) {
  uint instance = move / parameters.given_count;
  if (instance >= parameters.instances) return;
  uint vertex = move - instance * parameters.given_count;
  uint row = row_of(vertex);
  if (row == kNone) return;
  uint place = parameters.source_shift + instance * parameters.instance_floats +
               vertex * parameters.source_stride;
  vec3 point = vec3(source[place], source[place + 1u], source[place + 2u]);
  // One bad point must not spoil all that edits reach.
  if (!(is_finite(point.x) && is_finite(point.y) && is_finite(point.z))) return;
  row += instance * parameters.row_stride;
  given[row] = vec4(point, 0.0);
  if (!wake(row)) return;
  uint held = atomicAdd(work[kEditHeld], 1u);
  atomicMax(work[kEditForHeld], groups_of(held + 1u));
}

void main() {
  uint count = work[kEditMoves];
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count())
    take(moves[parameters.moves_shift + 1u + i]);
}
#endif

#ifdef KERNEL_edit_advance
// Takes the step of the rows that were measured, unless they are good enough, and lists the rows that
// it reaches: of the vertices of their faces.

void wake_neighbours(uint first, uint row) {
  uint end = places_at(row + 1u);
  for (uint i = places_at(row); i < end; ++i) {
    uint corner = places_at(i);
    uint other = corner;
    if (corner < parameters.first_sharp) other = links_at(corner).y;
    while (other != corner) {
      wake(first + vertices_at(other));
      other = links_at(other).y;
    }
  }
}

void advance(uint i) {
  uint place = work[parameters.first_listed + i];
  uint instance = place / parameters.row_stride;
  uint first = instance * parameters.row_stride;
  if (parameters.step != kNone) {
    uint step = parameters.step * parameters.instances + instance;
    if (uintBitsToFloat(steps[step].max_square_bits) <= parameters.stop_square) return;
    precise vec3 next = moved[place].xyz + velocity[place].xyz;
    moved[place] = vec4(next, 0.0);
  }
  if (i >= work[kEditSpread]) wake_neighbours(first, place - first);
}

void main() {
  uint count = work[kEditHeld];
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) advance(i);
}
#endif

#ifdef KERNEL_edit_residual
// A step of the rows in the list, without taking it: residual = given - B (given + displacement) in
// differences, velocity = momentum * velocity + gain * residual; measures the residual.
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
#endif

#ifdef KERNEL_edit_commit
// What an edit has moved, where solves go on from and hosts look for control points.
layout(std430, set = 0, binding = 0) restrict writeonly buffer Side0 { vec4 side0[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Side1 { vec4 side1[]; };
layout(std430, set = 0, binding = 2) restrict writeonly buffer Side2 { vec4 side2[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Status { SolveStatus statuses[]; };
layout(std430, set = 0, binding = 4) restrict readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 5) restrict readonly buffer Moved { vec4 moved[]; };
layout(std430, set = 0, binding = 6) restrict writeonly buffer Control { vec4 control[]; };
layout(std430, set = 0, binding = 7) restrict readonly buffer Work { uint work[]; };

void main() {
  uint count = work[kEditRows];
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) {
    uint place = work[parameters.first_listed + i];
    vec4 displacement = moved[place];
    uint side = statuses[place / parameters.row_stride].side;
    if (side == 0u)
      side0[place] = displacement;
    else if (side == 1u)
      side1[place] = displacement;
    else
      side2[place] = displacement;
    control[place] = given[place] + displacement;
  }
}
#endif

#ifdef KERNEL_edit_points
// The points of level 1 at the vertices that an edit has reached, but those of large faces.
READ(0, uint, places)
READ(1, uint, words)
READ(2, uvec2, links)
READ(3, uint, vertices)
READ(4, vec4, given)
READ(5, vec4, moved)
WRITE(6, vec4, state);
layout(std430, set = 0, binding = 7) restrict readonly buffer Work { uint work[]; };

#include "evaluate/step_points.glsl"

void main() {
  uint count = work[kEditRows];
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) {
    uint place = work[parameters.first_listed + i];
    uint instance = place / parameters.row_stride;
    first_row = instance * parameters.row_stride;
    first_point = instance * parameters.point_stride;
    uint end = places_at(place - first_row + 1u);
    for (uint k = places_at(place - first_row); k < end; ++k) {
      uint point = places_at(k);
      if (point < parameters.first_sharp)
        step_corner(point);
      else
        step_sharp(point, parameters.first_word + 2u * (point - parameters.first_sharp));
    }
  }
}
#endif

#ifdef KERNEL_edit_stale
// Puts the rows that are stale in the edit's slot into its list, behind those that it has moved.
layout(std430, set = 0, binding = 0) restrict buffer Flags { uint flags[]; };
layout(std430, set = 0, binding = 1) restrict buffer Work { uint work[]; };
layout(std430, set = 0, binding = 2) restrict readonly buffer Stale { uint stale[]; };

void main() {
  uint count = stale[stale_head(parameters.slot)];
  uint bit = 1u << (kStaleShift + parameters.slot);
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) {
    uint place = stale[stale_list(parameters.slot) + i];
    uint known = flags[place];
    flags[place] = known & ~bit;
    if ((known & kRowListed) != 0u) continue;
    uint at = atomicAdd(work[kEditRows], 1u);
    work[parameters.first_listed + at] = place;
    atomicMax(work[kEditForRows], groups_of(at + 1u));
  }
}
#endif

#ifdef KERNEL_edit_jobs
// Lists the patches around the vertices that an edit has reached, and those that are stale in its
// slot; forgets that, and says to the other slots what it has reached.
READ(0, uint, jobs)
layout(std430, set = 0, binding = 1) restrict buffer Flags { uint flags[]; };
layout(std430, set = 0, binding = 2) buffer Work { uint work[]; };
layout(std430, set = 0, binding = 3) buffer Stale { uint stale[]; };

// `segment`: where the search begins, since a vertex's jobs ascend.
uint segment_of(uint job, uint segment) {
  while (job >= work[segment + kSegmentEnd]) segment += kSegmentWords;
  return segment;
}

// A row that is no longer in the edit's list; the other slots get it, but those that have it.
void forget(uint place, bool is_moved) {
  uint known = flags[place] & ~kRowListed;
  for (uint slot = 0u; is_moved && slot < parameters.slot_count; ++slot) {
    uint bit = 1u << (kStaleShift + slot);
    if (slot == parameters.slot || (known & bit) != 0u) continue;
    known |= bit;
    uint head = stale_head(slot);
    uint at = atomicAdd(stale[head], 1u);
    stale[stale_list(slot) + at] = place;
    atomicMax(stale[head + kStaleArguments], groups_of(at + 1u));
  }
  flags[place] = known;
}

void main() {
  uint count = work[kEditRows];
  // The slot's own stale rows stand behind those that the edit has moved.
  uint moved_count = work[kEditHeld];
  if (gl_GlobalInvocationID.x == 0u) {
    uint head = stale_head(parameters.slot);
    stale[head] = 0u;
    stale[head + kStaleArguments] = 0u;
  }
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) {
    uint place = work[parameters.first_listed + i];
    forget(place, i < moved_count);
    uint instance = place / parameters.row_stride;
    uint row = place - instance * parameters.row_stride;
    uint end = jobs_at(row + 1u);
    uint begin = jobs_at(row);
    atomicAdd(work[kEditPatches], end - begin);
    uint segment = kEditHeadWords;
    for (uint k = begin; k < end; ++k) {
      uint job = jobs_at(k);
      segment = segment_of(job, segment);
      uint at = atomicAdd(work[segment], 1u);
      work[work[segment + kSegmentList] + at] = job + instance * parameters.job_count;
      atomicMax(work[segment + kSegmentArguments],
                groups_of((at + 1u) * work[segment + kSegmentChunks]));
    }
  }
}
#endif
