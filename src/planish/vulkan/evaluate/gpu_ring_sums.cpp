// Based on: rings by sums, a derivation of our own; see patches/ring_sums.cpp, its twin.
#include "planish/vulkan/evaluate/gpu_ring_sums.h"

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/table_slices.h"

namespace planish::vulkan {

GpuRingSums::GpuRingSums(const Maker& on, const PatchTables& tables, const Buffer& given,
                         const Buffer& state, std::uint64_t vertex_count,
                         const Instances& instances, const InstanceList& listed)
    : context_(on.context()),
      instances_(instances),
      pipeline_(context_.pipelines().specialised(Kernel::RingSums, {})),
      groups_(context_.groups_of(tables.ring_count, 1)) {
  constexpr std::int64_t kWindowStep = 64;
  const auto point_count = static_cast<std::uint64_t>(tables.point_count);
  const std::int64_t first = tables.first_sum / kWindowStep * kWindowStep;
  const IndexWindow target{first, tables.point_count - first};
  parameters_.count = tables.ring_count;
  parameters_.first_target = static_cast<std::uint32_t>(first);
  parameters_.instance_points = static_cast<std::uint32_t>(instances.stride(point_count));
  parameters_.instance_rows = static_cast<std::uint32_t>(instances.stride(vertex_count));
  parameters_.first_listed = listed.first;
  const auto window = [&](const Buffer& points, const IndexWindow& of, std::uint64_t count) {
    return instances.widened(window_range(points, of, kPointBytes), count);
  };
  const BoundKernel bound[] = {
      {Kernel::RingSums,
       {whole(tables.rings), window(state, {0, tables.first_sum}, point_count), whole(given),
        window(state, target, point_count), whole(listed.words ? *listed.words : tables.rings)}}};
  sets_ = DescriptorSets(on, bound);
}

Wait GpuRingSums::record(VkCommandBuffer commands) const noexcept {
  record_dispatch(context_, commands, pipeline_, sets_[0], &parameters_, groups_, instances_.count);
  return kKernelWait;
}

Wait GpuRingSums::record_listed(VkCommandBuffer commands,
                                const IndirectGroups& groups) const noexcept {
  record_dispatch_indirect(context_, commands, pipeline_, sets_[0], &parameters_, groups);
  return kKernelWait;
}

}  // namespace planish::vulkan
