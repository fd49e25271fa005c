// The unit normal of every sector at a crease or boundary vertex: its corners' weighted by angles, or
// that of the plane there.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ_STORED(0, FairSector, sectors);
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, face_normals)
WRITE(4, vec4, normals);

#include "fair_angles.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint s = kShared ? sectors[i].large : i;
    FairSector sector = sectors[s];
    if (!is_walked(sector.count)) continue;
    vec3 origin = given_at(sector.vertex).xyz;
    vec3 normal = sector.plane != 0u
                      ? face_normals_at(sector.plane - 1u).xyz
                      : angle_weighted_normal(origin, sector.first, sector.count);
    if (leads()) normals[s] = vec4(normal, 0.0);
  }
}
