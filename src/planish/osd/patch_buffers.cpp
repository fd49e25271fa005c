#include "planish/osd/patch_buffers.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "shaders/shared.h"

namespace planish::osd {

namespace {

using OpenSubdiv::Osd::PatchArray;
using OpenSubdiv::Osd::PatchArrayVector;
using OpenSubdiv::Osd::PatchParam;
using OpenSubdiv::Osd::PatchParamVector;

static_assert(sizeof(OpenSubdiv::Osd::PatchCoord) ==
              vulkan::shared::kPatchCoordWords * sizeof(float));
static_assert(sizeof(PatchParam) == vulkan::shared::kPatchParamWords * sizeof(float));

vulkan::Buffer Upload(std::span<std::byte const> bytes, char const* name,
                      VkDeviceContext& deviceContext) {
  vulkan::Context& context = deviceContext.GetContext();
  vulkan::Buffer buffer = vulkan::make_bindable(context, bytes.size(), name);
  deviceContext.Upload(buffer.handle(), 0, bytes);
  return buffer;
}

}  // namespace

std::shared_ptr<vulkan::Buffer> MakeParamBuffer(PatchParamVector const& params,
                                                VkDeviceContext& deviceContext) {
  return std::make_shared<vulkan::Buffer>(
      Upload(std::as_bytes(std::span(params)), "planish patch parameters", deviceContext));
}

std::shared_ptr<PatchBuffers> MakePatchBuffers(PatchArrayVector const& patchArrays,
                                               std::span<int const> indices,
                                               std::shared_ptr<vulkan::Buffer> params,
                                               VkDeviceContext& deviceContext) {
  auto patches = std::make_shared<PatchBuffers>();
  patches->patchArrays = patchArrays;
  if (!indices.empty()) patches->numPoints = *std::max_element(indices.begin(), indices.end()) + 1;
  std::vector<int> words;
  for (PatchArray const& array : patchArrays)
    words.insert(words.end(),
                 {array.GetPatchTypeRegular(), array.GetPatchTypeIrregular(), array.GetNumPatches(),
                  array.GetIndexBase(), array.GetStride(), array.GetPrimitiveIdBase()});
  patches->arrays = Upload(std::as_bytes(std::span(words)), "planish patch arrays", deviceContext);
  patches->indices = Upload(std::as_bytes(indices), "planish patch indices", deviceContext);
  patches->params = std::move(params);
  return patches;
}

}  // namespace planish::osd
