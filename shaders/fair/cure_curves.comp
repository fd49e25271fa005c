// The cure at vertices with sharp edges: perpendicular chains at creases, corners' control points.
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
#ifdef KERNEL_fair_cure_corners
#include "fair_chain.glsl"
#endif
#include "fair_cure.glsl"
#include "fair_curve_sectors.glsl"

const float kHalfTurn = 3.14159265;

// The vertex that is done.
vec3 origin;

// Scales all control points of a vertex with sharp edges, those on its curves too;
// scale_curve_vertex() of fair/perpendicular_polygon.h.
void scale_ring(FairVertex vertex, float factor) {
  ring_sync();
  // The curve points that the first sector begins and the last one ends with.
  uint begins = links_at(places_at(vertex.first).corner).before;
  uint last = links_at(places_at(vertex.first + vertex.count - 1u).corner).after;
  FOR_RING(i, vertex.first, vertex.count) {
    uint corner = places_at(i).corner;
    uint before = links_at(corner).before;
    result[corner].xyz *= factor;
    if (before >= parameters.corner_count) result[before].xyz *= factor;
  }
  if (leads() && last >= parameters.corner_count && last != begins) result[last].xyz *= factor;
}

#ifdef KERNEL_fair_cure_creases
// The perpendicular chains of every crease or boundary vertex that is to have them, and quarters of those
// that have. build_perpendicular_crease() of fair/perpendicular_polygon.h.

// Of the highest that the edges reach across the curve: what they are balanced about.
const float kAcrossShare = 0.5;
// Edges that reach less far across the curve than this, times chain_share()'s own ramp, leave its
// chain gradually: at 0 there is none.
const float kFullRise = 0.4;

// The sector that is done, its plane, and what its edges are balanced about.
CurveSector sector;
vec3 along, across;
float rise, spread;
// The angles about the curve by which the planes of the vertex's sectors lean.
vec2 leans;
bool is_chosen;

// Unit; zero where the edge stands on the plane.
vec2 edge_direction(uint i) {
  uint end = i < sector.count ? places_at(sector.first + i).next
                              : places_at(sector.first + sector.count - 1u).previous;
  vec3 edge = given_at(end).xyz - origin;
  vec3 flat_edge = vec3(dot(edge, along), dot(edge, across), 0.0);
  return unit_or_zero(flat_edge).xy;
}
vec2 balance_point(uint i) {
  vec2 edge = edge_direction(i);
  return vec2(edge.x, (edge.y - rise) / spread);
}
#include "fair_balance.glsl"
#include "fair_chain.glsl"

// Among directions at right angles to the curve.
vec4 worst_seen(vec3 direction) {
  vec4 worst = vec4(0.0, 0.0, 0.0, 2.0);
  FOR_RING(i, sector.first, sector.count) {
    vec3 normal = face_normals_at(places_at(i).face).xyz;
    normal -= dot(normal, along) * along;
    float cosine = dot(direction, normal);
    if (cosine < worst.w) worst = vec4(normal, cosine);
  }
  return ring_least(worst);
}
vec3 as_view(vec3 v, vec3 otherwise) {
  vec3 upright = unit_or_zero(v - dot(v, along) * along);
  return upright == vec3(0.0) ? otherwise : upright;
}
#include "fair_view.glsl"

// Where the convex hull of the edges' directions crosses the line across the curve, the farther of
// the two times; 0 where they all lie to one side. Of unit vectors those nearest to the line make it.
float highest_across() {
  vec2 right = vec2(-1.0), left = vec2(1.0);  // none
  FOR_RING(i, 0u, sector.count + 1u) {
    vec2 edge = edge_direction(i);
    if (edge.x >= 0.0 && (right.x < 0.0 || edge.y > right.y)) right = edge;
    if (edge.x < 0.0 && (left.x >= 0.0 || edge.y > left.y)) left = edge;
  }
  right = ring_least(vec4(right, 0.0, right.x < 0.0 ? INFINITE : -right.y)).xy;
  left = ring_least(vec4(left, 0.0, left.x >= 0.0 ? INFINITE : -left.y)).xy;
  if (right.x < 0.0 || left.x >= 0.0) return 0.0;
  precise float slope = (right.x * left.y - left.x * right.y) / (right.x - left.x);
  return max(slope, 0.0);
}

// The normal of the sector's plane: its faces', about the curve by the angle that is to be chosen where
// it is not yet.
vec3 sector_normal(bool is_first) {
  vec3 weighted = angle_weighted_normal(origin, sector.first, sector.count);
  vec3 own = as_view(weighted, weighted), left = cross(along, own);
  if (!is_chosen) {
    vec3 tilted = turned_to_see(own);
    float angle = tilted == own ? 0.0 : atan(dot(tilted, left), dot(tilted, own));
    if (is_first)
      leans.x = angle;
    else
      leans.y = angle;
  }
  float lean = is_first ? leans.x : leans.y;
  return lean == 0.0 ? own : cos(lean) * own + sin(lean) * left;
}

