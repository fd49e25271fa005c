// The unit Newell normal of every face; +Z where it has no area.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairFace, faces);
READ(1, FairCorner, corners);
READ(2, vec4, given);
WRITE(3, vec4, face_normals);

void main() {
  FOR_ELEMENTS(f) {
    FairFace face = faces[f];
    vec3 origin = given[corners[face.first].vertex].xyz;
    vec3 area = vec3(0.0);
    vec3 last = given[corners[face.first + 1u].vertex].xyz - origin;
    for (uint i = 2u; i < face.count; ++i) {
      vec3 next = given[corners[face.first + i].vertex].xyz - origin;
      area += cross(last, next);
      last = next;
    }
    face_normals[f] = vec4(normalised(area), 0.0);
  }
}
