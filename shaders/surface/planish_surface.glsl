// The limit surface as shader code, in any stage: its point at any place, with derivatives, from the
// control points as a Solve's last record_evaluate or record_surface left them. Before it is included
// the shader declares what planish/vulkan/embed.h's surface_buffers() has, wherever its own
// bindings are, by five functions, each item i of an array:
//   uint planish_words_at(uint i);
//   uvec2 planish_links_at(uint i);
//   vec4 planish_state_at(uint i);
//   vec4 planish_given_at(uint i);
//   vec4 planish_weights_at(uint i);
// Names that begin with planish_, Planish, kPlanish and those of planish_surface_tables.h are taken.
//
// In tessellation shaders a patch is a corner, of one control point: layout(quads, equal_spacing,
// cw), whose gl_TessCoord.xy are planish_corner_place()'s u and v; triangles are then
// counter-clockwise seen from outside, as Vulkan's domain has v downwards. An edge's levels follow
// from its two ends alone, which both sides know. planish_corner_count(face_count) patches are the
// surface, holes included. planish's vulkan/README.md shows all of it. Mesa's llvmpipe (22.3) counts
// gl_PrimitiveID anew after 1,024 control points of a draw, and draws none of the vertices that it
// generates beyond 65,535: fewer a draw there.
//
// Without a crack. Corners of faces meet along edges, where each would round in its own way. Who
// draws them takes positions from planish_evaluate(face_count, planish_owner(place)): on an edge,
// at its midpoint, a vertex or a centre it names one and the same place for all corners that meet
// there, so that positions are the same bits, across sharp edges, too, whose normals are the
// corners' own. It walks around the vertex or face there: a few steps, of a hub all of them.
#include "finite.glsl"
#include "planish_surface_tables.h"
#include "unit_normal.glsl"

// A place seen from its corner; derivatives turn by quarters and grow by `factor` on the way back
// to those of the place's own (u, v).
struct PlanishPlace {
  uint corner;
  float u, v;
  float c, s, factor;
};

// Places so far outside are taken to the border: what rounding makes of them.
const float kPlanishOutside = 1e-6;

// One direction of a face of tiles of half a unit. What lies just before a tile is its own.
bool planish_find_tile(float x, out uint tile, out float rest) {
  tile = 0u;
  rest = 0.0;
  if (x < -kPlanishOutside || x > 65536.0) return false;
  tile = uint(max(floor(x), 0.0));
  rest = x - float(tile);
  if (rest > 0.75) {
    ++tile;
    rest -= 1.0;
  }
  if (rest < -kPlanishOutside || rest > 0.5 + kPlanishOutside) return false;
  rest = clamp(2.0 * rest, 0.0, 1.0);
  return true;
}

uint planish_tiles_across(uint size) {
  if (size < 10u) return size > 4u ? 3u : 2u;
  uint across = uint(sqrt(float(size - 1u)));
  // Whole numbers, whatever the root was rounded to.
  if (across * across > size - 1u) --across;
  if ((across + 1u) * (across + 1u) <= size - 1u) ++across;
  return across + 1u;
}

bool planish_find_place(uint face_count, uint face, float u, float v, out PlanishPlace place) {
  place = PlanishPlace(0u, 0.0, 0.0, 1.0, 0.0, 2.0);
  if (face >= face_count || !is_finite(u) || !is_finite(v)) return false;
  uint first = planish_words_at(face);
  uint size = planish_words_at(face + 1u) - first;
  if (size != 4u) {
    uint column, row;
    if (!planish_find_tile(u, column, place.u) || !planish_find_tile(v, row, place.v)) return false;
    uint across = planish_tiles_across(size);
    uint corner = row * across + column;
    place.corner = first + corner;
    return column < across && corner < size;
  }
  if (min(u, v) < -kPlanishOutside || max(u, v) > 1.0 + kPlanishOutside) return false;
  u = clamp(u, 0.0, 1.0);
  v = clamp(v, 0.0, 1.0);
  if (v < 0.5) {
    place = u < 0.5 ? PlanishPlace(first, 2.0 * u, 2.0 * v, 1.0, 0.0, 2.0)
                    : PlanishPlace(first + 1u, 2.0 * v, 2.0 - 2.0 * u, 0.0, 1.0, 2.0);
  } else {
    place = u < 0.5 ? PlanishPlace(first + 3u, 2.0 - 2.0 * v, 2.0 * u, 0.0, -1.0, 2.0)
                    : PlanishPlace(first + 2u, 2.0 - 2.0 * u, 2.0 - 2.0 * v, -1.0, 0.0, 2.0);
  }
  return true;
}

