// The curves at crease and boundary vertices, the control points of the sectors beside them, and curve
// points at corners and darts.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

#ifdef KERNEL_fair_handles
// The two curve points at every crease or boundary vertex, on opposite sides of it, before fair_corridor.
// fair/vertex_polygon.h.
READ_STORED(0, FairCrease, creases);
READ(1, vec4, given)
READ(2, float, shares)
READ(3, vec4, points)
READ(4, vec4, face_normals)
WRITE(5, vec4, shifts);
WRITE(6, vec4, result);

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
#endif

#ifdef KERNEL_fair_corridor
// Curve points at crease and boundary vertices are drawn back where they lead too far into a face.
// fair/vertex_polygon.h.
READ_STORED(0, FairCrease, creases);
READ(1, vec4, given)
READ(2, FairPlace, places)
READ(3, vec4, face_normals)
READ(4, vec4, given_offsets)
UPDATE(5, vec4, result);

#include "fair_walk.glsl"

// How far a handle may lead into a face: of the way that the corner's own control point is from the curve, and
// of the other edge's distance.
const float kCorridor = 0.5, kCorridorOfEdge = 1.0 / 8.0;
const float kLeastCorridorFactor = 0.02;

// Wider corners than of 174 degrees in a triangle count as that.
const float kWidestSine = 0.1 / 6.0;

// In one face, between its sharp edge and its other one; `inward` at right angles to the former.
float face_factor(vec3 handle, vec3 sharp, vec3 inward, vec3 other, vec3 point) {
  float size = safe_length(inward);
  if (!(size > 0.0)) return 1.0;
  float lateral = dot(handle, inward / size);
  float most = min(kCorridor * dot(point, inward / size), kCorridorOfEdge * dot(other, inward / size));
  if (dot(other, sharp) < 0.0 || dot(other, inward) < 0.0)
    most = max(most, kCorridor * kWidestSine * safe_length(other));
  return most > 0.0 && lateral > most ? most / lateral : 1.0;
}

float corridor_factor(FairCrease crease, vec3 own, vec3 handle) {
  float factor = 1.0;
  FOR_RING(i, crease.first, crease.count) {
    FairPlace place = places_at(i);
    vec3 next = given_at(place.next).xyz - own, previous = given_at(place.previous).xyz - own;
    vec3 normal = face_normals_at(place.face).xyz, point = given_offsets_at(place.corner).xyz;
    if (place.next == crease.before || place.next == crease.after)
      factor = min(factor, face_factor(place.next == crease.before ? handle : -handle,
                                       next, cross(normal, next), previous, point));
    if (place.previous == crease.before || place.previous == crease.after)
      factor = min(factor, face_factor(place.previous == crease.before ? handle : -handle,
                                       previous, cross(previous, normal), next, point));
  }
  return max(ring_min(factor), kLeastCorridorFactor);
}

void main() {
  FOR_ELEMENTS(i) {
    FairCrease crease = creases[kShared ? creases[i].large : i];
    if (!is_walked(crease.count)) continue;
    vec3 handle = result[crease.curve0].xyz;
    float factor = corridor_factor(crease, given_at(crease.vertex).xyz, handle);
    if (!leads()) continue;
    result[crease.curve0] = vec4(factor * handle, 0.0);
    result[crease.curve1] = vec4(-factor * handle, 0.0);
  }
}
#endif

#ifdef KERNEL_fair_sectors
// The control points of every sector at a crease or boundary vertex, following the curve's handles.
// fair/vertex_polygon.h.
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
#endif

#ifdef KERNEL_fair_curve_points
// The curve points at corners, and at darts, where they stand between the corners beside them.
READ_STORED(0, FairCurvePoint, curve_points);
READ(1, vec4, given)
READ(2, vec4, points)
UPDATE(3, vec4, result);

void main() {
  FOR_ELEMENTS(s) {
    FairCurvePoint place = curve_points[s];
    uint target = parameters.place + s;
    if (place.kind == kCorner && parameters.darts_only == 0u)
      result[target] = vec4((points_at(place.other).xyz - given_at(place.vertex).xyz) / 4.0, 0.0);
    else if (place.kind == kDart)
      result[target] =
          vec4((result[place.after].xyz + result[place.before].xyz) / 2.0, 0.0);
  }
}
#endif
