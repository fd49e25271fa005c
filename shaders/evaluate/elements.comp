// Elements of kLength floats, in pieces of up to four: sums of a stencil table's, or of those of
// OpenSubdiv's patches.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

#ifdef KERNEL_apply_stencils
#define PLANISH_PARAMETERS StencilParameters
#include "table.glsl"

READ_OF_WRITTEN(2, float, source)
layout(std430, set = 0, binding = 3) writeonly buffer Target { float target[]; };
#endif
#ifdef KERNEL_eval_patches
#define OSD_PATCH_BASIS_GLSL
#include "osd_patch_basis.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Coords { uint coords[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Arrays { int arrays[]; };
layout(std430, set = 0, binding = 2) restrict readonly buffer Indices { uint indices[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Params { int params[]; };
layout(std430, set = 0, binding = 4) readonly buffer Source { float source[]; };
layout(std430, set = 0, binding = 5) writeonly buffer Target { float target[]; };
layout(push_constant) uniform Parameters { PatchParameters parameters; };

float source_at(uint i) { return source[i]; }
#endif

// Floats of an element, and from one element to the next.
layout(constant_id = 3) const uint kLength = 3u;
layout(constant_id = 4) const uint kSourceStride = kPointFloats;
layout(constant_id = 5) const uint kTargetStride = kPointFloats;

// `left`: floats from `at` to the element's end.
vec4 source_piece(uint at, uint left) {
  vec4 piece = vec4(0.0);
  piece.x = source_at(at);
  if (left > 1u) piece.y = source_at(at + 1u);
  if (left > 2u) piece.z = source_at(at + 2u);
  if (left > 3u) piece.w = source_at(at + 3u);
  return piece;
}

// OpenSubdiv's sums begin at 0, which no addition of zeros makes -0; compilers may leave it out.
void write_piece(vec4 piece, uint at, uint left) {
  piece = mix(piece, vec4(0.0), equal(piece, vec4(0.0)));
  target[at] = piece.x;
  if (left > 1u) target[at + 1u] = piece.y;
  if (left > 2u) target[at + 2u] = piece.z;
  if (left > 3u) target[at + 3u] = piece.w;
}

#ifdef KERNEL_apply_stencils
// Applies a stencil table: for every row the weighted sum of source elements.

void apply_row(ChunkRow at, uint first, uint place, uint left) {
  precise vec4 image = vec4(0.0);
  for (uint k = 0u; k < at.width; ++k) {
    uvec2 entry = entries_at(at.first + k * kChunkRows);
    image += uintBitsToFloat(entry.y) * source_piece(first + entry.x * kSourceStride, left);
  }
  write_piece(image, place, left);
}

void main() {
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) return;
    ChunkRow at = chunk_row(parameters.first_chunk + chunk);
    // kNoRow, of lanes without a row, is beyond every end.
    if (at.row < parameters.begin_row || at.row >= parameters.end_row) continue;
    uint place = parameters.first_target + (at.row - parameters.first_row) * kTargetStride;
    for (uint c = 0u; c < kLength; c += 4u)
      apply_row(at, parameters.first_source + c, place + c, kLength - c);
  }
}
#endif

#ifdef KERNEL_eval_patches
// Evaluates OpenSubdiv's patches: for every coordinate the weighted sum of a patch's elements, by
// its basis or a derivative of it.

// In the order of OsdEvaluatePatchBasis: value, s, t, ss, st, tt.
layout(constant_id = 6) const uint kDerivative = 0u;

struct Patch {
  int type;  // -1: there is none
  OsdPatchParam param;
  uint first_index;
};

// A coordinate that names no patch gets none, rather than what lies beside the buffers.
Patch patch_of(uint array_number, int patch_number) {
  Patch result;
  result.type = -1;
  if (array_number >= parameters.array_count) return result;
  uint at = array_number * kPatchArrayWords;
  OsdPatchArray of = OsdPatchArrayInit(arrays[at], arrays[at + 1u], arrays[at + 2u],
                                       arrays[at + 3u], arrays[at + 4u], arrays[at + 5u]);
  int local = patch_number - of.primitiveIdBase;
  if (local < 0 || local >= of.numPatches) return result;
  at = uint(patch_number) * kPatchParamWords;
  result.param = OsdPatchParamInit(params[at], params[at + 1u], intBitsToFloat(params[at + 2u]));
  result.type = OsdPatchParamIsRegular(result.param) ? of.regDesc : of.desc;
  result.first_index = uint(of.indexBase + of.stride * local);
  return result;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= parameters.coord_count) return;
  uint at = i * kPatchCoordWords;
  Patch patch_at = patch_of(coords[at], int(coords[at + 1u]));
  float weights[6][20];
  int count = 0;
  if (patch_at.type >= 0)
    count = OsdEvaluatePatchBasis(patch_at.type, patch_at.param, uintBitsToFloat(coords[at + 3u]),
                                  uintBitsToFloat(coords[at + 4u]), weights[0], weights[1],
                                  weights[2], weights[3], weights[4], weights[5]);
  uint place = parameters.first_target + i * kTargetStride;
  for (uint c = 0u; c < kLength; c += 4u) {
    precise vec4 sum = vec4(0.0);
    for (int k = 0; k < count; ++k) {
      uint element = indices[patch_at.first_index + uint(k)];
      sum += weights[kDerivative][k] *
             source_piece(parameters.first_source + element * kSourceStride + c, kLength - c);
    }
    write_piece(sum, place + c, kLength - c);
  }
}
#endif
