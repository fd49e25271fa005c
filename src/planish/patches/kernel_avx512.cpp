#include "planish/patches/kernel_body.h"

namespace planish {

bool run_patches_avx512(const PatchBatch& batch, const PatchOutput& output) {
  return run_batch(batch, output);
}

bool run_faces_avx512(const FaceBatch& batch, const PatchOutput& output) {
  return run_face_batch(batch, output);
}

}  // namespace planish
