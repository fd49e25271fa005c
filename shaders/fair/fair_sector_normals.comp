// The unit normal of every sector at a crease or boundary vertex: its corners' weighted by angles.
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
  FOR_ELEMENTS(s) {
    FairSector sector = sectors[s];
    vec3 origin = given_at(sector.vertex).xyz;
    normals[s] = vec4(angle_weighted_normal(origin, sector.first, sector.count), 0.0);
  }
}