void enter(CurveSector at, FairVertex vertex, vec3 direction) {
  sector = at;
  along = at.curve0 == vertex.curve0 ? direction : -direction;
  vec3 normal = sector_normal(at.first == vertex.first);
  across = unit_or_zero(cross(normal, along));
}

// The chain of the sector for a handle of length 1: what scales its sides, so that it ends opposite;
// returns how far it is to be used.
float shape_sector(out vec2 y, out float scale) {
  y = vec2(0.0);
  scale = 0.0;
  bool stands = false;
  FOR_RING(i, 0u, sector.count + 1u) stands = stands || edge_direction(i) == vec2(0.0);
  if (ring_any(stands)) return 0.0;
  float highest = highest_across();
  rise = kAcrossShare * highest;
  if (!(rise > 0.0)) return 0.0;
  spread = 0.0;
  FOR_RING(i, 0u, sector.count + 1u) spread = max(spread, abs(edge_direction(i).y - rise));
  spread = ring_max(spread);
  float usable = min(balance(sector.count + 1u, y), highest / kFullRise);
  if (!(usable > 0.0)) return 0.0;
  float sum = 0.0;
  FOR_RING(i, 0u, sector.count + 1u) sum += weight(i, y) * edge_direction(i).y;
  sum = ring_sum(sum);
  if (!(sum > 0.0)) return 0.0;
  scale = 2.0 / sum;
  return usable;
}
vec2 side(uint i, vec2 y, float scale) {
  vec2 edge = edge_direction(i);
  return scale * weight(i, y) * vec2(-edge.y, edge.x);
}

// Where the chain stands when the lane's piece begins.
vec2 chain_start(vec2 y, float scale) {
  vec2 piece = vec2(0.0);
  if (kShared) {
    FOR_RING(i, 0u, sector.count) piece += side(i, y, scale);
  }
  return vec2(1.0, 0.0) + ring_before(piece);
}

// The farthest of a chain's points, and how far the chain is to be used.
vec2 measured_chain() {
  vec2 y;
  float scale, usable = shape_sector(y, scale), farthest = 1.0;
  if (!(usable > 0.0)) return vec2(farthest, usable);
  vec2 at = chain_start(y, scale);
  FOR_RING(i, 0u, sector.count) {
    at += side(i, y, scale);
    farthest = max(farthest, length(at));
  }
  return vec2(ring_max(farthest), usable);
}

// `chain` of the length goes to the chain, what is left to the half circle.
void write_points(float chain, float handle, float radius) {
  vec2 y = vec2(0.0), at = vec2(1.0, 0.0);
  float scale = 0.0;
  if (chain > 0.0) {
    shape_sector(y, scale);
    at = chain_start(y, scale);
  }
  FOR_RING(i, 0u, sector.count) {
    float angle = kHalfTurn * (float(i) + 0.5) / float(sector.count);
    vec2 point = radius * vec2(cos(angle), sin(angle));
    if (chain > 0.0) {
      at += side(i, y, scale);
      point += handle * at;
    }
    result[places_at(sector.first + i).corner] = vec4(point.x * along + point.y * across, 0.0);
  }
}

void build(FairVertex vertex, uint v) {
  float size = planes[v].z;
  vec3 direction = unit_or_zero(result[vertex.curve0].xyz);
  if (!(size > 0.0) || direction == vec3(0.0)) {
    scale_ring(vertex, 0.5);
    return;
  }
  uint end = vertex.first + vertex.count;
  float farthest = 1.0, usable = 1.0;
  CurveSector at;
  is_chosen = planes[v].x < uintBitsToFloat(kNoLeanBits);
  leans = is_chosen ? planes[v].xy : vec2(0.0);
  for (uint first = vertex.first; first < end && sector_from(first, end, at); first += at.count) {
    enter(at, vertex, direction);
    vec2 measured = measured_chain();
    farthest = max(farthest, measured.x);
    usable = min(usable, measured.y);
  }
  is_chosen = true;
  if (leads()) planes[v].xy = leans;
  float chain = chain_share(usable);
  float handle = chain * size / farthest, radius = (1.0 - chain) * size;
  for (uint first = vertex.first; first < end && sector_from(first, end, at); first += at.count) {
    enter(at, vertex, direction);
    write_points(chain, handle, radius);
  }
  if (!leads()) return;
  result[vertex.curve0] = vec4((handle + radius) * direction, 0.0);
  result[vertex.curve1] = -result[vertex.curve0];
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i), word = flags[v];
    if ((word & kChanged) == 0u) continue;
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count) || vertex.kind != kCrease) continue;
    origin = given_at(v).xyz;
    if ((word & kRebuild) != 0u) build(vertex, v);
    float factor = quarters(word);
    if (factor < 1.0) scale_ring(vertex, factor);
  }
}
#endif

#ifdef KERNEL_fair_cure_corners
// The control points of every corner that is to be cured, each in its own face's plane, and quarters of
// those that were. build_perpendicular_corner() of fair/perpendicular_polygon.h.

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
#endif
