// The rows where the momentum leads, by area.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "bending.glsl"

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
