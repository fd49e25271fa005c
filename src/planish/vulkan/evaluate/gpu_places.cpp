// Based on: corner patches, a derivation of our own; its twin is limit/limit_surface.cpp.
#include "planish/vulkan/evaluate/gpu_places.h"

#include <algorithm>
#include <string>

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/stencil_pass.h"

namespace planish::vulkan {

namespace {

constexpr std::uint32_t kPlaceLanes = 64;
constexpr std::uint32_t kWord = sizeof(float);

std::uint32_t words_of(std::uint32_t bytes) {
  return bytes == kNotWritten ? shared::kNone : bytes / kWord;
}

// Places as far as they are read, and results as far as they are written.
FloatElements list_elements(const PlaceList& list) {
  return {list.buffer, list.offset / kWord, shared::kPlaceWords, list.stride / kWord};
}
FloatElements result_elements(const PlaceLayout& layout) {
  return {layout.buffer, layout.offset / kWord,
          static_cast<std::uint32_t>(result_bytes(layout) / kWord), layout.stride / kWord};
}

}  // namespace

std::uint64_t result_bytes(const PlaceLayout& layout) {
  std::uint64_t end =
      layout.state_offset == kNotWritten ? 0 : std::uint64_t(layout.state_offset) + kWord;
  for (const std::uint32_t offset :
       {layout.position_offset, layout.normal_offset, layout.du_offset, layout.dv_offset,
        layout.duu_offset, layout.duv_offset, layout.dvv_offset})
    if (offset != kNotWritten) end = std::max(end, std::uint64_t(offset) + 3 * kWord);
  return end;
}

PlaceTables::PlaceTables(const Maker& on, const PlaceRecords& records)
    : face_count(records.face_count),
      corner_count(records.corner_count),
      words(make_bindable(on, records.words.size() * kWord, "planish words of places")),
      weights(make_bindable(on, std::as_bytes(std::span(records.weights)).size(),
                            "planish weights of places")) {}

GpuPlaces::GpuPlaces(Context& context, const PatchTables& patches, const PlaceTables& tables,
                     const BufferRange& given, const BufferRange& state, const PlaceList& list,
                     const PlaceLayout& layout)
    : context_(context), pipeline_(context.pipelines().specialised(Kernel::SurfacePlaces, {})) {
  // The kernel reads any point.
  require_binding(context, state.size, "control points", "take a smaller mesh");
  require_binding(context, given.size, "given points", "take a smaller mesh");
  const std::uint64_t step =
      elements_at_once(context, std::max(list.stride, layout.stride) / kWord, 1);
  std::vector<BoundKernel> bound;
  for (std::uint64_t first = 0; first < list.count; first += step) {
    const std::uint64_t count = std::min(step, list.count - first);
    const ElementWindow from = element_window(list_elements(list), first, count);
    const ElementWindow to = element_window(result_elements(layout), first, count);
    require_window(context, from, "places of a list");
    require_window(context, to, "results of places");
    Dispatch& dispatch = dispatches_.emplace_back();
    dispatch.first = static_cast<std::uint32_t>(first);
    shared::PlaceParameters& parameters = dispatch.parameters;
    parameters.count = static_cast<std::uint32_t>(count);
    parameters.first_place = from.shift;
    parameters.place_stride = list.stride / kWord;
    parameters.face_count = tables.face_count;
    parameters.first_target = to.shift;
    parameters.target_stride = layout.stride / kWord;
    parameters.position = words_of(layout.position_offset);
    parameters.normal = words_of(layout.normal_offset);
    parameters.du = words_of(layout.du_offset);
    parameters.dv = words_of(layout.dv_offset);
    parameters.duu = words_of(layout.duu_offset);
    parameters.duv = words_of(layout.duv_offset);
    parameters.dvv = words_of(layout.dvv_offset);
    parameters.state = words_of(layout.state_offset);
    bound.push_back({Kernel::SurfacePlaces,
                     {from.range, whole(tables.words), whole(patches.links), state, given,
                      whole(tables.weights), to.range}});
  }
  sets_ = DescriptorSets(context, bound);
}

void GpuPlaces::record(VkCommandBuffer commands, std::uint32_t count) const noexcept {
  for (std::size_t i = 0; i < dispatches_.size() && dispatches_[i].first < count; ++i) {
    // Windows of neighbouring dispatches may share their edge.
    if (i > 0) record_barrier(context_, commands, kKernelScope, kKernelScope);
    shared::PlaceParameters parameters = dispatches_[i].parameters;
    parameters.count = std::min(parameters.count, count - dispatches_[i].first);
    record_dispatch(context_, commands, pipeline_, sets_[i], &parameters,
                    (parameters.count + kPlaceLanes - 1) / kPlaceLanes);
  }
}

}  // namespace planish::vulkan
