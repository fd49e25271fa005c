// Moves given points to where the mesh bends least: directions once, then rows and a step in turn;
// twins of fair/least_bending.cpp. An invocation does every so many vertices of one instance.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { BendingParameters parameters; };

#define FOR_VERTICES(v)                                                 \
  for (uint v = gl_GlobalInvocationID.x; v < parameters.count; \
       v += gl_NumWorkGroups.x * gl_WorkGroupSize.x)

READ(0, uvec4, vertices)
READ(1, uvec2, entries)

BendingVertex vertex_at(uint v) {
  uvec4 words = vertices_at(v);
  return BendingVertex(words.x, words.y, uintBitsToFloat(words.z), uintBitsToFloat(words.w));
}
uint end_of(BendingVertex vertex) { return vertex.first + (vertex.word >> kBendingCountShift); }
uint kind_of(BendingVertex vertex) { return vertex.word & kBendingKind; }
bool is_smooth(uint kind) { return kind == kSmooth || kind == kDart; }

// What a vertex may move by.
vec3 allowed(uint kind, vec3 direction, vec3 vector) {
  vec3 along = direction * dot(direction, vector);
  if (is_smooth(kind)) return along;
  return kind == kCrease ? vector - along : vec3(0.0);
}

#ifdef KERNEL_bending_directions
// Before the steps: of smooth vertices the normal and of those on sharp curves the tangent, the rows
// without moves, and no moves.
READ(2, vec4, points)
WRITE(3, vec4, directions);
WRITE(4, vec4, base);
WRITE(5, vec4, moves);
WRITE(6, vec4, ahead);

vec3 unit_or_zero(vec3 v) {
  float size = max(max(abs(v.x), abs(v.y)), abs(v.z));
  return size > 0.0 ? normalize(v / size) : vec3(0.0);
}

void main() {
  uint instance = gl_WorkGroupID.y * parameters.instance_rows;
  FOR_VERTICES(v) {
    BendingVertex vertex = vertex_at(v);
    uint end = end_of(vertex);
    vec3 own = points_at(instance + v).xyz;
    bool on_curve = kind_of(vertex) == kCrease;
    vec3 row = vec3(0.0), sum = vec3(0.0), first = vec3(0.0), last = vec3(0.0);
    float sign = 1.0;
    for (uint i = vertex.first; i < end; ++i) {
      uvec2 entry = entries_at(i);
      vec3 offset = points_at(instance + entry.x).xyz - own;
      float weight = uintBitsToFloat(entry.y);
      row += weight * offset;
      offset /= parameters.unit;
      if (!on_curve) {
        if (i == vertex.first)
          first = offset;
        else
          sum += cross(last, offset);
      } else if (weight > 0.0) {
        sum += sign * offset;
        sign = -sign;
      }
      last = offset;
    }
    if (!on_curve && (vertex.word & kBendingClosed) != 0u) sum += cross(last, first);
    directions[instance + v] = vec4(unit_or_zero(sum), 0.0);
    base[instance + v] = vec4(row, 0.0);
    moves[instance + v] = vec4(0.0);
    ahead[instance + v] = vec4(0.0);
  }
}
#endif

#ifdef KERNEL_bending_rows
// The rows where the momentum leads, by area.
READ(2, vec4, directions)
READ(3, vec4, base)
READ(4, vec4, ahead)
WRITE(5, vec4, rows);

void main() {
  uint instance = gl_WorkGroupID.y * parameters.instance_rows;
  FOR_VERTICES(v) {
    BendingVertex vertex = vertex_at(v);
    uint end = end_of(vertex);
    vec3 own = ahead_at(instance + v).xyz, row = base_at(instance + v).xyz;
    for (uint i = vertex.first; i < end; ++i) {
      uvec2 entry = entries_at(i);
      row += uintBitsToFloat(entry.y) * (ahead_at(instance + entry.x).xyz - own);
    }
    row = allowed(kind_of(vertex), directions_at(instance + v).xyz, row);
    rows[instance + v] = vec4(vertex.inverse_area * row, 0.0);
  }
}
#endif

#ifdef KERNEL_bending_step
// A step against the gradient, back to within the bound, with momentum: Beck & Teboulle 2009. The
// last one moves the points.
READ(2, float, theirs)
READ(3, vec4, directions)
READ(4, vec4, rows)
layout(std430, set = 0, binding = 5) restrict buffer Moves { vec4 moves[]; };
layout(std430, set = 0, binding = 6) restrict buffer Ahead { vec4 ahead[]; };
layout(std430, set = 0, binding = 7) restrict buffer Points { vec4 points[]; };

void main() {
  uint instance = gl_WorkGroupID.y * parameters.instance_rows;
  FOR_VERTICES(v) {
    BendingVertex vertex = vertex_at(v);
    uint end = end_of(vertex);
    vec3 own = rows_at(instance + v).xyz, gradient = vec3(0.0);
    for (uint i = vertex.first; i < end; ++i) {
      uvec2 entry = entries_at(i);
      gradient +=
          theirs_at(i) * rows_at(instance + entry.x).xyz - uintBitsToFloat(entry.y) * own;
    }
    vec3 next = ahead[instance + v].xyz -
                vertex.step * allowed(kind_of(vertex), directions_at(instance + v).xyz, gradient);
    float size = length(next);
    if (size > parameters.bound) next *= parameters.bound / size;
    if (parameters.is_last != 0u) {
      points[instance + v].xyz += next;
    } else {
      ahead[instance + v] = vec4(next + parameters.momentum * (next - moves[instance + v].xyz), 0.0);
      moves[instance + v] = vec4(next, 0.0);
    }
  }
}
#endif
