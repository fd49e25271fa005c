#include "planish/patches/patch_kernel.h"

#include "planish/patches/face_kernel.h"

namespace planish {

bool can_run(PatchInstructions instructions) {
#ifdef PLANISH_X86_KERNELS
  if (instructions == PatchInstructions::Avx2) return __builtin_cpu_supports("avx2") != 0;
#endif
  return instructions == PatchInstructions::Baseline;
}

PatchKernel patch_kernel(PatchInstructions instructions) {
#ifdef PLANISH_X86_KERNELS
  if (instructions == PatchInstructions::Avx2) return run_patches_avx2;
#endif
  (void)instructions;
  return run_patches_baseline;
}

FaceKernel face_kernel(PatchKernel kernel) {
#ifdef PLANISH_X86_KERNELS
  if (kernel == run_patches_avx2) return run_faces_avx2;
#endif
  (void)kernel;
  return run_faces_baseline;
}

PatchInstructions best_instructions() {
  return can_run(PatchInstructions::Avx2) ? PatchInstructions::Avx2 : PatchInstructions::Baseline;
}

}  // namespace planish
