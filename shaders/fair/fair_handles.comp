// The two curve points at every crease or boundary vertex, on opposite sides of it, before fair_corridor.
// fair/crease_handle.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ_STORED(0, FairCrease, creases);
READ(1, vec4, given)
READ(2, float, shares)
READ(3, vec4, points)
READ(4, vec4, face_normals)
WRITE(5, vec4, shifts);
WRITE(6, vec4, result);

#include "fair_crease.glsl"

// A handle may pass the shorter arm by this factor.
const float kLongestFactor = 1.15;

vec3 crease_handle(CreaseArms arms) {
  float before = safe_length(arms.before), after = safe_length(arms.after);
  if (!(before > 0.0) || !(after > 0.0)) return vec3(0.0);
  // Along arms.before / before^2 - arms.after / after^2, whose squares might leave the floats.
  vec3 direction = arms.before / before * (after / before) - arms.after / after;
  float size = safe_length(direction);
  if (!(size > 0.0)) return vec3(0.0);  // a cusp: both arms the same way
  return direction *
         (min((before + after) / 2.0, kLongestFactor * min(before, after)) / size);
}

// Square of the sine between planes: below it they have no line in common.
const float kParallelPlanes = 1e-4;

// The handle in the planes of the vertex's sectors.
vec3 in_planes(FairCrease crease, vec3 handle) {
  if (crease.plane0 == 0u) return handle;
  vec3 normal = face_normals_at(crease.plane0 - 1u).xyz;
  vec3 flat_handle = handle - dot(handle, normal) * normal;
  if (crease.plane1 == 0u) return flat_handle;
  vec3 line = cross(normal, face_normals_at(crease.plane1 - 1u).xyz);
  float square = dot(line, line);
  return square > kParallelPlanes ? dot(handle, line) / square * line : flat_handle;
}

void main() {
  FOR_ELEMENTS(i) {
    FairCrease crease = creases[i];
    vec3 own = given_at(crease.vertex).xyz;
    CreaseArms arms =
        CreaseArms((given_at(crease.before).xyz - own) / 4.0, (given_at(crease.after).xyz - own) / 4.0);
    float share = shares_at(crease.vertex);
    vec3 handle = crease_handle(arms), shift = vec3(0.0);
    if (share > 0.0) {
      vec3 before = points_at(crease.before).xyz, after = points_at(crease.after).xyz;
      vec3 point = points_at(crease.vertex).xyz;
      handle = share * (before - after) / 8.0 + (1.0 - share) * handle;
      shift = (own - point) - ((before - point) + (after - point)) / 8.0;
    }
    handle = in_planes(crease, handle);
    shifts[i] = vec4(shift, share);
    result[crease.curve0] = vec4(handle, 0.0);
    result[crease.curve1] = vec4(-handle, 0.0);
  }
}
