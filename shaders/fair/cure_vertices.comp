// The cure's second look, at the vertices that the first one touched, and what is to be done at those
// that were flagged; fair/fold_cure.cpp.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

#ifdef KERNEL_fair_cure_vertices
// Flags every smooth or dart vertex whose limit normal is turned too far from its faces, and notes where
// faces are so uneven that the places around it are to be looked at.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, face_normals)
READ(3, vec4, normals)
READ(4, vec4, result)
READ(5, vec2, circle)
UPDATE(6, uint, flags);

#include "fair_cure.glsl"
#include "fair_view.glsl"
uint first_place;
#define POLYGON_POINT(i) result_at(places_at(first_place + (i)).corner).xyz
#include "fair_limit_normal.glsl"

const float kPartOfBestAtVertices = 0.1;
const float kPartOfBestAround = 0.5;
const float kLeastBest = 0.02;
// Of the vertex's normal with its faces, from which its surroundings are even.
const float kFlatCosine = 0.9;

// What the vertex's word says beside that it was touched or changed.
uint look_at(uint v, FairVertex vertex) {
  first_place = vertex.first;
  vec3 normal = limit_normal(vertex.count, vertex.circle);
  float size = safe_length(normal);
  float own = size > 0.0 ? least_face_cosine(vertex, normal / size) : -1.0;
  if (own >= kPartOfBestAtVertices && least_face_cosine(vertex, normals_at(v).xyz) >= kFlatCosine)
    return 0u;
  float best = smallest_cap(vertex, normals_at(v).xyz).w;
  if (best < kLeastBest) return 0u;
  if (own < kPartOfBestAtVertices * best) return kBad;
  return floatBitsToUint(kPartOfBestAround * best) & ~kCureFlags;
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i), word = flags[v];
    if ((word & kTouched) == 0u || (word & kBad) != 0u) continue;
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count) || !has_polygon(vertex)) continue;
    uint found = look_at(v, vertex);
    if (leads()) flags[v] = (word & (kTouched | kChanged)) | found;
  }
}
#endif

#ifdef KERNEL_fair_cure_around
// Flags every noted vertex where the places that the next step adds around it are turned too far from its
// faces: at its control points, on the sides of its polygon, and on those of the faces' polygons that
// begin or end at it. NetSamples::least_cosine_around() of fair/fold_cure.h.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, FairLinks, links)
READ(3, vec4, stepped)  // offsets of one step in the faces
READ(4, vec4, given)
READ(5, vec4, face_normals)
READ(6, vec4, result)
UPDATE(7, uint, flags);

#include "fair_cure.glsl"
#include "fair_walk.glsl"

const float kTurn = 6.28318531;

// All points are relative to the vertex.
vec3 origin;
vec3 point(uint corner, uint owner) {
  return (given_at(owner).xyz - origin) + result_at(corner).xyz;
}

// A dart's ring does not show that it has a sharp edge.
bool is_smooth(uint corner, uint next) {
  return links_at(corner).before < parameters.corner_count &&
         links_at(next).after < parameters.corner_count;
}

// The points of level 2 around a control point: in its face, and in the polygons of the edges to the
// next vertex of the face and to the one before.
vec3 in_face(uint corner, uint owner) {
  return (given_at(owner).xyz - origin) + stepped_at(corner).xyz;
}
vec3 stepped_quad(vec3 own, vec3 beside, vec3 opposite, vec3 other_beside) {
  return own + (3.0 * (beside - own) + 3.0 * (other_beside - own) + (opposite - own)) / 16.0;
}
vec3 on_next(uint corner, uint owner, uint next) {
  uint other = links_at(corner).before;
  return stepped_quad(point(corner, owner), point(links_at(corner).next, next),
                      point(links_at(other).previous, next), point(other, owner));
}
vec3 on_previous(uint corner, uint owner, uint previous) {
  uint other = links_at(corner).after;
  return stepped_quad(point(corner, owner), point(links_at(corner).previous, previous),
                      point(links_at(other).next, previous), point(other, owner));
}