// From a patch to its quarter in which the place lies, seen from the quarter's corner.
uint planish_halve(inout PlanishPlace place) {
  float u = place.u, v = place.v, c = place.c, s = place.s;
  place.factor *= 2.0;
  if (v < 0.5) {
    if (u < 0.5) {
      place.u = 2.0 * u;
      place.v = 2.0 * v;
      return 0u;
    }
    place.u = 2.0 * v;
    place.v = 2.0 - 2.0 * u;
    place.c = -s;
    place.s = c;
    return 1u;
  }
  if (u < 0.5) {
    place.u = 2.0 - 2.0 * v;
    place.v = 2.0 * u;
    place.c = s;
    place.s = -c;
    return 3u;
  }
  place.u = 2.0 - 2.0 * u;
  place.v = 2.0 - 2.0 * v;
  place.c = -c;
  place.s = -s;
  return 2u;
}

// The cell that a place lies in; whether that is V or F itself.
uint planish_find_cell(uint flags, inout PlanishPlace place, out bool is_singular) {
  is_singular = false;
  if ((flags & kOnePolynomial) != 0u) return 0u;
  uint quarter = planish_halve(place);
  uint chain = kQuarterCells;
  float factor = place.factor;
  if (quarter == 0u) {
    factor *= 0.5;  // the cell of V is the whole patch's, that of F the quarter's
    if ((flags & kSingularAtVertex) == 0u) return 0u;
  } else {
    if (quarter != 2u || (flags & kSingularAtFace) == 0u) return quarter;
    if ((flags & kSingularAtVertex) != 0u) chain += kChainCells;
  }
  for (uint depth = 1u; depth < kPlaceHalvings && max(place.u, place.v) > 0.0; ++depth) {
    quarter = planish_halve(place);
    if (quarter > 0u) return chain + 3u * (depth - 1u) + quarter - 1u;
  }
  is_singular = true;
  place.factor = factor;
  return chain + kChainCells - 1u;
}

vec3 planish_vertex_of(vec4 point) {
  return planish_given_at(floatBitsToUint(point.w) & ~kVertexTag).xyz;
}

vec4 planish_own;
vec3 planish_own_vertex;
uint planish_next_weight;
// Coefficients of s^i t^j.
vec3 planish_c00, planish_c10, planish_c01, planish_c20, planish_c11;
vec3 planish_c02, planish_c21, planish_c12, planish_c22;

void planish_begin(uint i) {
  planish_own = planish_state_at(i);
  planish_own_vertex = planish_vertex_of(planish_own);
  planish_c00 = planish_c10 = planish_c01 = planish_c20 = planish_c11 = vec3(0.0);
  planish_c02 = planish_c21 = planish_c12 = planish_c22 = vec3(0.0);
}

// The same bits for all who ask, whatever stage they are in.
vec3 planish_sum(vec3 sum, float weight, vec3 x) {
  precise vec3 result = sum + weight * x;
  return result;
}

// The next column's point, an offset from its vertex.
void planish_add(uint i) {
  vec4 point = planish_state_at(i);
  precise vec3 x = (planish_vertex_of(point) - planish_own_vertex) + (point.xyz - planish_own.xyz);
  vec4 a = planish_weights_at(planish_next_weight);
  vec4 b = planish_weights_at(planish_next_weight + 1u);
  planish_c00 = planish_sum(planish_c00, a.x, x);
  planish_c10 = planish_sum(planish_c10, a.y, x);
  planish_c01 = planish_sum(planish_c01, a.z, x);
  planish_c20 = planish_sum(planish_c20, a.w, x);
  planish_c11 = planish_sum(planish_c11, b.x, x);
  planish_c02 = planish_sum(planish_c02, b.y, x);
  planish_c21 = planish_sum(planish_c21, b.z, x);
  planish_c12 = planish_sum(planish_c12, b.w, x);
  planish_c22 = planish_sum(planish_c22, planish_weights_at(planish_next_weight + 2u).x, x);
  planish_next_weight += kCellVectors;
}

// Lanes differ in how often they go round: loops end at their head, and nothing that is made
// within one is read behind it but what the next round takes up, since a software device was seen
// to mix up the rounds of lanes otherwise.
void planish_gather_corner(uint corner, uint ring, uint face) {
  planish_begin(corner);
  uvec2 link = planish_links_at(corner);
  uint at = link.x;
  for (uint i = 1u; i < ring; ++i) {
    planish_add(at);
    at = planish_links_at(at).x;
  }
  at = link.y;
  for (uint i = 1u; i < face; ++i) {
    planish_add(at);
    at = planish_links_at(at).y;
  }
  planish_add(planish_links_at(link.y).x);  // beyond the leading edge
  planish_add(planish_links_at(link.x).y);  // and the trailing one
}

void planish_gather_list(uint word, uint columns) {
  planish_begin(planish_words_at(word));
  for (uint k = 1u; k <= columns; ++k) planish_add(planish_words_at(word + k));
}

