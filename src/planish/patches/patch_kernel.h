#pragma once

#include <cstdint>

// Includes nothing that has inline code: the kernels of other instruction sets are compiled with
// flags of their own, and what they share with the rest must not be.
namespace planish {

/// Patches of one class that are evaluated side by side.
inline constexpr int kPatchLanes = 8;

struct PatchBatch {
  const double* state;          ///< xyz of each point
  const std::int32_t* indices;  ///< kPatchLanes per column, the own point's first
  const std::int32_t* targets;  ///< per lane the output row of its first sample
  int lane_count;               ///< in use; the others repeat one of them
  const double* weights;        ///< of the first sample: see PatchTemplate
  std::int32_t column_count;    ///< without the own point
  std::int32_t sample_count;
  double* points;  ///< scratch: 3 column_count kPatchLanes, aligned to 64 bytes
};

/// Where results go: rows of three, each array or none. positions = centre + diagonal unit;
/// stored = positions - origin rounded to float. Normals are zero where tangents are parallel.
struct PatchOutput {
  double centre[3] = {0, 0, 0};
  double diagonal = 1;
  double origin[3] = {0, 0, 0};
  double* positions = nullptr;
  float* stored = nullptr;
  float* normals = nullptr;
};

/// Limit points and normals of all samples of a batch. Returns whether a normal came out zero.
using PatchKernel = bool (*)(const PatchBatch& batch, const PatchOutput& output);

bool run_patches_baseline(const PatchBatch& batch, const PatchOutput& output);
bool run_patches_avx2(const PatchBatch& batch, const PatchOutput& output);

/// Vector instructions that a kernel is made for.
enum class PatchInstructions { Baseline, Avx2 };

/// Whether this build has the kernel and this processor its instructions.
[[nodiscard]] bool can_run(PatchInstructions instructions);
/// All kernels give the same bits. Precondition: can_run().
[[nodiscard]] PatchKernel patch_kernel(PatchInstructions instructions);
/// The widest that can run.
[[nodiscard]] PatchInstructions best_instructions();

}  // namespace planish
