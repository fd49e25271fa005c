// The control points of every corner that is to be cured, each in its own face's plane, and quarters of
// those that were. build_perpendicular_corner() of fair/perpendicular_curve.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, FairLinks, links)
READ(3, vec4, given)
READ(4, vec4, face_normals)
UPDATE(5, vec4, planes);
READ_STORED(6, uint, flags);
UPDATE_TOGETHER(7, vec4, result);

#include "fair_angles.glsl"
#include "fair_chain.glsl"
#include "fair_cure.glsl"
#include "fair_curve_sectors.glsl"
#include "fair_scale_ring.glsl"

const float kHalfTurn = 3.14159265;
// A sector that leaves less of a full turn than this on either side of the gap between its sharp
// edges, and of its outer faces less than a third, has them drawn apart.
const float kLeastGap = 5.0 * kHalfTurn / 180.0;
const float kGapShare = 1.0 / 3.0;
// Gaps as wide as this on either side are left as they are.
const float kWideGap = kHalfTurn / 4.0;
// Part of the reflex angle where the drawing begins.
const float kNearlyReflex = 0.9;
// A corner's sectors are told apart up to this one.
const uint kLastSectorBit = 1u << 20;
const float kReflexAngle = 7.0 * kHalfTurn / 6.0;
// 1 + cosine of the angle at a corner below which its control point moves away no farther.
const float kWidestAngle = 0.2;

vec3 origin;

float angle_of(uint i) {
  FairPlace place = places_at(i);
  vec3 a = unit_or_zero(given_at(place.next).xyz - origin);
  vec3 b = unit_or_zero(given_at(place.previous).xyz - origin);
  float sine = safe_length(cross(a, b)), cosine = dot(a, b);
  return sine == 0.0 && cosine == 0.0 ? 0.0 : atan(sine, cosine);
}

// How many faces of a reflex sector see its limit normal from behind.
float turned_faces(CurveSector sector) {
  vec3 normal = cross(result[sector.curve1].xyz, result[sector.curve0].xyz);
  float count = 0.0;
  FOR_RING(i, sector.first, sector.count)
    if (!(dot(normal, face_normals_at(places_at(i).face).xyz) > 0.0)) ++count;
  return ring_sum(count);
}

vec3 in_plane(vec3 v, vec3 normal) { return unit_or_zero(v - dot(v, normal) * normal); }

// Draws a curve point away from the gap's middle to its side, the one that `sign` says, by a share.
void draw(uint curve, vec3 direction, uint i, vec3 middle, vec3 side, float sign, float share) {
  float least = min(kLeastGap, kGapShare * angle_of(i));
  float sine = dot(direction, side), cosine = dot(direction, middle);
  float own = sine == 0.0 && cosine == 0.0 ? 0.0 : sign * atan(sine, cosine);
  float angle = max(own, least);
  share *= clamp((kWideGap - angle) / (kWideGap - least), 0.0, 1.0);
  vec3 offset = result[curve].xyz;
  vec3 drawn = safe_length(offset) * (cos(angle) * middle + sign * sin(angle) * side);
  if (leads()) result[curve] = vec4(offset + share * (drawn - offset), 0.0);
}

// Where the sharp edges on both sides of a reflex sector meet or cross, draws their curve points
// apart in its plane, wide gaps gradually less. Returns whether the sector is reflex.
bool open_sector(CurveSector sector) {
  uint last = sector.first + sector.count - 1u;
  float sum = 0.0;
  FOR_RING(i, sector.first, sector.count) sum += angle_of(i);
  sum = ring_sum(sum);
  float share = clamp((sum / kReflexAngle - kNearlyReflex) / (1.0 - kNearlyReflex), 0.0, 1.0);
  vec3 normal = angle_weighted_normal(origin, sector.first, sector.count);
  vec3 a = in_plane(result[sector.curve0].xyz, normal);
  vec3 b = in_plane(result[sector.curve1].xyz, normal);
  vec3 middle = unit_or_zero(a + b), side = cross(normal, middle);
  if (!(share > 0.0) || middle == vec3(0.0)) return false;
  ring_sync();
  draw(sector.curve0, a, sector.first, middle, side, 1.0, share);
  draw(sector.curve1, b, last, middle, side, -1.0, share);
  ring_sync();
  return sum > kReflexAngle;
}

// Whether opening the sector turns fewer faces back; does it then.
bool open_where_better(CurveSector sector) {
  vec4 own0 = result[sector.curve0], own1 = result[sector.curve1];
  float own_count = turned_faces(sector);
  if (open_sector(sector) && turned_faces(sector) < own_count) return true;
  if (leads()) {
    result[sector.curve0] = own0;
    result[sector.curve1] = own1;
  }
  ring_sync();
  return false;
}

void build(FairVertex vertex, uint v) {
  float size = planes[v].z;
  // Within the size at right angles, where the point is farther than the circle.
  float radius = size * sqrt(2.0) / 2.0;
  uint end = vertex.first + vertex.count;
  FOR_RING(i, vertex.first, vertex.count) {
    FairPlace place = places_at(i);
    vec3 next = unit_or_zero(given_at(place.next).xyz - origin);
    vec3 previous = unit_or_zero(given_at(place.previous).xyz - origin);
    float widening = max(1.0 + dot(next, previous), kWidestAngle);
    FairLinks beside = links_at(place.corner);
    result[place.corner] = vec4(radius / widening * (next + previous), 0.0);
    // Two lanes may write a curve point, the same to it.
    if (beside.before >= parameters.corner_count) result[beside.before] = vec4(radius * next, 0.0);
    if (beside.after >= parameters.corner_count) result[beside.after] = vec4(radius * previous, 0.0);
  }
  ring_sync();
  bool is_chosen = planes[v].x < uintBitsToFloat(kNoLeanBits);
  uint opened = is_chosen ? uint(planes[v].x) : 0u, bit = 1u;
  CurveSector sector;
  for (uint first = vertex.first; first < end && sector_from(first, end, sector);
       first += sector.count) {
    if (is_chosen && (opened & bit) != 0u)
      open_sector(sector);
    else if (!is_chosen && open_where_better(sector))
      opened |= bit;
    bit = min(2u * bit, kLastSectorBit);
  }
  ring_sync();
  if (leads()) planes[v].xy = vec2(float(opened), 0.0);
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i), word = flags[v];
    if ((word & kChanged) == 0u) continue;
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count) || vertex.kind != kCorner) continue;
    origin = given_at(v).xyz;
    if ((word & kRebuild) != 0u) build(vertex, v);
    float factor = quarters(word);
    if (factor < 1.0) scale_ring(vertex, factor);
  }
}