// The polygon's first Fourier pair and mean, so that any valence takes two walks.
struct Pair {
  vec3 mean, cosine, sine;
};
Pair pair_of(FairVertex vertex) {
  Pair pair = Pair(vec3(0.0), vec3(0.0), vec3(0.0));
  FOR_RING(i, 0u, vertex.count) {
    vec3 own = result_at(places_at(vertex.first + i).corner).xyz;
    float angle = kTurn * (float(i) / float(vertex.count));
    pair.mean += own;
    pair.cosine += cos(angle) * own;
    pair.sine += sin(angle) * own;
  }
  return Pair(ring_sum(pair.mean) / float(vertex.count), ring_sum(pair.cosine), ring_sum(pair.sine));
}
vec3 in_polygon(FairVertex vertex, Pair pair, uint i) {
  float angle = kTurn * (float(i) / float(vertex.count));
  return 0.25 * result_at(places_at(vertex.first + i).corner).xyz + 0.75 * pair.mean +
         (cos(angle) * pair.cosine + sin(angle) * pair.sine) / (2.0 * float(vertex.count));
}

// The least cosine at the places beside the i-th control point of the polygon.
float least_beside(uint v, FairVertex vertex, Pair pair, uint i) {
  FairPlace place = places_at(vertex.first + i);
  uint corner = place.corner, following = i + 1u == vertex.count ? 0u : i + 1u;
  vec3 face_normal = face_normals_at(place.face).xyz;
  uint next = links_at(corner).next, last = links_at(corner).previous;
  bool next_is_smooth = is_smooth(corner, next);
  vec3 face = in_face(corner, v), own = in_polygon(vertex, pair, i);
  float least = 1.0;
  if (next_is_smooth) {
    vec3 normal = cross(on_previous(next, place.next, v) - face,
                        in_face(next, place.next) - on_next(corner, v, place.next));
    least = cosine_of(normal, face_normal);
  }
  if (!is_smooth(last, corner)) return least;
  vec3 edge = on_previous(corner, v, place.previous);
  vec3 normal = cross(face - on_next(last, place.previous, v), in_face(last, place.previous) - edge);
  least = min(least, cosine_of(normal, face_normal));
  if (next_is_smooth) {
    normal = cross(face - own, edge - on_next(corner, v, place.next));
    least = min(least, cosine_of(normal, face_normal));
  }
  FairPlace after = places_at(vertex.first + following);
  vec3 side = cross(on_next(after.corner, v, after.next) - own,
                    in_polygon(vertex, pair, following) - edge);
  least = min(least, cosine_of(side, face_normal));
  return min(least, cosine_of(side, face_normals_at(after.face).xyz));
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i), word = flags[v];
    if ((word & kTouched) == 0u || (word & kBad) != 0u) continue;
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count) || !has_polygon(vertex)) continue;
    float wanted = uintBitsToFloat(word & ~kCureFlags);
    if (!(wanted > 0.0)) continue;
    origin = given_at(v).xyz;
    Pair pair = pair_of(vertex);
    bool is_bad = false;
    FOR_RING(p, 0u, vertex.count) {
      if (least_beside(v, vertex, pair, p) >= wanted) continue;
      is_bad = true;
      break;
    }
    if (ring_any(is_bad) && leads()) flags[v] = word | kBad;
  }
}
#endif

#ifdef KERNEL_fair_cure_sharp
// Flags crease and boundary vertices where a sector's limit normal is turned from its faces, and corners
// whose next control points leave their faces; neither twice, as no size changes that.
// least_sector_cosine() and farthest_fan_point() of fair/perpendicular_polygon.h.
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
#endif

#ifdef KERNEL_fair_cure_decide
// Counts one round more at every flagged vertex, or takes the rounds that were decided, and notes what is
// to be done: a perpendicular polygon in the first round, a quarter of it in every other.
UPDATE(0, uint, flags);
UPDATE(1, uint, decisions);
UPDATE(2, uint, counts);

void main() {
  FOR_ELEMENTS(v) {
    uint cures = decisions[v] >> kCureShift;
    if (parameters.decided != 0u) {
      flags[v] = cures == 0u ? 0u : kChanged | kRebuild | (cures - 1u) << kQuartersShift;
    } else if ((flags[v] & kBad) != 0u) {
      flags[v] = kChanged | (cures == 0u ? kRebuild : 1u << kQuartersShift);
      decisions[v] += 1u << kCureShift;
      atomicAdd(counts[parameters.place], 1u);
    } else {
      flags[v] = 0u;
    }
  }
}
#endif
