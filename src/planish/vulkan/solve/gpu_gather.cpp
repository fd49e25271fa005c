#include "planish/vulkan/solve/gpu_gather.h"

#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

GpuGather::GpuGather(const Maker& on, const Buffer& vertices,
                     std::span<const std::int32_t> row_vertices, std::span<const GivenPoints> given,
                     const Instances& instances)
    : context_(on.context()),
      instances_(instances),
      row_count_(row_vertices.size()),
      points_(make_bindable(on, instances.bytes(row_count_), "planish given points")) {
  if (row_count_ == 0) return;
  std::vector<BoundKernel> bound;
  for (const GivenPoints& slot : given) {
    sources_.push_back(source_of(row_vertices.back(), slot));
    bound.push_back(
        {Kernel::GatherPoints, {whole(vertices), sources_.back().range, whole(points_)}});
  }
  sets_ = DescriptorSets(on, bound);
}

GpuGather::Source GpuGather::source_of(std::int32_t last_vertex, const GivenPoints& given) const {
  const VkDeviceSize aligned = given.offset - given.offset % kBindingAlignment;
  const VkDeviceSize bytes = given.offset - aligned + VkDeviceSize(last_vertex) * given.stride +
                             3 * sizeof(float) + instances_.further() * given.instance_stride;
  require_binding(context_, bytes, "given points", "use a smaller stride or a smaller mesh");
  const auto floats = [](VkDeviceSize size) {
    return static_cast<std::uint32_t>(size / sizeof(float));
  };
  return {{given.buffer, aligned, bytes},
          floats(given.offset - aligned),
          floats(given.stride),
          floats(given.instance_stride)};
}

void GpuGather::record(VkCommandBuffer commands, std::uint32_t slot) const noexcept {
  if (row_count_ == 0) return;
  shared::VectorParameters parameters{};
  parameters.count = static_cast<std::uint32_t>(row_count_);
  parameters.source_shift = sources_[slot].shift;
  parameters.source_stride = sources_[slot].stride;
  parameters.instance_rows = static_cast<std::uint32_t>(instances_.stride(row_count_));
  parameters.instance_floats = sources_[slot].instance_floats;
  record_dispatch(context_, commands, Kernel::GatherPoints, sets_[slot], &parameters,
                  row_groups(row_count_), instances_.count);
}

}  // namespace planish::vulkan
