// What C++ and the kernels must agree on: table layout, records and parameters. Scalars and float
// arrays only, so that both languages lay it out alike.
#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace planish::vulkan::shared {
using uint = std::uint32_t;
#define PLANISH_SHARED_CONSTANT inline constexpr uint
#endif
#include "surface/planish_surface_tables.h"

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

// Instances of a mesh are a dispatch's work groups in y. Their vectors stand one after another in a
// buffer, and so do their records of a step. Where a kernel's parameters count further_instances,
// zeros are one instance.

// Push constants of the kernels that walk a table. Rows are counted from the start of the bound
// window; a row number in a chunk minus first_row is the place in it.
struct TableParameters {
  uint chunk_count;
  uint first_row;
  uint first_source;  // point that the source window begins with
  uint step;
  uint first_group;     // of this slice, among the groups of all slices
  uint partials_total;  // partial sums that a step yields
  float stop_square;    // negative: never stop
  uint instance_rows;   // points from an instance's vectors to the next one's
  uint further_instances;
};

// Rows of which one work group takes all steps: where that many dispatches would wait for each
// other for little work.
PLANISH_SHARED_CONSTANT kSmallRows = 256u;

// Push constants of all_steps.
struct AllStepsParameters {
  uint chunk_count;
  uint instance_rows;  // points from an instance's vectors to the next one's
  uint instances;
  uint step_count;  // steps that move
  uint measured;    // and those with one that only measures, if any
  uint first_side;
  float stop_square;
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

// Corner patches.
// Where a patch's control points come from, a specialisation constant: found on the way from corner
// to corner (around a corner, a vertex, a face or the midpoint of an edge), or listed.
PLANISH_SHARED_CONSTANT kGatherCorner = 0u;
PLANISH_SHARED_CONSTANT kGatherVertex = 1u;
PLANISH_SHARED_CONSTANT kGatherFace = 2u;
PLANISH_SHARED_CONSTANT kGatherEdge = 3u;
PLANISH_SHARED_CONSTANT kGatherList = 4u;
// As each group says, and samples at once, too: all patches of a level in one dispatch, for devices
// that take all lanes of a group one way.
PLANISH_SHARED_CONSTANT kGatherAny = 5u;
// Patches of one class, one to a lane.
PLANISH_SHARED_CONSTANT kPatchLanes = 64u;
// What a group of patches is known by, in this order. Its words are kPatchLanes corners if flagged,
// as many rows if flagged, then the lists of points, column by column, then the frames of textured
// rows, sample by sample: bits of the factors of du and dv that make the tangent, the second one's
// lowest bit set where the texture is mirrored.
struct PatchGroup {
  uint first_word;
  uint lane_count;
  uint first_weight;
  uint columns;      // points without the own one
  uint corner;       // of lane 0
  uint corner_step;  // from lane to lane
  uint row;          // of lane 0
  uint row_step;     // from lane to lane, or from corner to corner if flagged
  uint ring;         // faces around the vertex
  uint face;         // corners of the face
  uint flags;
  uint form;  // where ways are joined: kGatherCorner..., and from the bits below on
};
PLANISH_SHARED_CONSTANT kFormSamples = 4u;  // samples at once
PLANISH_SHARED_CONSTANT kFormChunks = 8u;   // chunks of the group, at most kBlockChunks
PLANISH_SHARED_CONSTANT kFormBlock = 16u;   // which kBlockChunks of the patches' chunks they are
PLANISH_SHARED_CONSTANT kBlockChunks = 8u;
PLANISH_SHARED_CONSTANT kGroupVectors = 3u;  // of four words
PLANISH_SHARED_CONSTANT kCornersAreWords = 1u;
PLANISH_SHARED_CONSTANT kRowsAreWords = 2u;
PLANISH_SHARED_CONSTANT kRowsFollowCorners = 4u;
PLANISH_SHARED_CONSTANT kHasPositions = 8u;
PLANISH_SHARED_CONSTANT kHasNormals = 16u;
// Samples that a lane evaluates at once where a patch has a multiple of them, as all of a corner's
// are: 4^n - 1.
PLANISH_SHARED_CONSTANT kSampleChunk = 3u;

// Push constants of corner_patches. Windows begin with first_word, first_weight and the target's
// first_row.
struct CornerPatchParameters {
  uint unit_count;  // groups times chunks of samples
  uint chunk_count;
  uint first_group;
  uint first_word;
  uint first_weight;
  uint first_row;
  // Words from the window's start to first_row's position and normal, from a row to the next, and
  // from an instance to the next.
  uint first_position, position_stride, position_instance;
  uint first_normal, normal_stride, normal_instance;
  uint tangent_shift;  // words from a normal to its tangent
  // From an instance to the next: points of the state, given points.
  uint instance_points;
  uint instance_rows;
  // What compact positions count from, and what a unit of theirs is divided by.
  float center_x, center_y, center_z;
  float scale_x, scale_y, scale_z;
  // Of listed_patches: words of what an edit works on where the segment stands, and jobs from an
  // instance to the next. Of instance_patches: where the list of instances stands.
  uint segment;
  uint job_count;
};

// VertexFormat.
PLANISH_SHARED_CONSTANT kFormatFloat3 = 0u;
PLANISH_SHARED_CONSTANT kFormatHalf4 = 1u;
PLANISH_SHARED_CONSTANT kFormatSnorm16x4 = 2u;
PLANISH_SHARED_CONSTANT kFormatOctahedral16 = 3u;
PLANISH_SHARED_CONSTANT kFormatSnorm10 = 4u;
PLANISH_SHARED_CONSTANT kFormatFloat4 = 5u;
PLANISH_SHARED_CONSTANT kFormatNone = 6u;

// The surface at lists of places. Words of a place: face, u, v.
PLANISH_SHARED_CONSTANT kPlaceWords = 3u;
// What comes of a place.
PLANISH_SHARED_CONSTANT kPlaceRegular = 0u;
PLANISH_SHARED_CONSTANT kPlaceSingular = 1u;  // without second derivatives
PLANISH_SHARED_CONSTANT kPlaceNone = 2u;      // outside the surface: zeros

// Push constants of surface_places. All are in words; kNone where a result is not wanted.
struct PlaceParameters {
  uint count;
  uint first_place;  // from the window's start
  uint place_stride;
  uint face_count;
  uint first_target;  // from the window's start
  uint target_stride;
  uint position, normal, du, dv, duu, duv, dvv, state;  // from a target's start
};

// What a dispatch of first_step makes: the points of faces' corners, a lane each; those of large
// faces, a work group a face; those beside sharp edges and at corner vertices.
PLANISH_SHARED_CONSTANT kStepFaces = 0u;
PLANISH_SHARED_CONSTANT kStepLargeFaces = 1u;
PLANISH_SHARED_CONSTANT kStepSharp = 2u;
// Faces of so many corners are large: kSummedRing of doosabin/subdivision.h.
PLANISH_SHARED_CONSTANT kStepLargeFace = 32u;
// A large face's words: its first corner, its size, where cosine and sine of each corner begin.
PLANISH_SHARED_CONSTANT kLargeFaceWords = 3u;

// Push constants of first_step.
struct FirstStepParameters {
  uint count;        // of points, or of large faces
  uint first_point;  // of the state, that lane 0 does
  uint first_word;   // of the sharp points or large faces
  // From an instance to the next: points of the state, given points.
  uint instance_points;
  uint instance_rows;
  float own, beside, mean, turn;  // FaceSumRule of doosabin/subdivision.h
  // Where the words are that name the instance of each work group in y; kNone: all instances.
  uint first_listed;
};

// A large ring, of kRingWords words: where the places of its points in the state begin, their
// count, the count of its corners, its first sum, the vertex that sums are offsets from, and where
// weights begin, three floats a point, behind which are cosine and sine of each corner's angle.
const uint kRingWords = 6u;
const uint kRingLanes = 64u;

// Push constants of ring_sums.
struct RingSumParameters {
  uint count;         // of rings
  uint first_target;  // of the state, that the target's window begins with
  // From an instance to the next: points of the state, given points.
  uint instance_points;
  uint instance_rows;
  uint first_listed;  // as of first_step
};

// Levels by need. What they are chosen by and listed in is a buffer of words: a record of each
// level, from coarse to fine, and a segment of each dispatch that walks a list of instances.
// Words of a level: places in its list, vertices and indices of an instance, its first index, its
// first vertex, where its list begins, and the vertices of an instance at all coarser levels.
PLANISH_SHARED_CONSTANT kMostLevels = 5u;
PLANISH_SHARED_CONSTANT kLevelPlaces = 0u;
PLANISH_SHARED_CONSTANT kLevelVertices = 1u;
PLANISH_SHARED_CONSTANT kLevelIndices = 2u;
PLANISH_SHARED_CONSTANT kLevelFirstIndex = 3u;
PLANISH_SHARED_CONSTANT kLevelFirstVertex = 4u;
PLANISH_SHARED_CONSTANT kLevelList = 5u;
PLANISH_SHARED_CONSTANT kLevelFirstRow = 6u;
PLANISH_SHARED_CONSTANT kLevelWords = 7u;
// Words of a list's entry, a DrawnInstance.
PLANISH_SHARED_CONSTANT kDrawnWords = 2u;
// Words of a segment: arguments, whose y counts the instances of its list, and the list's level;
// kNone: the list of all that are seen, which stands behind the segments.
PLANISH_SHARED_CONSTANT kChosenLevel = 3u;
PLANISH_SHARED_CONSTANT kChosenWords = 4u;
// Words of a VkDrawIndexedIndirectCommand.
PLANISH_SHARED_CONSTANT kDrawWords = 5u;

// Push constants of choose_levels.
struct ChooseParameters {
  float clip[16];  // from the world, column by column, to Vulkan's clip space
  uint instance_count;
  uint point_count;   // of one instance
  uint point_stride;  // from an instance to the next
  uint level_count;
  float pixels;               // of a length of 1 across the view where w is 1
  float most;                 // pixels between triangles and surface
  float coarser_at;           // pixels below which a coarser level is taken
  float chords[kMostLevels];  // of each level, for a bounding sphere of radius 1
};

// Push constants of place_instances.
struct PlaceInstancesParameters {
  uint instance_count;
  uint level_count;
  uint segment_count;
  uint numbers_draws;  // 1: a draw's first instance is the instance's number
};

// Edits. What one works on is a buffer of words: these, a segment for each dispatch of patches, the
// list of rows that the edit has reached, the lists of the segments. A row of the list is a place
// in the vectors of all instances. Arguments are those of indirect dispatches.
PLANISH_SHARED_CONSTANT kEditRows = 0u;     // in the list
PLANISH_SHARED_CONSTANT kEditPatches = 1u;  // in those of all segments
PLANISH_SHARED_CONSTANT kEditMoves = 2u;    // moved points that the host names
PLANISH_SHARED_CONSTANT kEditHeld = 3u;     // of the rows, those that a step moves
PLANISH_SHARED_CONSTANT kEditSpread = 4u;   // of them, those whose neighbours are in the list
PLANISH_SHARED_CONSTANT kEditForRows = 8u;  // arguments of what walks the list
PLANISH_SHARED_CONSTANT kEditForHeld = 12u;
PLANISH_SHARED_CONSTANT kEditForMoves = 16u;
PLANISH_SHARED_CONSTANT kEditHeadWords = 24u;
// Words of a segment: patches in its list, arguments, where the list begins, the job behind its
// last one, chunks of samples of a patch. A job is lane i of patch group g as g * kPatchLanes + i.
PLANISH_SHARED_CONSTANT kSegmentArguments = 1u;
PLANISH_SHARED_CONSTANT kSegmentList = 4u;
PLANISH_SHARED_CONSTANT kSegmentEnd = 5u;
PLANISH_SHARED_CONSTANT kSegmentChunks = 6u;
PLANISH_SHARED_CONSTANT kSegmentWords = 8u;

// What is said of a row in all lists: whether it is in an edit's, and from bit kStaleShift on for
// each slot of frames in flight whether it is in that one's list of stale rows, which edits of
// other slots have moved since its vertices were written. Of these lists a buffer of words holds
// heads for all slots, each a count and arguments, and then `most_stale` rows for each.
PLANISH_SHARED_CONSTANT kRowListed = 1u;
PLANISH_SHARED_CONSTANT kStaleShift = 1u;
PLANISH_SHARED_CONSTANT kStaleArguments = 1u;
PLANISH_SHARED_CONSTANT kStaleWords = 4u;

// Push constants of the kernels of edits.
struct EditParameters {
  uint row_count;   // of one instance
  uint row_stride;  // from an instance to the next
  uint instances;
  uint max_groups;
  uint first_listed;  // word where the list of rows begins
  uint step;          // kNone: nothing is moved
  float stop_square;
  // take: the host's list and points.
  uint moves_shift;  // words between the window's start and the count
  uint most_moves;
  uint given_count;
  uint source_shift, source_stride, instance_floats;  // as in VectorParameters
  uint first_source;                                  // residual: of the slice
  uint first_sharp;   // places from here on are points beside sharp edges
  uint first_word;    // of those points
  uint point_stride;  // points of the state, from an instance to the next
  uint job_count;
  uint slot, slot_count;
  uint most_stale;
};

// Push constants of the kernels that walk vectors or partial sums.
struct VectorParameters {
  uint count;
  float stop_square;
  uint first_side;
  uint step_count;       // steps that move; one more only measures
  uint source_shift;     // floats between the start of a window of strided points and the first
  uint source_stride;    // floats from one point to the next
  uint warm;             // 1: from the last displacement, 0: from none
  uint keeps_side;       // 1: the steps were those of an edit, which goes round in no buffers
  uint instance_rows;    // points from an instance's vectors to the next one's
  uint instance_floats;  // of strided points, from an instance to the next
  uint further_instances;
};

// VertexKind.
PLANISH_SHARED_CONSTANT kSmooth = 0u;
PLANISH_SHARED_CONSTANT kDart = 1u;
PLANISH_SHARED_CONSTANT kCrease = 2u;
PLANISH_SHARED_CONSTANT kCorner = 3u;

// Where the mesh bends least: BendingTable of fair/bending.h. An entry is the vertex and the
// weight in the row; those of the other vertex's row stand apart.
struct BendingVertex {
  uint first;  // of its entries
  uint word;   // VertexKind, kBendingClosed, and how many entries from kBendingCountShift on
  float inverse_area;
  float step;
};
PLANISH_SHARED_CONSTANT kBendingKind = 3u;
PLANISH_SHARED_CONSTANT kBendingClosed = 4u;
PLANISH_SHARED_CONSTANT kBendingCountShift = 3u;

// Push constants of the kernels that make it so.
struct BendingParameters {
  uint count;          // vertices
  uint instance_rows;  // points from an instance's vectors to the next one's
  float unit;          // of the table's coordinates, in those of the points
  float bound;
  float momentum;
  uint is_last;  // step: the points are moved
};

// Work groups of kernels that sum, at most: their partial sums are added up by one work group.
PLANISH_SHARED_CONSTANT kMostSumGroups = 1024u;

#ifdef __cplusplus
}  // namespace planish::vulkan::shared
#endif
