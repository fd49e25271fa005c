// Before the steps: of smooth vertices the normal and of those on sharp curves the tangent, the rows
// without moves, and no moves.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "bending.glsl"

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
