// Flags crease and boundary vertices where a sector's limit normal is turned from its faces, and corners
// whose next control points leave their faces; neither twice, as no size changes that.
// least_sector_cosine() and farthest_fan_point() of fair/perpendicular_curve.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, FairLinks, links)
READ(3, vec4, given)
READ(4, vec4, face_normals)
READ(5, vec4, result)
UPDATE(6, uint, flags);
READ_STORED(7, uint, decisions);

#include "fair_cure.glsl"
#include "fair_curve_sectors.glsl"

const float kLeastSectorCosine = 0.05;
// Of the way to a face's opposite side.
const float kFarthestFan = 0.5;
const float kHalfTurn = 3.14159265;
// Sine of an angle between edges below which they hold no wedge.
const float kLeastSine = 1e-6;

float least_cosine(CurveSector sector) {
  vec3 across = vec3(0.0);
  FOR_RING(i, 0u, sector.count)
    across += sin(kHalfTurn * (float(i) + 0.5) / float(sector.count)) *
              result_at(places_at(sector.first + i).corner).xyz;
  across = ring_sum(across);
  vec3 along = result_at(sector.curve0).xyz - result_at(sector.curve1).xyz;
  vec3 normal = unit_or_zero(cross(along, across));
  float least = 1.0;
  FOR_RING(i, sector.first, sector.count)
    least = min(least, dot(normal, face_normals_at(places_at(i).face).xyz));
  return ring_min(least);
}

// The sum of a point's parts along two edges, in the sense of least squares: 1 on the line between
// their ends.
float part_of_wedge(vec3 point, vec3 next, vec3 previous) {
  float length0 = safe_length(next), length1 = safe_length(previous);
  if (!(length0 > 0.0 && length1 > 0.0)) return 0.0;
  vec3 a = next / length0, b = previous / length1, normal = cross(a, b);
  float square = dot(normal, normal);
  if (!(square > kLeastSine * kLeastSine)) return 0.0;
  return (dot(cross(point, b), normal) / length0 + dot(cross(a, point), normal) / length1) / square;
}

float farthest_fan_point(vec3 origin, CurveSector sector) {
  vec3 point0 = result_at(sector.curve0).xyz, point1 = result_at(sector.curve1).xyz;
  float farthest = 0.0;
  FOR_RING(i, 0u, sector.count) {
    FairPlace place = places_at(sector.first + i);
    float angle = (float(i) + 0.5) / float(sector.count) * (kHalfTurn / 2.0);
    vec3 fan = sqrt(2.0) * (cos(angle) * point0 + sin(angle) * point1);
    vec3 point = (fan + result_at(place.corner).xyz) / 4.0;
    farthest = max(farthest, part_of_wedge(point, given_at(place.next).xyz - origin,
                                           given_at(place.previous).xyz - origin));
  }
  return ring_max(farthest);
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i), word = flags[v];
    if ((word & kTouched) == 0u || (word & kBad) != 0u || decisions[v] >> kCureShift != 0u) continue;
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count) || has_polygon(vertex)) continue;
    uint end = vertex.first + vertex.count;
    CurveSector sector;
    for (uint first = vertex.first; first < end && sector_from(first, end, sector);
         first += sector.count) {
      bool bad = vertex.kind == kCrease ? least_cosine(sector) < kLeastSectorCosine
                                        : farthest_fan_point(given_at(v).xyz, sector) > kFarthestFan;
      if (bad && leads()) flags[v] = word | kBad;
    }
  }
}
