// Control points at smooth and dart vertices, and at corners: how far each vertex takes part in the
// tensor-product construction, the masked iteration of that, and the polygons.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

#ifdef KERNEL_fair_limit_errors
// How far the limit point of the given points is from every large smooth or dart vertex, once and not
// once for each of its neighbours; limit_error() of fair/fair_topology.h.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, offsets)
WRITE(3, vec4, errors);

#include "fair_walk.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count) || !has_polygon(vertex)) continue;
    vec3 sum = vec3(0.0);
    FOR_RING(p, vertex.first, vertex.count) sum += offsets_at(places_at(p).corner).xyz;
    sum = ring_sum(sum);
    if (leads()) errors[v] = vec4(sum / float(vertex.count), 0.0);
  }
}
#endif

#ifdef KERNEL_fair_shares
// How far every vertex takes part in the tensor-product construction, 0 to 1: only among quads, and
// the less the farther it is out of balance, be it by itself or against its neighbours.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, offsets)
READ(4, vec4, normals)
READ(5, vec4, errors)  // of large vertices
WRITE(6, float, shares);

float arm_imbalance(CreaseArms arms) {
  float before = safe_length(arms.before), after = safe_length(arms.after);
  float shorter = min(before, after);
  return shorter > 0.0 ? abs(before - after) / shorter : uintBitsToFloat(0x7f800000u);
}

#include "fair_ring.glsl"

// Such an imbalance counts this much; fair/vertex_polygon.h.
const float kRelativeWeight = 2.0;
const float kFullShareBelow = 0.4, kNoShareFrom = 0.9;

// How far the limit point of the given points is from its vertex; limit_error() of
// fair/fair_topology.h.
vec3 limit_error(uint v) {
  FairVertex vertex = vertices_at(v);
  if (has_polygon(vertex)) {
    if (vertex.count >= kLargeRing) return errors_at(v).xyz;
    vec3 sum = vec3(0.0);
    for (uint i = vertex.first; i < vertex.first + vertex.count; ++i)
      sum += offsets_at(places_at(i).corner).xyz;
    return sum / float(vertex.count);
  }
  if (vertex.kind == kCorner) return vec3(0.0);
  vec3 own = given_at(v).xyz;
  return ((given_at(vertex.before).xyz - own) + (given_at(vertex.after).xyz - own)) / 8.0;
}

vec3 relative_error(uint v, FairVertex vertex) {
  vec3 around = vec3(0.0);
  FOR_RING(i, vertex.first, vertex.count) around += limit_error(places_at(i).next);
  return limit_error(v) - ring_sum(around) / float(vertex.count);
}

float share_of_imbalance(float rho) {
  return clamp((kNoShareFrom - rho) / (kNoShareFrom - kFullShareBelow), 0.0, 1.0);
}

float share_of(uint v, FairVertex vertex) {
  if (vertex.regular == 0u || vertex.kind == kCorner || vertex.plane != 0u) return 0.0;
  vec3 own = given_at(v).xyz;
  if (vertex.kind == kCrease)
    return share_of_imbalance(arm_imbalance(CreaseArms((given_at(vertex.before).xyz - own) / 4.0,
                                                       (given_at(vertex.after).xyz - own) / 4.0)));
  Ring ring = ring_of(v, normals_at(v).xyz);
  float rho = imbalance(ring);
  if (rho <= kFullShareBelow) return 1.0;
  ring.mean = project(ring.frame, relative_error(v, vertex));
  return share_of_imbalance(min(rho, kRelativeWeight * imbalance(ring)));
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    float share = share_of(v, vertex);
    if (leads()) shares[v] = share;
  }
}
#endif

#ifdef KERNEL_fair_mask_step
// One step of the masked iteration: every point moves by its share of the distance from its limit
// point to its given point.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, float, shares)
READ(4, vec4, offsets)
READ(5, vec4, points)
WRITE(6, vec4, next);

