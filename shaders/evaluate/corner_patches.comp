// Limit points and unit normals of corner patches, of all, of those that an edit has listed, or of the
// instances that a level's list names: for each the weighted sums of its control points, relative to
// its own point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 1) const uint kUnitsPerGroup = 1u;
layout(constant_id = 3) const uint kGather = kGatherList;
layout(constant_id = 4) const uint kSamples = 1u;
layout(constant_id = 5) const uint kPositionFormat = kFormatFloat3;
layout(constant_id = 6) const uint kNormalFormat = kFormatFloat3;
layout(constant_id = 7) const uint kTangentFormat = kFormatNone;
// What attributes would be written through is what positions are.
layout(constant_id = 8) const bool kIsInterleaved = false;
layout(push_constant) uniform Parameters { CornerPatchParameters parameters; };

READ(0, uvec4, groups)
READ(1, uint, words)
READ(2, uvec2, links)
READ(3, vec4, state)
READ(4, vec4, given)
READ(5, vec4, weights)
WRITE(6, uint, target);
#ifdef KERNEL_corner_patches
WRITE(7, uint, attributes);
#else
#define attributes target
layout(std430, set = 0, binding = 7) restrict readonly buffer Work { uint work[]; };
#endif

// Software devices pay more for barriers than for stores apart.
#if !defined(KERNEL_listed_patches) && !defined(PLANISH_TEXEL)
#define PLANISH_STAGED
// Rows go by way of the work group, whose lanes then write neighbouring words: from a lane each, words
// are a row and more apart.
const uint kPositionWords = kPositionFormat == kFormatFloat3 ? 3u : 2u;
const uint kNormalWords =
    kNormalFormat == kFormatNone ? 0u : kNormalFormat == kFormatFloat3 ? 3u : 1u;
const uint kTangentWords =
    kTangentFormat == kFormatNone ? 0u : kTangentFormat == kFormatFloat4 ? 4u : 1u;
const uint kRowWords = kPositionWords + kNormalWords + kTangentWords;
shared uint staged[kPatchLanes * kSamples * kRowWords];
shared uint staged_rows[kPatchLanes];
#define POSITIONS staged
#define ATTRIBUTES staged
#else
#define POSITIONS target
#define ATTRIBUTES attributes
#endif

#include "surface/unit_normal.glsl"
#include "evaluate/vertex_formats.glsl"

PatchGroup group_of(uint i) {
  uvec4 a = groups_at(i * kGroupVectors);
  uvec4 b = groups_at(i * kGroupVectors + 1u);
  uvec4 c = groups_at(i * kGroupVectors + 2u);
  return PatchGroup(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z, c.w);
}

// The corner counter-clockwise at the same vertex, and the next one in the face.
uvec2 link_of(uint corner) { return links_at(corner); }
// Where the instance's points of the state, given points, positions and normals begin.
uint first_point, first_given, first_position, first_normal;
vec4 point_of(uint i) { return state_at(first_point + i); }
vec3 vertex_of(vec4 point) {
  uint vertex = floatBitsToUint(point.w) & ~kVertexTag;
  return given_at(first_given + vertex).xyz;
}

vec4 own;
vec3 own_vertex;

// Software devices take one way at a time, and pay for each branch that is not taken; for others ways
// are joined, see PatchGroup.
#ifdef PLANISH_TEXEL
const uint sample_count = kSamples;
#define GATHER_OF(group) kGather
#define FOR_CHUNKS(group, number) uint chunk = number;
#else
uint sample_count;  // of the group, at most kSamples
#define GATHER_OF(group) ((group).form & 15u)
#define FOR_CHUNKS(group, number)                                      \
  sample_count = ((group).form >> kFormSamples) & 15u;                 \
  uint chunk = ((group).form >> kFormBlock) * kBlockChunks;            \
  uint end_chunk = chunk + (((group).form >> kFormChunks) & 255u);     \
  for (; chunk < end_chunk; ++chunk)
#endif
uint next_weight;
vec3 position[kSamples], du[kSamples], dv[kSamples];

void begin(uint i) {
  own = point_of(i);
  own_vertex = vertex_of(own);
  for (uint s = 0u; s < kSamples; ++s) position[s] = du[s] = dv[s] = vec3(0.0);
}