struct PlanishPoint {
  vec3 position, normal;  // the normal is 0 where tangents are parallel
  vec3 du, dv, duu, duv, dvv;
  bool is_singular;  // second derivatives have no limit and are 0
};

// A place in the square of a corner, by u from its vertex to the midpoint of its leading edge and v
// to that of its trailing edge, 0 to 1 both: the whole face by its corners. Derivatives are by
// these.
PlanishPlace planish_corner_place(uint corner, float u, float v) {
  return PlanishPlace(corner, u, v, 1.0, 0.0, 1.0);
}

// Corners of all faces.
uint planish_corner_count(uint face_count) { return planish_words_at(face_count); }

// The same place as all that meet there see it; see above. Of a place that has been found or made
// by its corner, before it was evaluated.
PlanishPlace planish_owner(PlanishPlace place) {
  uint corner = place.corner;
  uvec2 link = planish_links_at(corner);
  if (place.u == 1.0 && place.v == 1.0) {
    uint first = corner;
    for (uint at = link.y; at != corner; at = planish_links_at(at).y) first = min(first, at);
    return planish_corner_place(first, 1.0, 1.0);
  }
  // From E1 to F the next corner's, from V to E2 that of the corner there.
  if (place.u == 1.0) {
    place = planish_corner_place(link.y, place.v, 1.0);
    link = planish_links_at(place.corner);
  } else if (place.u == 0.0 && place.v > 0.0 && place.v < 1.0) {
    if (link.x == kNone) return place;
    return planish_corner_place(link.x, place.v, 0.0);
  }
  if (place.u > 0.0 || (place.v > 0.0 && place.v < 1.0)) return place;
  if (place.v == 1.0) {
    // A midpoint: E2 of one corner on either side.
    if (link.x == kNone) return place;
    return planish_corner_place(min(place.corner, planish_links_at(link.x).y), 0.0, 1.0);
  }
  // A vertex: the last corner counter-clockwise, or all around the first by number.
  uint owner = corner, at = link.x;
  for (; at != kNone && at != corner; at = planish_links_at(at).x) owner = min(owner, at);
  if (at == kNone) {
    owner = corner;
    for (at = link.x; at != kNone; at = planish_links_at(at).x) owner = at;
  }
  return planish_corner_place(owner, 0.0, 0.0);
}

PlanishPoint planish_evaluate(uint face_count, PlanishPlace place) {
  const vec3 zero = vec3(0.0);
  uint head = face_count + 1u + 2u * place.corner;
  uint kind = planish_words_at(head), list = planish_words_at(head + 1u);
  uint columns = planish_words_at(kind);
  bool is_singular;
  uint cell = planish_find_cell(planish_words_at(kind + 4u), place, is_singular);
  planish_next_weight = planish_words_at(kind + 3u) + cell * columns * kCellVectors;
  if (list == kNone) {
    planish_gather_corner(place.corner, planish_words_at(kind + 1u), planish_words_at(kind + 2u));
  } else {
    planish_gather_list(list, columns);
  }
  precise vec3 offset = planish_c00;
  vec3 du = planish_c20, dv = planish_c11, duu = zero, duv = zero, dvv = zero;
  vec3 normal = unit_normal(planish_c10, planish_c01);  // at V or F, by the tangents there
  if (!is_singular) {
    float s = place.u, t = place.v;
    precise vec3 by_s = planish_c10 + t * (planish_c11 + t * planish_c12);
    precise vec3 by_ss = planish_c20 + t * (planish_c21 + t * planish_c22);
    offset = (planish_c00 + t * (planish_c01 + t * planish_c02)) + s * (by_s + s * by_ss);
    du = by_s + 2.0 * s * by_ss;
    dv = (planish_c01 + s * (planish_c11 + s * planish_c21)) +
         2.0 * t * (planish_c02 + s * (planish_c12 + s * planish_c22));
    duu = 2.0 * by_ss;
    duv = (planish_c11 + 2.0 * t * planish_c12) + 2.0 * s * (planish_c21 + 2.0 * t * planish_c22);
    dvv = 2.0 * (planish_c02 + s * (planish_c12 + s * planish_c22));
    normal = unit_normal(du, dv);
  }
  float c = place.c, s = place.s, factor = place.factor, square = factor * factor;
  precise vec3 position = planish_own_vertex + (planish_own.xyz + offset);
  PlanishPoint point;
  point.position = position;
  point.normal = normal;
  point.du = factor * (c * du - s * dv);
  point.dv = factor * (s * du + c * dv);
  point.duu = square * (c * c * duu - 2.0 * c * s * duv + s * s * dvv);
  point.duv = square * (c * s * duu + (c * c - s * s) * duv - c * s * dvv);
  point.dvv = square * (s * s * duu + 2.0 * c * s * duv + c * c * dvv);
  point.is_singular = is_singular;
  return point;
}