#include "fair_walk.glsl"

vec3 limit_error(uint v, FairVertex vertex) {
  if (has_polygon(vertex)) {
    vec3 sum = vec3(0.0);
    FOR_RING(i, vertex.first, vertex.count) sum += offsets_at(places_at(i).corner).xyz;
    return ring_sum(sum) / float(vertex.count);
  }
  vec3 own = points_at(v).xyz;
  return (own - given_at(v).xyz) +
         ((points_at(vertex.before).xyz - own) + (points_at(vertex.after).xyz - own)) / 8.0;
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    float share = shares_at(v);
    vec3 point = points_at(v).xyz;
    if (share > 0.0) {
      FairVertex vertex = vertices_at(v);
      if (!is_walked(vertex.count)) continue;
      point -= share * limit_error(v, vertex);
    } else if (kShared) {
      continue;  // a lane of its own moves it along
    }
    if (leads()) next[v] = vec4(point, 0.0);
  }
}
#endif

#ifdef KERNEL_fair_polygons
// The polygon of control points around every smooth or dart vertex, its mean the vertex and each in
// its own face's wedge, and those of corners as they are. fair/vertex_polygon.h, vertex_polygon.h.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, normals)
READ(4, float, shares)
READ(5, vec4, offsets)
UPDATE(6, vec4, result);

#include "fair_ring.glsl"

// Up to this imbalance translation alone keeps every control point well inside its wedge.
const float kTranslatedImbalance = 0.5;
// Control points may move away from the vertex by this factor.
const float kLongestFactor = 1.15;
const float kLeastUsableCoordinate = 0.01;
// Where nothing balances: small enough to stay clear of the neighbours' polygons.
const float kLastResortFactor = 0.15;

// While a local polygon is built, the first two floats of the results are the targets, the last two
// the blend of what was made of them.
uint first_target;  // place
vec2 balance_point(uint i) { return result[places_at(first_target + i).corner].xy; }
#include "fair_balance.glsl"

void add_to_blend(FairVertex vertex, uint i, vec2 point) {
  result[places_at(vertex.first + i).corner].zw += point;
}

// Blends d_c = s_c q_c, scaled so that none is longer than kLongestFactor q_c. Returns how far.
float add_corners(Ring ring, float rho) {
  FairVertex vertex = ring.vertex;
  FOR_RING(i, 0u, vertex.count)
    result[places_at(vertex.first + i).corner] =
        vec4(ring_offset(ring, i) - kTranslatedImbalance / rho * ring.mean, 0.0, 0.0);
  vec2 y;
  float usable = balance(vertex.count, y);
  if (!(usable > 0.0)) return 0.0;
  float largest = 0.0;
  FOR_RING(i, 0u, vertex.count)
    if (balance_point(i) != vec2(0.0)) largest = max(largest, weight(i, y));
  float scale = usable * min(1.0, kLongestFactor / ring_max(largest));
  FOR_RING(i, 0u, vertex.count)
    add_to_blend(vertex, i, scale * weight(i, y) * balance_point(i));
  return usable;
}

// Regular coordinates instead of those that give no direction, and of the first ones beyond these a
// part.
Wedge usable_wedge(RingCorner corner) {
  Wedge wedge = wedge_of(corner.offset, corner.next, corner.previous);
  float least = min(wedge.along_next, wedge.along_previous);
  float share = clamp(least / kLeastUsableCoordinate - 1.0, 0.0, 1.0) *
                wedge_share(corner.next, corner.previous);
  if (!wedge.valid || !(share > 0.0)) return Wedge(kRegularCoordinate, kRegularCoordinate, true);
  return Wedge(mix(kRegularCoordinate, wedge.along_next, share),
               mix(kRegularCoordinate, wedge.along_previous, share), true);
}

// The target of the edge before a control point, of which the one before has a part along it.
vec2 edge_target(Ring ring, uint i, float before) {
  RingCorner corner = ring_corner(ring, i);
  return (usable_wedge(corner).along_next + before) * corner.next;
}

