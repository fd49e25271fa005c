// The control points of every sector at a crease or boundary vertex, following the curve's handles.
// fair/crease_sector.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ_STORED(0, FairSector, sectors);
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, sector_normals)
READ(4, vec4, given_offsets)
READ(5, vec4, offsets)
READ(6, vec4, shifts)
UPDATE(7, vec4, result);

#include "fair_plane.glsl"
#include "fair_walk.glsl"

// Control points beside a sharp edge follow its handle, but not farther than this factor.
const float kLongestFactor = 1.3;
// The handle stands on the sector: no plane holds both.
const float kParallel = 1e-5;

Frame sector_frame(vec3 normal, vec3 handle) {
  float size = safe_length(handle);
  if (!(size > 0.0)) return frame_of(normal);
  vec3 along = handle / size;
  vec3 upright = normal - dot(normal, along) * along;
  float height = length(upright);
  return frame_of(height > kParallel ? upright / height : normal);
}

float handle_factor(float handle_length, vec3 edge) {
  float arm = safe_length(edge) / 4.0;
  return arm > 0.0 ? min(kLongestFactor, handle_length / arm) : 1.0;
}

float moved(float factor, float coordinate) {
  return (factor - 1.0) * coordinate * clamp(2.0 - abs(coordinate), 0.0, 1.0);
}

void main() {
  FOR_ELEMENTS(element) {
    uint s = kShared ? sectors[element].large : element;
    FairSector sector = sectors[s];
    if (!is_walked(sector.count)) continue;
    vec3 origin = given_at(sector.vertex).xyz;
    vec3 handle = result[sector.handle].xyz;
    float handle_length = safe_length(handle);
    vec4 shift = shifts_at(sector.crease);
    Frame frame = sector_frame(sector_normals_at(s).xyz, handle);
    FOR_RING(i, 0u, sector.count) {
      FairPlace place = places_at(sector.first + i);
      vec3 next = given_at(place.next).xyz - origin;
      vec3 previous = given_at(place.previous).xyz - origin;
      vec2 flat_next = project(frame, next), flat_previous = project(frame, previous);
      vec2 flat_point = project(frame, given_offsets_at(place.corner).xyz);
      Wedge wedge = wedge_of(flat_point, flat_next, flat_previous);
      if (wedge.valid) {
        float next_factor = i == 0u ? handle_factor(handle_length, next) : 1.0;
        float previous_factor =
            i + 1u == sector.count ? handle_factor(handle_length, previous) : 1.0;
        flat_point += wedge_share(flat_next, flat_previous) *
                      (moved(next_factor, wedge.along_next) * flat_next +
                       moved(previous_factor, wedge.along_previous) * flat_previous);
      }
      result[place.corner] = vec4(shift.w * (offsets_at(place.corner).xyz + shift.xyz) +
                                      (1.0 - shift.w) * lift(frame, flat_point),
                                  0.0);
    }
  }
}
