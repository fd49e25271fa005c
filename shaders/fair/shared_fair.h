// What C++ and the kernels of the fair construction must agree on, beside shared.h.
#ifdef __cplusplus
#pragma once
#include "shaders/shared.h"
namespace planish::vulkan::shared {
#else
#include "shared.h"
#endif

// Vertices, faces and sectors of so many corners are walked around by a work group, others by a
// lane: kSummedRing of doosabin/subdivision.h.
PLANISH_SHARED_CONSTANT kLargeRing = 32u;

// The fair construction: topology records, see FairTopology; those that every vertex, corner, face
// or edge has are whole texels. Indices of control points are those of
// the state of level 1, whose first points are the corners'.
struct FairVertex {
  uint first;  // of its places: corners around it, counter-clockwise
  uint count;
  uint kind;
  uint regular;         // 1: only quads around it
  uint before, after;   // at crease vertices: neighbours along the curve
  uint curve0, curve1;  // and the control points on the way to them
  uint circle;          // where the unit circle has the regular polygon of `count` points
  uint near_curve;      // 1: within two edges of a crease, boundary or corner vertex
  uint large;           // of the i-th vertex: the i-th that has kLargeRing corners and more
  uint plane;           // 1 + a face of the plane that is kept there; 0: none
};
struct FairPlace {
  uint corner;
  uint next, previous;  // the vertices beside it in its face
  uint face;
};
// Of a corner: what stands beside it.
struct FairLinks {
  uint next, previous;  // corners in its face
  uint after, before;   // control points around its vertex
};
struct FairFace {
  uint first;  // corner
  uint count;
  uint circle;
  uint large;  // of the i-th face: the i-th of kLargeRing corners and more
};
struct FairEdge {
  uint corner0, corner1, corner2, corner3;
  uint face0, face1;
  uint unused0, unused1;
};
struct FairCrease {
  uint vertex;
  uint before, after;
  uint curve0, curve1;
  uint first, count;    // of its places
  uint large;           // as of faces
  uint plane0, plane1;  // of its sectors, as of vertices; the first ones that have any
};
struct FairSector {
  uint vertex;
  uint first;  // place
  uint count;
  uint crease;
  uint handle;  // control point on the curve before its vertex's first sector
  uint large;   // as of faces
  uint plane;   // as of vertices
};
struct FairCurvePoint {
  uint vertex, other;
  uint kind;           // of the vertex
  uint after, before;  // at darts: the corners beside it
};

// What the construction counts: edges and faces turned over, per round of repair.
PLANISH_SHARED_CONSTANT kRepairRounds = 3u;
PLANISH_SHARED_CONSTANT kRepairCounts = 8u;  // (kRepairRounds + 1) * edges and faces
// Then how many vertices each round of the cure changed, two words a round as fair_round reads
// them; then edges and faces turned over in the end.
PLANISH_SHARED_CONSTANT kCureRounds = 3u;
PLANISH_SHARED_CONSTANT kCureCounts = 16u;  // the first of them
PLANISH_SHARED_CONSTANT kEndCounts = 22u;
PLANISH_SHARED_CONSTANT kFairCounts = 24u;

// FairDecisions of a vertex in one word: halvings before the polish, and kLateShift bits higher
// those after it, then whether its polygon was reversed; in the highest byte its rounds of the
// cure.
PLANISH_SHARED_CONSTANT kHalvingsMask = 0xffu;
PLANISH_SHARED_CONSTANT kLateShift = 8u;
PLANISH_SHARED_CONSTANT kReversed = 0x10000u;
PLANISH_SHARED_CONSTANT kCureShift = 24u;

// The lean of a cured polygon's plane that is not chosen yet: kNoLean of fair/fair_topology.h as a
// float.
PLANISH_SHARED_CONSTANT kNoLeanBits = 0x4e800000u;

// What the cure knows of a vertex, in its word of flags. While it looks for what is turned away:
// the first three, and in place of the others the float whose lowest bits they are: the least
// cosine that the places around the vertex must have with its faces, 0 where they need not be
// looked at. After that: what is to be done.
PLANISH_SHARED_CONSTANT kBad = 1u;
PLANISH_SHARED_CONSTANT kTouched = 2u;        // in a face with a changed one
PLANISH_SHARED_CONSTANT kChanged = 4u;        // by the last round
PLANISH_SHARED_CONSTANT kCureFlags = 0xfu;    // all bits of them and of the next
PLANISH_SHARED_CONSTANT kRebuild = 8u;        // by a perpendicular polygon
PLANISH_SHARED_CONSTANT kQuartersShift = 8u;  // and how often it is scaled by a quarter after that

// The dispatches of a round of repair whose work groups the device decides, in the order of their
// arguments.
PLANISH_SHARED_CONSTANT kRoundEdges = 0u;
PLANISH_SHARED_CONSTANT kRoundFaces = 1u;
PLANISH_SHARED_CONSTANT kRoundVertices = 2u;
PLANISH_SHARED_CONSTANT kRoundLargeFaces = 3u;
PLANISH_SHARED_CONSTANT kRoundLargeVertices = 4u;
PLANISH_SHARED_CONSTANT kRoundDispatches = 5u;

// The scalars of the polish.
struct FairScalars {
  float square;       // of the residual, preconditioned
  float enough;       // at which it has converged
  float step;         // along the direction
  float momentum;     // of the last direction in the next
  uint largest_bits;  // of the mean diagonals
  uint parts;         // of a sum, that work groups have written
};

// Push constants of the fair construction's kernels.
struct FairParameters {
  uint count;                                    // elements to do
  uint place;                                    // of repair's counts
  uint start;                                    // 1: the polish or the cure begins
  uint partial_count;                            // partial sums of a round
  uint first_partial;                            // of those, this dispatch's
  float x, y, z;                                 // origin of the unit coordinates
  float scale;                                   // model units of one unit
  uint decided;                                  // 1: decisions are given, not made
  uint shift;                                    // of repair's halvings in a vertex's decisions
  uint edge_groups, face_groups, vertex_groups;  // that a round of repair takes
  uint large_face_groups, large_vertex_groups;   // and for large ones
  uint vertex_count;                             // of the mesh
  uint corner_count;                             // where the state's curve points begin
  uint only_counts;                              // 1: the cure's looks count, and flag nothing
  uint darts_only;                               // 1: of the curve points
  uint of_net;                                   // 1: offsets of one step of the net, not of points
};

#ifdef __cplusplus
}  // namespace planish::vulkan::shared
#endif
