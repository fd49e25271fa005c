// Evaluates OpenSubdiv's patches: for every coordinate the weighted sum of a patch's elements, by
// its basis or a derivative of it.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
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
#include "elements.glsl"

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