// The next column's point: an offset from a vertex that itself is `vertex` away from the own one.
void add(vec3 vertex, vec4 point) {
  precise vec3 x = vertex + (point.xyz - own.xyz);
  for (uint s = 0u; s < kSamples; ++s) {
    if (s >= sample_count) break;
    vec3 weight = weights_at(next_weight + s).xyz;
    // Both sides of a cut get the same bits, whatever kernel makes them.
    precise vec3 sum = position[s] + weight.x * x;
    position[s] = sum;
    du[s] += weight.y * x;
    dv[s] += weight.z * x;
  }
  next_weight += sample_count;
}

vec3 away(vec4 point) {
  precise vec3 vertex = vertex_of(point) - own_vertex;
  return vertex;
}

// Loops end at their head: lanes of a list have rings and faces of several sizes, see vulkan/details.md.
void gather_ring(uint corner, uint follow, uint count) {
  for (uint i = 1u; i < count; ++i) {
    add(vec3(0.0), point_of(corner));
    corner = follow;
    if (i + 1u < count) follow = link_of(corner).x;
  }
}

void gather_corner(uint corner, PatchGroup group) {
  begin(corner);
  uvec2 link = link_of(corner);
  uvec2 across = link_of(link.x);
  gather_ring(link.x, across.x, group.ring);
  uint in_face = link.y;
  uvec2 next = link_of(in_face);
  uint beyond_leading = next.x;
  vec3 first_vertex, last_vertex;
  for (uint i = 1u; i < group.face; ++i) {
    vec4 point = point_of(in_face);
    last_vertex = away(point);
    if (i == 1u) first_vertex = last_vertex;
    add(last_vertex, point);
    if (i + 1u < group.face) {
      in_face = next.y;
      next = link_of(in_face);
    }
  }
  add(first_vertex, point_of(beyond_leading));
  add(last_vertex, point_of(across.y));
}

void gather_face(uint corner, uint count) {
  begin(corner);
  for (uint i = 1u; i < count; ++i) {
    corner = link_of(corner).y;
    vec4 point = point_of(corner);
    add(away(point), point);
  }
}

// Around the midpoint of the corner's leading edge.
void gather_edge(uint corner) {
  uint end = link_of(corner).y;
  begin(end);
  uint other = link_of(end).x;
  vec4 point = point_of(corner);
  vec3 vertex = away(point);
  add(vertex, point);
  add(vertex, point_of(link_of(other).y));
  add(vec3(0.0), point_of(other));
}

void gather_list(uint word, uint columns) {
  begin(words_at(word));
  for (uint k = 1u; k <= columns; ++k) {
    vec4 point = point_of(words_at(word + k * kPatchLanes));
    add(away(point), point);
  }
}

// `frame`: the word where the lane's frames begin.
void write_rows(uint row, uint flags, uint frame) {
#ifdef PLANISH_STAGED
  staged_rows[gl_LocalInvocationIndex] = row;
#endif
  for (uint s = 0u; s < kSamples; ++s, frame += 2u * kPatchLanes) {
    if (s >= sample_count) break;
#ifdef PLANISH_STAGED
    uint position_at = (gl_LocalInvocationIndex * sample_count + s) * kRowWords;
    uint normal_at = position_at + kPositionWords, tangent_at = normal_at + kNormalWords;
#else
    uint place = row + s - parameters.first_row;
    uint position_at = first_position + place * parameters.position_stride;
    uint normal_at = first_normal + place * parameters.normal_stride;
    uint tangent_at = normal_at + parameters.tangent_shift;
#endif
    precise vec3 limit = own_vertex + (own.xyz + position[s]);
    if ((flags & kHasPositions) != 0u) write_position(position_at, limit);
    if (kNormalFormat == kFormatNone || (flags & kHasNormals) == 0u) continue;
    vec3 normal = unit_normal(du[s], dv[s]);
    write_normal(normal_at, normal);
    if (kTangentFormat == kFormatNone) continue;
    uint along = words_at(frame + kPatchLanes);
    write_tangent(tangent_at,
                  unit_tangent(uintBitsToFloat(words_at(frame)) * du[s] +
                               uintBitsToFloat(along) * dv[s], normal),
                  (along & 1u) != 0u ? -1.0 : 1.0);
  }
}

// An instance's points, and the place among the instances' vertices where its own go.
void begin_instance(uint instance, uint place) {
  first_point = instance * parameters.instance_points;
  first_given = instance * parameters.instance_rows;
  first_position = parameters.first_position + place * parameters.position_instance;
  first_normal = parameters.first_normal + place * parameters.normal_instance;
}

