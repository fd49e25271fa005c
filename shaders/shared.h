// What C++ and the kernels must agree on: table layout, records and parameters. Scalars and float
// arrays only, so that both languages lay it out alike.
#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace planish::vulkan::shared {
using uint = std::uint32_t;
#define PLANISH_SHARED_CONSTANT inline constexpr uint
#else
#define PLANISH_SHARED_CONSTANT const uint
#endif

// A table's rows are cut into chunks. Entry k of the row in lane i of a chunk stands at
// (chunk's first + k) * kChunkRows + i, so that neighbouring lanes read neighbouring words. Rows
// shorter than the chunk's width end in entries of weight 0.
PLANISH_SHARED_CONSTANT kChunkRows = 64u;
// A chunk's header: first, width, then the row number of every lane.
PLANISH_SHARED_CONSTANT kChunkWords = 66u;
// Lane without a row, at the end of a table.
PLANISH_SHARED_CONSTANT kNoRow = 0xffffffffu;
// Points are x, y, z and a float without meaning, so that one load fetches a point.
PLANISH_SHARED_CONSTANT kPointFloats = 4u;
// Invocations of a reduction kernel that runs as a single work group for each result.
PLANISH_SHARED_CONSTANT kReduceLanes = 64u;
// Words of a partial sum of conjugate gradients: bits of xyz, of the square sum, of the maximum.
PLANISH_SHARED_CONSTANT kSumFloats = 5u;

// One iteration: what it does, and what it found before doing it.
struct StepRecord {
  float momentum;
  float gain;
  uint max_square_bits;  // of |residual|; infinity where a residual is NaN
  float square_sum;
};

// How a solve ended. The first three words are what hosts are given as GpuStatus. side: which of
// the three displacement buffers holds the result.
struct SolveStatus {
  uint iterations;
  uint state;
  float residual;  // the error measured last
  uint max_square_bits;
  uint side;
};
PLANISH_SHARED_CONSTANT kStateRunning = 0u;    // all steps done, the last error measured is above
PLANISH_SHARED_CONSTANT kStateConverged = 1u;  // an error at or below stop was met
PLANISH_SHARED_CONSTANT kStateNotFinite = 2u;  // the last error measured is infinite or no number

// Words of an indirect dispatch's arguments.
PLANISH_SHARED_CONSTANT kArgumentWords = 3u;

// Push constants of the kernels that walk a table. Rows are counted from the start of the bound
// window; a row number in a chunk minus first_row is the place in it.
struct TableParameters {
  uint chunk_count;
  uint first_row;
  uint first_source;  // point that the source window begins with
  uint first_target;  // floats between the target window's start and first_row's place
  uint step;
  uint first_group;     // of this slice, among the groups of all slices
  uint partials_total;  // partial sums that a step yields
  float stop_square;    // negative: never stop
  uint target_stride;   // floats from one point of the target to the next
  uint normal_offset;   // floats from a point's position to its normal
};

// Push constants of apply_stencils. Offsets are in floats, from the start of the bound window.
struct StencilParameters {
  uint first_chunk;
  uint chunk_count;
  uint begin_row;  // rows before it and from end_row on are left alone
  uint end_row;
  uint first_row;     // whose element is at first_target
  uint first_source;  // of the source that entries count from
  uint first_target;
};

// Words of OpenSubdiv's Osd::PatchCoord, of a patch array and of Osd::PatchParam, as kernels read
// them. An array: regular type, irregular type, patches, first index, indices of a patch, first
// patch.
PLANISH_SHARED_CONSTANT kPatchCoordWords = 5u;
PLANISH_SHARED_CONSTANT kPatchArrayWords = 6u;
PLANISH_SHARED_CONSTANT kPatchParamWords = 3u;

// Push constants of eval_patches. Offsets are in floats, from the start of the bound window.
struct PatchParameters {
  uint coord_count;
  uint array_count;
  uint first_source;  // of element 0
  uint first_target;  // of the first coordinate
};