vec2 edge_point(Ring ring, uint i, vec2 y) {
  RingCorner corner = ring_corner(ring, i);
  Wedge own = usable_wedge(corner);
  uint after = i + 1u == ring.vertex.count ? 0u : i + 1u;
  // The next target may be another lane's.
  vec2 target = kShared ? edge_target(ring, after, own.along_previous) : balance_point(after);
  return weight(i, y) * own.along_next * corner.next +
         exp(-dot(y, target)) * own.along_previous * corner.previous;
}

// The same on edges: each takes the parts of its two control points along it and gets one factor.
// Blends `part` of it, as far as it is to be used; returns how much.
float add_edges(Ring ring, float part) {
  FairVertex vertex = ring.vertex;
  uint n = vertex.count;
  float before = usable_wedge(ring_corner(ring, (walk_begin(n) + n - 1u) % n)).along_previous;
  FOR_RING(i, 0u, n) {
    RingCorner corner = ring_corner(ring, i);
    Wedge own = usable_wedge(corner);
    result[places_at(vertex.first + i).corner].xy = (own.along_next + before) * corner.next;
    before = own.along_previous;
  }
  vec2 y;
  part *= balance(vertex.count, y);
  if (!(part > 0.0)) return 0.0;
  float largest = 0.0;
  FOR_RING(i, 0u, n) {
    RingCorner corner = ring_corner(ring, i);
    Wedge own = usable_wedge(corner);
    vec2 point = edge_point(ring, i, y);
    vec2 goal = own.along_next * corner.next + own.along_previous * corner.previous;
    float square = dot(goal, goal);
    if (square > 0.0) largest = max(largest, dot(point, point) / square);
  }
  largest = ring_max(largest);
  float scale = largest > kLongestFactor * kLongestFactor ? kLongestFactor / sqrt(largest) : 1.0;
  FOR_RING(i, 0u, n) add_to_blend(vertex, i, part * scale * edge_point(ring, i, y));
  return part;
}

// Local polygon in the tangent plane, in the first two floats of the results.
void build_local(Ring ring) {
  float rho = imbalance(ring);
  bool translated = rho <= kTranslatedImbalance;
  float rest = 0.0;
  if (!translated) {
    rest = 1.0 - add_corners(ring, rho);
    if (rest > 0.0) rest -= add_edges(ring, rest);
  }
  FOR_RING(i, 0u, ring.vertex.count) {
    uint corner = places_at(ring.vertex.first + i).corner;
    vec2 offset = ring_offset(ring, i);
    result[corner] = vec4(translated ? offset - ring.mean
                                     : result[corner].zw + rest * kLastResortFactor * offset,
                          0.0, 0.0);
  }
}

// What bilinear corners add to a plane: the part of the heights that no plane explains.
void add_twist(Ring ring) {
  FairVertex vertex = ring.vertex;
  float mean = 0.0;
  FOR_RING(i, 0u, vertex.count)
    mean += dot(offsets_at(places_at(vertex.first + i).corner).xyz, ring.frame.normal);
  mean = ring_sum(mean) / float(vertex.count);
  float xx = 0.0, xy = 0.0, yy = 0.0;
  vec2 moment = vec2(0.0);
  FOR_RING(i, 0u, vertex.count) {
    vec2 p = ring_offset(ring, i) - ring.mean;
    float height = dot(offsets_at(places_at(vertex.first + i).corner).xyz, ring.frame.normal) - mean;
    xx += p.x * p.x;
    xy += p.x * p.y;
    yy += p.y * p.y;
    moment += height * p;
  }
  xx = ring_sum(xx);
  xy = ring_sum(xy);
  yy = ring_sum(yy);
  moment = ring_sum(moment);
  precise float determinant = xx * yy - xy * xy;
  precise vec2 slope = vec2(0.0);
  // Below this the control points lie on a line up to rounding.
  if (determinant > 1e-6 * (xx + yy) * (xx + yy))
    slope = vec2(yy * moment.x - xy * moment.y, xx * moment.y - xy * moment.x) / determinant;
  FOR_RING(i, 0u, vertex.count) {
    uint corner = places_at(vertex.first + i).corner;
    vec2 offset = ring_offset(ring, i);
    float height = dot(offsets_at(corner).xyz, ring.frame.normal);
    float twist = height - mean - dot(slope, offset - ring.mean);
    float before = length(offset), after = length(result[corner].xy);
    result[corner].z = twist * (after < before ? after / before : 1.0);
  }
}

