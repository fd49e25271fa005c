// The height of every face over its longest side, 0 where it has no area; polygons count half, as they
// narrow towards it. least_height() of fair/perpendicular_polygon.cpp.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
WRITE(3, float, heights);

#include "fair_walk.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    vec3 origin = given_at(owners_at(face.first)).xyz;
    vec3 area = vec3(0.0), last = vec3(0.0);  // twice the area
    if (kShared) last = given_at(owners_at(face.first + walk_begin(face.count) % face.count)).xyz - origin;
    float longest = 0.0;
    FOR_RING(c, 1u, face.count) {
      uint corner = c == face.count ? face.first : face.first + c;
      vec3 next = given_at(owners_at(corner)).xyz - origin;
      area += cross(last, next);
      longest = max(longest, safe_length(next - last));
      last = next;
    }
    area = ring_sum(area);
    longest = ring_max(longest);
    if (!leads()) continue;
    heights[f] = longest > 0.0 ? safe_length(area) / longest / (face.count > 3u ? 2.0 : 1.0) : 0.0;
  }
}