// A chunk of samples of a group's patch.
void evaluate_patch(PatchGroup group, uint lane, uint chunk) {
  uint word = group.first_word - parameters.first_word + lane;
  uint corner = group.corner + lane * group.corner_step;
  if ((group.flags & kCornersAreWords) != 0u) {
    corner = words_at(word);
    word += kPatchLanes;
  }
  uint row = group.row + group.row_step * ((group.flags & kRowsFollowCorners) != 0u
                                               ? corner - group.corner
                                               : lane);
  if ((group.flags & kRowsAreWords) != 0u) {
    row = words_at(word);
    word += kPatchLanes;
  }
  next_weight = group.first_weight - parameters.first_weight +
                chunk * group.columns * sample_count;
  uint gather = GATHER_OF(group);
  if (gather == kGatherCorner) {
    gather_corner(corner, group);
  } else if (gather == kGatherVertex) {
    begin(corner);
    uint next = link_of(corner).x;
    gather_ring(next, link_of(next).x, group.ring);
  } else if (gather == kGatherFace) {
    gather_face(corner, group.face);
  } else if (gather == kGatherEdge) {
    gather_edge(corner);
  } else {
    gather_list(word, group.columns);
    word += (group.columns + 1u) * kPatchLanes;
  }
  write_rows(row + chunk * sample_count, group.flags,
             word + chunk * sample_count * 2u * kPatchLanes);
}

#ifdef PLANISH_STAGED
// The rows of all lanes, word by word.
void store_rows(PatchGroup group) {
  barrier();
  uint words = group.lane_count * sample_count * kRowWords;
  for (uint i = gl_LocalInvocationIndex; i < words; i += kPatchLanes) {
    uint row = i / kRowWords, word = i % kRowWords;
    bool is_position = word < kPositionWords;
    if ((group.flags & (is_position ? kHasPositions : kHasNormals)) == 0u) continue;
    uint lane = sample_count == kSamples ? row / kSamples : row;
    uint place = staged_rows[lane] + (row - lane * sample_count) - parameters.first_row;
    uint at = first_position + place * parameters.position_stride + word;
    if (!is_position) {
      word -= kPositionWords;
      if (word >= kNormalWords) word += parameters.tangent_shift - kNormalWords;
      at = first_normal + place * parameters.normal_stride + word;
    }
    if (kIsInterleaved || is_position)
      target[at] = staged[i];
    else
      attributes[at] = staged[i];
  }
  // Before the next group's rows take their places.
  barrier();
}
#endif

// All patches of the dispatch, a lane each, a chunk of samples after the other.
void evaluate_units() {
  uint lane = gl_LocalInvocationIndex;
  for (uint i = 0u; i < kUnitsPerGroup; ++i) {
    uint unit = gl_WorkGroupID.x * kUnitsPerGroup + i;
    if (unit >= parameters.unit_count) return;
    PatchGroup group = group_of(parameters.first_group + unit / parameters.chunk_count);
    FOR_CHUNKS(group, unit % parameters.chunk_count) {
      if (lane < group.lane_count) evaluate_patch(group, lane, chunk);
#ifdef PLANISH_STAGED
      store_rows(group);
#endif
    }
  }
}

#ifdef KERNEL_corner_patches
// All of them, a group after the other.
void main() {
  begin_instance(gl_WorkGroupID.y, gl_WorkGroupID.y);
  evaluate_units();
}
#endif

#ifdef KERNEL_listed_patches
// Those that an edit has listed.
void main() {
  uint chunk_count = parameters.chunk_count;
  uint count = work[parameters.segment] * chunk_count;
  uint list = work[parameters.segment + kSegmentList];
  uint lanes = gl_NumWorkGroups.x * kPatchLanes;
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lanes) {
    uint job = work[list + i / chunk_count];
    uint instance = job / parameters.job_count;
    job -= instance * parameters.job_count;
    begin_instance(instance, instance);
    PatchGroup group = group_of(job / kPatchLanes);
    FOR_CHUNKS(group, i % chunk_count)
      evaluate_patch(group, job % kPatchLanes, chunk);
  }
}
#endif

#ifdef KERNEL_instance_patches
// Of the instances that a level's list names, one after another.
void main() {
  begin_instance(work[parameters.segment + kDrawnWords * gl_WorkGroupID.y], gl_WorkGroupID.y);
  evaluate_units();
}
#endif
