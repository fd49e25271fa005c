// The surface at any places: of each the polynomial that it lies in, made of the patch's control
// points, with its derivatives.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "finite.glsl"
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { PlaceParameters parameters; };

// The host's, of any stride and content.
layout(std430, set = 0, binding = 0) restrict readonly buffer places_block { uint places[]; };
// The first corner of each face and of none; two words a corner; classes; lists.
READ(1, uint, words)
READ(2, uvec2, links)
READ(3, vec4, state)
READ(4, vec4, given)
READ(5, vec4, weights)
WRITE(6, float, target);

#include "limit_row.glsl"

// The corner counter-clockwise at the same vertex, and the next one in the face.
uvec2 link_of(uint corner) { return links_at(corner); }
vec4 point_of(uint i) { return state_at(i); }
vec3 vertex_of(vec4 point) { return given_at(floatBitsToUint(point.w) & ~kVertexTag).xyz; }

// A place seen from its corner; derivatives turn by quarters and grow by `factor` on the way back
// to those of the place's own (u, v).
struct Place {
  uint corner;
  float u, v;
  float c, s, factor;
};

// Places so far outside are taken to the border: what rounding makes of them.
const float kOutside = 1e-6;


// One direction of a face of tiles of half a unit. What lies just before a tile is its own.
bool find_tile(float x, out uint tile, out float rest) {
  tile = 0u;
  rest = 0.0;
  if (x < -kOutside || x > 65536.0) return false;
  tile = uint(max(floor(x), 0.0));
  rest = x - float(tile);
  if (rest > 0.75) {
    ++tile;
    rest -= 1.0;
  }
  if (rest < -kOutside || rest > 0.5 + kOutside) return false;
  rest = clamp(2.0 * rest, 0.0, 1.0);
  return true;
}

uint tiles_across(uint size) {
  if (size < 10u) return size > 4u ? 3u : 2u;
  uint across = uint(sqrt(float(size - 1u)));
  // Whole numbers, whatever the root was rounded to.
  if (across * across > size - 1u) --across;
  if ((across + 1u) * (across + 1u) <= size - 1u) ++across;
  return across + 1u;
}

bool find_place(uint face, float u, float v, out Place place) {
  place = Place(0u, 0.0, 0.0, 1.0, 0.0, 2.0);
  if (face >= parameters.face_count || !is_finite(u) || !is_finite(v)) return false;
  uint first = words_at(face);
  uint size = words_at(face + 1u) - first;
  if (size != 4u) {
    uint column, row;
    if (!find_tile(u, column, place.u) || !find_tile(v, row, place.v)) return false;
    uint across = tiles_across(size);
    uint corner = row * across + column;
    place.corner = first + corner;
    return column < across && corner < size;
  }
  if (min(u, v) < -kOutside || max(u, v) > 1.0 + kOutside) return false;
  u = clamp(u, 0.0, 1.0);
  v = clamp(v, 0.0, 1.0);
  if (v < 0.5) {
    place = u < 0.5 ? Place(first, 2.0 * u, 2.0 * v, 1.0, 0.0, 2.0)
                    : Place(first + 1u, 2.0 * v, 2.0 - 2.0 * u, 0.0, 1.0, 2.0);
  } else {
    place = u < 0.5 ? Place(first + 3u, 2.0 - 2.0 * v, 2.0 * u, 0.0, -1.0, 2.0)
                    : Place(first + 2u, 2.0 - 2.0 * u, 2.0 - 2.0 * v, -1.0, 0.0, 2.0);
  }
  return true;
}

// From a patch to its quarter in which the place lies, seen from the quarter's corner.
uint halve(inout Place place) {
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
uint find_cell(uint flags, inout Place place, out bool is_singular) {
  is_singular = false;
  if ((flags & kOnePolynomial) != 0u) return 0u;
  uint quarter = halve(place);
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
    quarter = halve(place);
    if (quarter > 0u) return chain + 3u * (depth - 1u) + quarter - 1u;
  }
  is_singular = true;
  place.factor = factor;
  return chain + kChainCells - 1u;
}

