// The unit Newell normal of every face, +Z where it has no area; and how many corners it has.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
WRITE(3, vec4, face_normals);

#include "fair_walk.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    vec3 origin = given_at(owners_at(face.first)).xyz;
    vec3 area = vec3(0.0);
    uint begin = 1u + walk_begin(face.count - 2u);
    vec3 last = given_at(owners_at(face.first + begin)).xyz - origin;
    FOR_RING(c, 2u, face.count - 2u) {
      vec3 next = given_at(owners_at(face.first + c)).xyz - origin;
      area += cross(last, next);
      last = next;
    }
    area = ring_sum(area);
    if (leads()) face_normals[f] = vec4(normalised(area), float(face.count));
  }
}
