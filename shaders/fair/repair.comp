// Finding what is turned over, edges and faces, and halving the control points of their vertices, round by
// round; fair/fold_cure.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

#ifdef KERNEL_fair_edge_folds
READ(0, FairEdge, edges)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, face_normals)
READ(4, vec4, result)
UPDATE(5, uint, flags);
UPDATE(6, uint, counts);
#endif
#ifdef KERNEL_fair_face_folds
READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, face_normals)
READ(4, vec4, result)
READ(5, vec2, circle)
UPDATE(6, uint, flags);
UPDATE(7, uint, counts);
#endif

#if defined(KERNEL_fair_edge_folds) || defined(KERNEL_fair_face_folds)
// Cosine between a limit normal and the mesh's below which an element is turned over.
const float kLeastCosine = 0.5;

vec3 control_point(uint corner) { return given_at(owners_at(corner)).xyz + result_at(corner).xyz; }

// Whether a normal of any length is within `cosine` of the unit vector `reference`.
bool agrees(vec3 normal, vec3 reference, float cosine) {
  return dot(normal, reference) >= cosine * safe_length(normal);
}
#endif

#ifdef KERNEL_fair_edge_folds
// Flags the ends of every smooth edge whose polygon is turned away from the mesh.
void main() {
  FOR_ELEMENTS(e) {
    FairEdge edge = edges_at(e);
    // In differences of given points, which are exact where they are near each other.
    uint end0 = owners_at(edge.corner0), end1 = owners_at(edge.corner1);
    vec3 between = given_at(end1).xyz - given_at(end0).xyz;
    vec3 diagonal0 = between + (result_at(edge.corner2).xyz - result_at(edge.corner0).xyz);
    vec3 diagonal1 = (result_at(edge.corner3).xyz - result_at(edge.corner1).xyz) - between;
    vec3 bisector = face_normals_at(edge.face0).xyz + face_normals_at(edge.face1).xyz;
    float size = safe_length(bisector);
    if (!(size > 0.0)) continue;  // a knife's edge has no normal to compare with
    // Less is asked of sharp ones: half the size is the cosine of half their turn.
    if (agrees(cross(diagonal0, diagonal1), bisector / size, kLeastCosine * size / 2.0)) continue;
    atomicAdd(counts[parameters.place], 1u);
    atomicOr(flags[end0], 1u);
    atomicOr(flags[end1], 1u);
  }
}
#endif

#ifdef KERNEL_fair_face_folds
// Flags the vertices of every face whose polygon is turned away from the mesh.

uint first_corner;
#define POLYGON_POINT(i) control_point(first_corner + (i))
#include "fair_limit_normal.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    first_corner = face.first;
    if (agrees(limit_normal(face.count, face.circle), face_normals_at(f).xyz, kLeastCosine)) continue;
    if (leads()) atomicAdd(counts[parameters.place + 1u], 1u);
    FOR_RING(c, face.first, face.count) atomicOr(flags[owners_at(c)], 1u);
  }
}
#endif

#ifdef KERNEL_fair_round
// Lets the next round of repair run where this one found something turned over, and be empty else.
READ_STORED(0, uint, counts);
WRITE(1, uint, arguments);

void write_groups(uint dispatch, uint groups) {
  arguments[kArgumentWords * dispatch] = groups;
  arguments[kArgumentWords * dispatch + 1u] = 1u;
  arguments[kArgumentWords * dispatch + 2u] = 1u;
}

void main() {
  if (gl_GlobalInvocationID.x != 0u) return;
  bool found = counts[parameters.place] + counts[parameters.place + 1u] > 0u;
  write_groups(kRoundEdges, found ? parameters.edge_groups : 0u);
  write_groups(kRoundFaces, found ? parameters.face_groups : 0u);
  write_groups(kRoundVertices, found ? parameters.vertex_groups : 0u);
  write_groups(kRoundLargeFaces, found ? parameters.large_face_groups : 0u);
  write_groups(kRoundLargeVertices, found ? parameters.large_vertex_groups : 0u);
}
#endif

#ifdef KERNEL_fair_shrink
// Halves the control points around every flagged vertex about it and takes the flag down, or halves
// them as often as was decided.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
UPDATE(2, uint, flags);
UPDATE(3, uint, decisions);
UPDATE(4, vec4, result);

#include "fair_walk.glsl"

uint halvings_of(uint v, uint kind) {
  if (parameters.decided != 0u) return decisions[v] >> parameters.shift & kHalvingsMask;
  if (flags[v] == 0u) return 0u;
  ring_sync();
  if (leads()) flags[v] = 0u;
  // Corner points and the curves that end there are where they must be.
  if (kind == kCorner) return 0u;
  if (leads()) decisions[v] += 1u << parameters.shift;
  return 1u;
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    uint halvings = halvings_of(v, vertex.kind);
    if (halvings == 0u) continue;
    float factor = ldexp(1.0, -int(halvings));
    FOR_RING(p, vertex.first, vertex.count) result[places_at(p).corner] *= factor;
    if (vertex.kind != kCrease || !leads()) continue;
    result[vertex.curve0] *= factor;
    result[vertex.curve1] *= factor;
  }
}
#endif
