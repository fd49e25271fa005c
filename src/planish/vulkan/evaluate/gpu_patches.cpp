// Based on: corner patches, a derivation of our own; see patches/patch_surface.cpp, its twin.
#include "planish/vulkan/evaluate/gpu_patches.h"

#include <algorithm>

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/stencil_pass.h"

namespace planish::vulkan {

namespace {

constexpr std::uint32_t kVectorFloats = 3;

// The host's vertices as far as they are written.
FloatElements elements_of(const VertexLayout& layout) {
  const std::uint32_t last = std::max(layout.position_offset, layout.normal_offset);
  return {layout.buffer, layout.offset / sizeof(float),
          static_cast<std::uint32_t>(last / sizeof(float)) + kVectorFloats,
          static_cast<std::uint32_t>(layout.stride / sizeof(float))};
}

}  // namespace

GpuPatches::GpuPatches(Context& context, const PatchTables& tables, const Buffer& given,
                       const Buffer& state, const VertexLayout& layout, std::uint64_t vertex_count,
                       const Instances& instances, const ListedPatches& listed)
    : context_(context),
      instances_(instances),
      work_(listed.work ? listed.work->handle() : VK_NULL_HANDLE) {
  const Kernel kernel = work_ ? Kernel::ListedPatches : Kernel::CornerPatches;
  const auto point_count = static_cast<std::uint64_t>(tables.point_count);
  const std::uint32_t units_per_group = context.variant().chunks_per_group;
  std::vector<BoundKernel> bound;
  for (const PatchSlice& slice : tables.slices) {
    ElementWindow target =
        element_window(elements_of(layout), static_cast<std::uint64_t>(slice.rows.first),
                       static_cast<std::uint64_t>(slice.rows.count));
    target.range.size += instances.further() * layout.instance_stride;
    check_range(context, target);
    const std::uint32_t constants[] = {slice.gather, slice.samples};
    Dispatch& dispatch = dispatches_.emplace_back();
    dispatch.pipeline = context.pipelines().specialised(kernel, constants);
    shared::CornerPatchParameters& parameters = dispatch.parameters;
    parameters.unit_count = slice.group_count * slice.chunk_count;
    parameters.chunk_count = slice.chunk_count;
    parameters.first_group = slice.first_group;
    parameters.first_word = static_cast<std::uint32_t>(slice.words.first);
    parameters.first_weight = static_cast<std::uint32_t>(slice.weights.first);
    parameters.first_state = static_cast<std::uint32_t>(slice.points.first);
    parameters.first_vertex = static_cast<std::uint32_t>(slice.vertices.first);
    parameters.first_row = static_cast<std::uint32_t>(slice.rows.first);
    parameters.first_target =
        target.shift + static_cast<std::uint32_t>(layout.position_offset / sizeof(float));
    parameters.target_stride = layout.stride / sizeof(float);
    // May be negative: the kernel's sum wraps around.
    parameters.normal_offset =
        layout.normal_offset / sizeof(float) - layout.position_offset / sizeof(float);
    parameters.instance_points = static_cast<std::uint32_t>(instances.stride(point_count));
    parameters.instance_rows = static_cast<std::uint32_t>(instances.stride(vertex_count));
    parameters.instance_floats = static_cast<std::uint32_t>(layout.instance_stride / sizeof(float));
    parameters.segment =
        listed.first_segment + shared::kSegmentWords * std::uint32_t(dispatches_.size() - 1);
    parameters.job_count = listed.job_count;
    dispatch.groups = (parameters.unit_count + units_per_group - 1) / units_per_group;
    // Points behind the corners' have no links.
    const std::uint64_t link_bytes = sizeof(PatchRecords::Link);
    const auto link_count = static_cast<std::int64_t>(tables.links.size() / link_bytes);
    const std::int64_t first_link = std::min(slice.points.first, link_count - 1) / 64 * 64;
    const IndexWindow links{
        first_link, std::min(slice.points.first + slice.points.count, link_count) - first_link};
    bound.push_back(
        {kernel,
         {whole(tables.groups), window_range(tables.words, slice.words, sizeof(std::uint32_t)),
          window_range(tables.links, links, link_bytes),
          instances.widened(window_range(state, slice.points, kPointBytes), point_count),
          instances.widened(window_range(given, slice.vertices, kPointBytes), vertex_count),
          window_range(tables.weights, slice.weights, sizeof(PatchRecords::Weight)),
          target.range}});
    if (work_) bound.back().buffers.push_back(whole(*listed.work));
  }
  sets_ = DescriptorSets(context, bound);
}

// Windows of neighbouring dispatches may share their edge: a round each.
Wait GpuPatches::record_round(VkCommandBuffer commands, std::size_t round) const noexcept {
  if (round >= dispatches_.size()) return {};
  const Dispatch& dispatch = dispatches_[round];
  if (work_)
    record_dispatch_indirect(
        context_, commands, dispatch.pipeline, sets_[round], &dispatch.parameters,
        {work_, (dispatch.parameters.segment + shared::kSegmentArguments) * sizeof(std::uint32_t)});
  else
    record_dispatch(context_, commands, dispatch.pipeline, sets_[round], &dispatch.parameters,
                    dispatch.groups, instances_.count);
  return kKernelWait;
}

void GpuPatches::record(VkCommandBuffer commands) const noexcept {
  record_rounds(context_, commands, 1,
                [&](std::size_t, std::uint32_t round) { return record_round(commands, round); });
}

}  // namespace planish::vulkan
