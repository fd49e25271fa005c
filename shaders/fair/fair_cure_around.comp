// Flags every noted vertex where the places that the next step adds around it are turned too far from its
// faces: at its control points, on the sides of its polygon, and on those of the faces' polygons that
// begin or end at it. NetSamples::least_cosine_around() of fair/net_samples.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

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
