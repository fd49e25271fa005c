// The unit Newell normal of every face, +Z where it has no area; and how many corners it has.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
WRITE(3, vec4, face_normals);

void main() {
  FOR_ELEMENTS(f) {
    FairFace face = faces_at(f);
    vec3 origin = given_at(owners_at(face.first)).xyz;
    vec3 area = vec3(0.0);
    vec3 last = given_at(owners_at(face.first + 1u)).xyz - origin;
    for (uint i = 2u; i < face.count; ++i) {
      vec3 next = given_at(owners_at(face.first + i)).xyz - origin;
      area += cross(last, next);
      last = next;
    }
    face_normals[f] = vec4(normalised(area), float(face.count));
  }
}
