#include "planish/patches/kernel_body.h"

namespace planish {

bool run_patches_avx2(const PatchBatch& batch, const PatchOutput& output) {
  return run_batch(batch, output);
}

bool run_faces_avx2(const FaceBatch& batch, const PatchOutput& output) {
  return run_face_batch(batch, output);
}

}  // namespace planish
