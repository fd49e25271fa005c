#pragma once

#include "planish/patches/patch_kernel.h"

// As patch_kernel.h, free of inline code.
namespace planish {

/// Control points that the four regular patches of a quad have together: corner i's own is column
/// i; counter-clockwise around its vertex follow 4 + (i + 3) % 4, 12 + i and 8 + i.
inline constexpr int kFaceColumns = 16;

/// Samples of a patch at level 2, and for each the columns of the regular class, but the own one,
/// whose weights are not all zero: a bit each.
inline constexpr int kFaceSamples = 9;
inline constexpr unsigned char kFaceSampleColumns[kFaceSamples] = {0x4F, 0xFF, 0x7C, 0xA7, 0x07,
                                                                   0x4C, 0xA1, 0xB9, 0x38};

/// Limit points that a quad has: of the vertex of corner i by its ring from that corner on (i), of
/// the midpoint of its leading edge (4 + i), of the centre (8).
inline constexpr int kFacePoints = 9;

/// Quads side by side: a lane is a quad with kFaceColumns columns of indices and the first corner's
/// target, whose rows those of the other corners follow. Weights are the regular class's, 3 or 9
/// samples a corner.
struct FaceBatch : PatchBatch {
  /// A bit for each limit point that is made as well; then the output has positions and normals.
  unsigned wanted_points;
  const double* point_weights;  ///< of limit points between four
  double* point_positions;      ///< of point q and lane l row kPatchLanes q + l
  float* point_normals;
};

/// The same bits as patch by patch and point by point. Returns whether a normal came out zero.
using FaceKernel = bool (*)(const FaceBatch& batch, const PatchOutput& output);

/// The kernel for quads with four regular patches beside one for patches.
[[nodiscard]] FaceKernel face_kernel(PatchKernel kernel);

bool run_faces_baseline(const FaceBatch& batch, const PatchOutput& output);
bool run_faces_avx2(const FaceBatch& batch, const PatchOutput& output);

}  // namespace planish