vec4 own;
vec3 own_vertex;
uint next_weight;
vec3 c00, c10, c01, c20, c11, c02, c21, c12, c22;

void begin(uint i) {
  own = point_of(i);
  own_vertex = vertex_of(own);
  c00 = c10 = c01 = c20 = c11 = c02 = c21 = c12 = c22 = vec3(0.0);
}

// The next column's point, an offset from its vertex.
void add(uint i) {
  vec4 point = point_of(i);
  precise vec3 x = (vertex_of(point) - own_vertex) + (point.xyz - own.xyz);
  vec4 a = weights_at(next_weight);
  vec4 b = weights_at(next_weight + 1u);
  c00 += a.x * x;
  c10 += a.y * x;
  c01 += a.z * x;
  c20 += a.w * x;
  c11 += b.x * x;
  c02 += b.y * x;
  c21 += b.z * x;
  c12 += b.w * x;
  c22 += weights_at(next_weight + 2u).x * x;
  next_weight += kCellVectors;
}

// Lanes differ in how often they go round: loops end at their head, and nothing that is made
// within one is read behind it but what the next round takes up, since a software device was seen
// to mix up the rounds of lanes otherwise.
void gather_corner(uint corner, uint ring, uint face) {
  begin(corner);
  uvec2 link = link_of(corner);
  uint at = link.x;
  for (uint i = 1u; i < ring; ++i) {
    add(at);
    at = link_of(at).x;
  }
  at = link.y;
  for (uint i = 1u; i < face; ++i) {
    add(at);
    at = link_of(at).y;
  }
  add(link_of(link.y).x);  // beyond the leading edge
  add(link_of(link.x).y);  // and the trailing one
}

void gather_list(uint word, uint columns) {
  begin(words_at(word));
  for (uint k = 1u; k <= columns; ++k) add(words_at(word + k));
}

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
  Place place;
  if (!find_place(places[word], uintBitsToFloat(places[word + 1u]),
                  uintBitsToFloat(places[word + 2u]), place)) {
    write_place(target_place, zero, zero, zero, zero, zero, zero, zero, kPlaceNone);
    return;
  }
  uint head = parameters.first_corner + 2u * place.corner;
  uint kind = words_at(head), list = words_at(head + 1u);
  uint columns = words_at(kind);
  bool is_singular;
  uint cell = find_cell(words_at(kind + 4u), place, is_singular);
  next_weight = words_at(kind + 3u) + cell * columns * kCellVectors;
  if (list == kNone) {
    gather_corner(place.corner, words_at(kind + 1u), words_at(kind + 2u));
  } else {
    gather_list(list, columns);
  }
  precise vec3 offset = c00;
  vec3 du = c20, dv = c11, duu = zero, duv = zero, dvv = zero;
  vec3 normal = unit_normal(c10, c01);  // at V or F, by the tangents there
  if (!is_singular) {
    float s = place.u, t = place.v;
    offset = (c00 + t * (c01 + t * c02)) +
             s * ((c10 + t * (c11 + t * c12)) + s * (c20 + t * (c21 + t * c22)));
    du = (c10 + t * (c11 + t * c12)) + 2.0 * s * (c20 + t * (c21 + t * c22));
    dv = (c01 + s * (c11 + s * c21)) + 2.0 * t * (c02 + s * (c12 + s * c22));
    duu = 2.0 * (c20 + t * (c21 + t * c22));
    duv = (c11 + 2.0 * t * c12) + 2.0 * s * (c21 + 2.0 * t * c22);
    dvv = 2.0 * (c02 + s * (c12 + s * c22));
    normal = unit_normal(du, dv);
  }
  float c = place.c, s = place.s, factor = place.factor, square = factor * factor;
  precise vec3 position = own_vertex + (own.xyz + offset);
  write_place(target_place, position, normal, factor * (c * du - s * dv), factor * (s * du + c * dv),
              square * (c * c * duu - 2.0 * c * s * duv + s * s * dvv),
              square * (c * s * duu + (c * c - s * s) * duv - c * s * dvv),
              square * (s * s * duu + 2.0 * c * s * duv + c * c * dvv),
              is_singular ? kPlaceSingular : kPlaceRegular);
}