void centre(FairVertex vertex) {
  vec3 mean = vec3(0.0);
  FOR_RING(i, vertex.first, vertex.count) mean += result[places_at(i).corner].xyz;
  mean = ring_sum(mean) / float(vertex.count);
  FOR_RING(i, vertex.first, vertex.count) result[places_at(i).corner].xyz -= mean;
}

void build_polygon(uint v, FairVertex vertex) {
  Ring ring = ring_of(v, normals_at(v).xyz);
  first_target = vertex.first;
  // Two control points only: translation puts them on both sides of the vertex.
  float share = vertex.count > 2u ? shares_at(v) : 1.0;
  if (share < 1.0) {
    build_local(ring);
    if (vertex.regular != 0u && vertex.plane == 0u) add_twist(ring);
  }
  vec3 mean = vec3(0.0);
  FOR_RING(i, vertex.first, vertex.count) mean += offsets_at(places_at(i).corner).xyz;
  mean = ring_sum(mean) / float(vertex.count);
  FOR_RING(i, vertex.first, vertex.count) {
    uint corner = places_at(i).corner;
    vec3 translated = offsets_at(corner).xyz - mean;
    vec3 local = translated;
    if (share < 1.0) {
      vec3 flat_point = result[corner].xyz;
      local = lift(ring.frame, flat_point.xy) + flat_point.z * ring.frame.normal;
    }
    result[corner] = vec4(share * translated + (1.0 - share) * local, 0.0);
  }
  centre(vertex);
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    if (has_polygon(vertex)) {
      build_polygon(v, vertex);
    } else if (vertex.kind == kCorner) {
      FOR_RING(p, vertex.first, vertex.count)
        result[places_at(p).corner] = offsets_at(places_at(p).corner);
    }
  }
}
#endif

#ifdef KERNEL_fair_reversed
// Replaces every polygon that came out turned over, or was decided to have, by a small translated copy of the given points'.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, normals)
READ(3, vec4, given_offsets)
READ(4, vec2, circle)
UPDATE(5, vec4, result);
UPDATE(6, uint, decisions);

uint first_place;
#define POLYGON_POINT(i) result[places_at(first_place + (i)).corner].xyz
#include "fair_limit_normal.glsl"

// Cosine between the polygon's limit normal and the vertex's below which it is turned over.
const float kReversedCosine = 0.2;
const float kReversedFactor = 0.3;

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    if (!has_polygon(vertex)) continue;
    first_place = vertex.first;
    vec3 own = limit_normal(vertex.count, vertex.circle);
    bool reversed = dot(own, normals_at(v).xyz) < kReversedCosine * safe_length(own);
    if (parameters.decided != 0u) reversed = (decisions[v] & kReversed) != 0u;
    if (!reversed) continue;
    if (leads()) decisions[v] |= kReversed;
    vec3 mean = vec3(0.0);
    FOR_RING(p, vertex.first, vertex.count) mean += given_offsets_at(places_at(p).corner).xyz;
    mean = ring_sum(mean) / float(vertex.count);
    FOR_RING(p, vertex.first, vertex.count) {
      uint corner = places_at(p).corner;
      result[corner] = vec4(kReversedFactor * (given_offsets_at(corner).xyz - mean), 0.0);
    }
  }
}
#endif
