// Positions and normals of the limit surface: at the rows of a table, or at the places of a list.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"

#ifdef KERNEL_apply_limit
#include "table.glsl"

READ(2, vec4, source)
layout(std430, set = 0, binding = 3) restrict writeonly buffer Target { float target[]; };
READ(4, vec2, derivatives)
#endif
#ifdef KERNEL_surface_places
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
#endif

#include "surface/unit_normal.glsl"

void write_vector(uint place, vec3 v) {
  target[place] = v.x;
  target[place + 1u] = v.y;
  target[place + 2u] = v.z;
}

#ifdef KERNEL_apply_limit
// Limit position and unit normal du x dv for every row; the normal is zero where it is undefined.
void main() {
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) return;
    ChunkRow at = chunk_row(chunk);
    if (at.row == kNoRow) return;
    precise vec3 position = vec3(0.0);
    precise vec3 du = vec3(0.0);
    precise vec3 dv = vec3(0.0);
    for (uint k = 0u; k < at.width; ++k) {
      uvec2 entry = entries_at(at.first + k * kChunkRows);
      vec2 slope = derivatives_at(at.first + k * kChunkRows);
      vec3 point = source_at(entry.x).xyz;
      position += uintBitsToFloat(entry.y) * point;
      du += slope.x * point;
      dv += slope.y * point;
    }
    uint place = (at.row - parameters.first_row) * parameters.target_stride +
                 parameters.first_target;
    write_vector(place, position);
    write_vector(place + parameters.normal_offset, unit_normal(du, dv));
  }
}
#endif

#ifdef KERNEL_surface_places
// The surface at the places of a list.
#include "surface/planish_surface.glsl"

void write(uint target_place, uint offset, vec3 v) {
  if (offset != kNone) write_vector(target_place + offset, v);
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
#endif
