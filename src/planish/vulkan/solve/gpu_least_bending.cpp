// Based on: Beck & Teboulle 2009, as fair/least_bending.cpp, whose functions are the kernels'
// twins.
#include "planish/vulkan/solve/gpu_least_bending.h"

#include <array>

#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

namespace {

constexpr std::array kKernels{Kernel::BendingDirections, Kernel::BendingRows, Kernel::BendingStep};
constexpr std::uint32_t kLanes = 64;

Buffer make_points(const Maker& on, std::uint64_t bytes) {
  return make_bindable(on, bytes, "planish bending work");
}

}  // namespace

GpuLeastBending::GpuLeastBending(const Maker& on, const BendingTables& tables, const Buffer& points,
                                 const Instances& instances)
    : context_(on.context()),
      instances_(instances),
      parameters_{tables.vertex_count,
                  static_cast<std::uint32_t>(instances.stride(tables.vertex_count)),
                  tables.unit,
                  tables.bound,
                  0,
                  0},
      groups_(context_.groups_of(tables.vertex_count)),
      momenta_(nesterov_momenta()) {
  for (std::size_t i = 0; i < kKernels.size(); ++i)
    pipelines_[i] = context_.pipelines().specialised(kKernels[i], {});
  const std::uint64_t bytes = instances.bytes(tables.vertex_count);
  for (Buffer* buffer : {&directions_, &base_, &rows_, &moves_, &ahead_})
    *buffer = make_points(on, bytes);
  const auto bind = [&](Kernel kernel, std::initializer_list<const Buffer*> buffers) {
    BoundKernel bound{kernel, {whole(tables.vertices), whole(tables.entries)}};
    for (const Buffer* buffer : buffers) bound.buffers.push_back(whole(*buffer));
    return bound;
  };
  sets_ = DescriptorSets(
      on, std::array{bind(kKernels[0], {&points, &directions_, &base_, &moves_, &ahead_}),
                     bind(kKernels[1], {&directions_, &base_, &ahead_, &rows_}),
                     bind(kKernels[2],
                          {&tables.theirs, &directions_, &rows_, &moves_, &ahead_, &points})});
}

Wait GpuLeastBending::record_round(VkCommandBuffer commands, std::uint32_t round) const noexcept {
  shared::BendingParameters parameters = parameters_;
  const std::size_t which = round == 0 ? 0 : 2 - round % 2;
  if (which == 2) {
    parameters.momentum = static_cast<float>(momenta_[round / 2 - 1]);
    parameters.is_last = round + 1 == kRoundCount;
  }
  record_dispatch(context_, commands, pipelines_[which], sets_[which], &parameters, groups_,
                  instances_.count);
  return kKernelWait;
}

}  // namespace planish::vulkan
