// A step against the gradient, back to within the bound, with momentum: Beck & Teboulle 2009. The
// last one moves the points.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "bending.glsl"

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
