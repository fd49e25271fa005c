// The cure's first look: edges, faces and curves that are turned too far from the mesh, where the last
// round changed something. Flags vertices; fair/fold_cure.cpp.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

#ifdef KERNEL_fair_cure_edges
READ(0, FairEdge, edges)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, face_normals)
READ(4, vec4, result)
UPDATE(5, uint, flags);
UPDATE(6, uint, counts);
#endif
#ifdef KERNEL_fair_cure_faces
READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, face_normals)
READ(4, vec4, result)
READ(5, vec2, circle)
UPDATE(6, uint, flags);
UPDATE(7, uint, counts);
#endif
#ifdef KERNEL_fair_cure_curves
READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, FairLinks, links)
READ(3, vec4, given)
READ(4, vec4, face_normals)
READ(5, vec4, result)
UPDATE(6, uint, flags);
#endif

#include "fair_cure.glsl"

// Whether the last round of the cure changed a vertex; in the beginning all count as changed. The flags'
// other bits are set meanwhile.
bool is_changed(uint vertex) {
  return parameters.start != 0u || (atomicOr(flags[vertex], 0u) & kChanged) != 0u;
}

// Of the best cosine that any normal there can have.
const float kPartOfBest = 0.5;

#ifdef KERNEL_fair_cure_edges
// Flags the ends of every smooth edge whose limit normal is turned too far from the faces beside it, or
// counts the edges that are turned over. NetSamples::at_edge() of fair/fold_cure.h.

// Where the best is less, about 80 degrees, the mesh itself is folded.
const float kLeastBest = 0.17;

// The cross product of the polygon's diagonals: written out, since the edge, which they both follow,
// is long beside what is left.
vec3 limit_normal(FairEdge edge, vec3 along) {
  vec3 a = result_at(edge.corner2).xyz - result_at(edge.corner0).xyz;
  vec3 b = result_at(edge.corner3).xyz - result_at(edge.corner1).xyz;
  return cross(along, a + b) + cross(a, b);
}

void main() {
  FOR_ELEMENTS(e) {
    FairEdge edge = edges_at(e);
    uint end0 = owners_at(edge.corner0), end1 = owners_at(edge.corner1);
    bool only_counts = parameters.only_counts != 0u;
    if (!only_counts && !is_changed(end0) && !is_changed(end1)) continue;
    vec3 normal = limit_normal(edge, given_at(end1).xyz - given_at(end0).xyz);
    vec3 face0 = face_normals_at(edge.face0).xyz, face1 = face_normals_at(edge.face1).xyz;
    float cosine = min(cosine_of(normal, face0), cosine_of(normal, face1));
    if (only_counts) {
      if (cosine < 0.0) atomicAdd(counts[parameters.place], 1u);
      continue;
    }
    float best = sqrt(max(0.0, (1.0 + dot(face0, face1)) / 2.0));
    if (best < kLeastBest || cosine >= kPartOfBest * best) continue;
    atomicOr(flags[end0], kBad);
    atomicOr(flags[end1], kBad);
  }
}
#endif

#ifdef KERNEL_fair_cure_faces
// Flags the vertices of every face whose limit normal is turned too far from it, and those that share a
// face with a changed one; or counts the faces that are turned over.

// Control points relative to the face's first vertex.
uint first_corner;
vec3 origin;
vec3 face_point(uint i) {
  uint corner = first_corner + i;
  return (given_at(owners_at(corner)).xyz - origin) + result_at(corner).xyz;
}
#define POLYGON_POINT(i) face_point(i)
#include "fair_limit_normal.glsl"

bool any_changed(FairFace face) {
  bool is_any = false;
  FOR_RING(c, face.first, face.count) {
    is_any = is_changed(owners_at(c));
    if (is_any) break;
  }
  return ring_any(is_any);
}

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    bool only_counts = parameters.only_counts != 0u;
    if (!only_counts && !any_changed(face)) continue;
    first_corner = face.first;
    origin = given_at(owners_at(first_corner)).xyz;
    float cosine = cosine_of(limit_normal(face.count, face.circle), face_normals_at(f).xyz);
    if (only_counts) {
      if (cosine < 0.0 && leads()) atomicAdd(counts[parameters.place], 1u);
      continue;
    }
    uint found = cosine < kPartOfBest ? kTouched | kBad : kTouched;
    FOR_RING(c, face.first, face.count) atomicOr(flags[owners_at(c)], found);
  }
}
#endif

#ifdef KERNEL_fair_cure_curves
// Flags the ends of every sharp edge beside which the curve's own points and a face's first ones are
// turned over.
#include "fair_walk.glsl"

// The other curve point of the edge: they stand side by side.
uint other_end(uint point) {
  return parameters.corner_count + ((point - parameters.corner_count) ^ 1u);
}

void test_edge(uint corner, vec3 face_normal) {
  uint next = links_at(corner).next, points = parameters.corner_count;
  uint curve0 = links_at(corner).before, curve1 = links_at(next).after;
  if (curve0 < points && curve1 < points) return;
  // A dart's ring does not show its curve point: the edge's other one does.
  if (curve0 < points) curve0 = other_end(curve1);
  if (curve1 < points) curve1 = other_end(curve0);
  uint end0 = owners_at(corner), end1 = owners_at(next);
  if (!is_changed(end0) && !is_changed(end1)) return;
  vec3 on0 = result_at(curve0).xyz, on1 = result_at(curve1).xyz;
  vec3 along = (given_at(end1).xyz - given_at(end0).xyz) + (on1 - on0);
  vec3 across = (result_at(corner).xyz - on0) + (result_at(next).xyz - on1);
  if (cosine_of(cross(along, across), face_normal) >= kPartOfBest) return;
  atomicOr(flags[end0], kBad);
  atomicOr(flags[end1], kBad);
}

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    FOR_RING(c, face.first, face.count) test_edge(c, face_normals_at(f).xyz);
  }
}
#endif
