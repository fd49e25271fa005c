// The surface at the places of a list.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { PlaceParameters parameters; };

// The host's, of any stride and content.
layout(std430, set = 0, binding = 0) restrict readonly buffer places_block { uint places[]; };
READ(1, uint, planish_words)
READ(2, uvec2, planish_links)
READ(3, vec4, planish_state)
READ(4, vec4, planish_given)
READ(5, vec4, planish_weights)
WRITE(6, float, target);

#include "surface/planish_surface.glsl"

void write(uint target_place, uint offset, vec3 v) {
  if (offset == kNone) return;
  target[target_place + offset] = v.x;
  target[target_place + offset + 1u] = v.y;
  target[target_place + offset + 2u] = v.z;
}

void write_place(uint target_place, vec3 position, vec3 normal, vec3 du, vec3 dv, vec3 duu, vec3 duv,
                 vec3 dvv, uint what) {
  write(target_place, parameters.position, position);
  write(target_place, parameters.normal, normal);
  write(target_place, parameters.du, du);
  write(target_place, parameters.dv, dv);
  write(target_place, parameters.duu, duu);
  write(target_place, parameters.duv, duv);
  write(target_place, parameters.dvv, dvv);
  if (parameters.state != kNone) target[target_place + parameters.state] = uintBitsToFloat(what);
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= parameters.count) return;
  uint target_place = parameters.first_target + i * parameters.target_stride;
  uint word = parameters.first_place + i * parameters.place_stride;
  const vec3 zero = vec3(0.0);
  PlanishPlace place;
  if (!planish_find_place(parameters.face_count, places[word], uintBitsToFloat(places[word + 1u]),
                          uintBitsToFloat(places[word + 2u]), place)) {
    write_place(target_place, zero, zero, zero, zero, zero, zero, zero, kPlaceNone);
    return;
  }
  PlanishPoint at = planish_evaluate(parameters.face_count, place);
  write_place(target_place, at.position, at.normal, at.du, at.dv, at.duu, at.duv, at.dvv,
              at.is_singular ? kPlaceSingular : kPlaceRegular);
}
