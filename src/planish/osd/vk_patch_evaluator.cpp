#include "planish/osd/vk_patch_evaluator.h"

#include <algorithm>
#include <memory>

#include "planish/osd/evaluator_passes.h"
#include "planish/osd/patch_pass.h"

namespace planish::osd {

bool VkEvaluator::fits(BufferDescriptor const& desc, int length) {
  return length > 0 && desc.length == length && desc.stride >= length && desc.offset >= 0;
}

bool VkEvaluator::fit(Bound const& src, Destinations const& to) {
  if (!src.buffer || !fits(src.desc, src.desc.length)) return false;
  return std::all_of(to.begin(), to.end(), [&](Bound const& one) {
    return !one.buffer || fits(one.desc, src.desc.length);
  });
}

bool VkPatchEvaluator::evalPatches(VkDeviceContext* deviceContext, Bound const& src,
                                   Destinations const& to, int numPatchCoords, VkBuffer patchCoords,
                                   PatchBuffers const* patches) {
  if (!deviceContext || !patches || !fit(src, to) || numPatchCoords < 0) return false;
  if (numPatchCoords == 0) return true;
  if (!patchCoords) return false;
  auto const passes = std::make_shared<std::vector<PatchPass>>();
  for (std::size_t i = 0; i < to.size(); ++i)
    if (to[i].buffer)
      passes->emplace_back(deviceContext->GetContext(), *patches,
                           PatchCoords{patchCoords, numPatchCoords}, Elements(src.buffer, src.desc),
                           Elements(to[i].buffer, to[i].desc), static_cast<int>(i));
  RunPasses(*deviceContext, passes);
  return true;
}

}  // namespace planish::osd