// Push constants of the kernels that walk vectors or partial sums.
struct VectorParameters {
  uint count;
  uint first_group;
  float stop_square;
  uint first_side;
  float x, y, z;
  uint step_count;     // steps that move; one more only measures
  uint first_vertex;   // that a window of strided points begins with
  uint source_shift;   // floats between the window's start and it
  uint source_stride;  // floats from one point to the next
  uint warm;           // 1: from the last displacement, 0: from none
};

// The fair construction: topology records, see FairTopology. Indices of control points are those of
// the state of level 1, whose first points are the corners'.
PLANISH_SHARED_CONSTANT kNone = 0xffffffffu;
// VertexKind.
PLANISH_SHARED_CONSTANT kSmooth = 0u;
PLANISH_SHARED_CONSTANT kDart = 1u;
PLANISH_SHARED_CONSTANT kCrease = 2u;
PLANISH_SHARED_CONSTANT kCorner = 3u;

struct FairVertex {
  uint first;  // of its places: corners around it, counter-clockwise
  uint count;
  uint kind;
  uint regular;           // 1: only quads around it
  uint before, after;     // at crease vertices: neighbours along the curve
  uint curve0, curve1;    // and the control points on the way to them
  uint circle;            // where the unit circle has the regular polygon of `count` points
  uint near_curve;        // 1: within two edges of a crease, boundary or corner vertex
  uint unused0, unused1;  // records that every vertex, corner or face has are whole texels
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
  uint unused;
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
  uint first, count;  // of its places
};
struct FairSector {
  uint vertex;
  uint first;  // place
  uint count;
  uint crease;
  uint handle;  // control point on the curve before its vertex's first sector
};
struct FairCurvePoint {
  uint vertex, other;
  uint kind;           // of the vertex
  uint after, before;  // at darts: the corners beside it
};

// What the construction counts: edges and faces turned over, per round of repair.
PLANISH_SHARED_CONSTANT kRepairRounds = 3u;
PLANISH_SHARED_CONSTANT kRepairCounts = 8u;  // (kRepairRounds + 1) * edges and faces
PLANISH_SHARED_CONSTANT kFairCounts = 16u;   // words: two repairs

// FairDecisions of a vertex in one word: halvings before the polish, and kLateShift bits higher
// those after it, then whether its polygon was reversed.
PLANISH_SHARED_CONSTANT kHalvingsMask = 0xffu;
PLANISH_SHARED_CONSTANT kLateShift = 8u;
PLANISH_SHARED_CONSTANT kReversed = 0x10000u;

// The dispatches of a round of repair whose work groups the device decides, in the order of their
// arguments.
PLANISH_SHARED_CONSTANT kRoundEdges = 0u;
PLANISH_SHARED_CONSTANT kRoundFaces = 1u;
PLANISH_SHARED_CONSTANT kRoundVertices = 2u;
PLANISH_SHARED_CONSTANT kRoundDispatches = 3u;

// The scalars of the polish.
struct FairScalars {
  float square;       // of the residual, preconditioned
  float enough;       // at which it has converged
  float step;         // along the direction
  float momentum;     // of the last direction in the next
  uint largest_bits;  // of the mean diagonals
};

// Work groups of kernels that sum, at most: their partial sums are added up by one work group.
PLANISH_SHARED_CONSTANT kMostSumGroups = 1024u;

// Push constants of the fair construction's kernels.
struct FairParameters {
  uint count;                                    // elements to do
  uint place;                                    // of repair's counts
  uint start;                                    // 1: the polish begins
  uint partial_count;                            // partial sums
  float x, y, z;                                 // origin of the unit coordinates
  float scale;                                   // model units of one unit
  uint decided;                                  // 1: decisions are given, not made
  uint shift;                                    // of repair's halvings in a vertex's decisions
  uint edge_groups, face_groups, vertex_groups;  // that a round of repair takes
};

#ifdef __cplusplus
}  // namespace planish::vulkan::shared
#endif
