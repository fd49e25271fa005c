// Based on: Doo & Sabin 1978; "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces",
// equation (1), in differences between neighbours; its twin is patches/first_step.cpp.
#include "planish/vulkan/evaluate/gpu_first_step.h"

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/table_slices.h"

namespace planish::vulkan {

namespace {

constexpr std::uint32_t kStepLanes = 64;

}  // namespace

GpuFirstStep::GpuFirstStep(const Maker& on, const PatchTables& patches, const StepTables& tables,
                           const Buffer& given, const Buffer& displacement,
                           std::uint64_t vertex_count, const Instances& instances)
    : context_(on.context()),
      instances_(instances),
      own_state_(std::make_unique<Buffer>(
          make_bindable(on, instances.bytes(static_cast<std::uint64_t>(patches.point_count)),
                        "planish points of level 1"))),
      points_{&given, &displacement, vertex_count, own_state_.get()} {
  bind(on, patches, tables, {});
}

GpuFirstStep::GpuFirstStep(const Maker& on, const PatchTables& patches, const StepTables& tables,
                           const GpuFirstStep& all, const InstanceList& listed)
    : context_(on.context()), instances_(all.instances_), points_(all.points_) {
  bind(on, patches, tables, listed);
}

void GpuFirstStep::bind(const Maker& on, const PatchTables& patches, const StepTables& tables,
                        const InstanceList& listed) {
  const auto [given, displacement, vertex_count, state] = points_;
  const auto point_count = static_cast<std::uint64_t>(patches.point_count);
  std::vector<BoundKernel> bound;
  for (const StepPart& part : tables.parts) {
    const std::uint32_t constants[] = {part.kind};
    Dispatch& dispatch = dispatches_.emplace_back();
    dispatch.pipeline = context_.pipelines().specialised(Kernel::FirstStep, constants);
    shared::FirstStepParameters& parameters = dispatch.parameters;
    parameters.count = part.count;
    parameters.first_point = part.first_point;
    parameters.first_word = part.first_word;
    parameters.instance_points = static_cast<std::uint32_t>(instances_.stride(point_count));
    parameters.instance_rows = static_cast<std::uint32_t>(instances_.stride(vertex_count));
    parameters.own = static_cast<float>(tables.rule.own);
    parameters.beside = static_cast<float>(tables.rule.beside);
    parameters.mean = static_cast<float>(tables.rule.mean);
    parameters.turn = static_cast<float>(tables.rule.turn);
    parameters.first_listed = listed.first;
    dispatch.is_of_large = part.kind == shared::kStepLargeFaces;
    dispatch.groups = dispatch.is_of_large ? context_.groups_of(part.count, 1)
                                           : (part.count + kStepLanes - 1) / kStepLanes;
    bound.push_back({Kernel::FirstStep,
                     {whole(tables.words), whole(patches.links), whole(tables.vertices),
                      whole(*given), whole(*displacement), whole(*state),
                      whole(listed.words ? *listed.words : tables.words)}});
  }
  sets_ = DescriptorSets(on, bound);
}

// All parts write one binding: a round each.
Wait GpuFirstStep::record_round(VkCommandBuffer commands, std::size_t round) const noexcept {
  if (round >= dispatches_.size()) return {};
  const Dispatch& dispatch = dispatches_[round];
  record_dispatch(context_, commands, dispatch.pipeline, sets_[round], &dispatch.parameters,
                  dispatch.groups, instances_.count);
  return kKernelWait;
}

Wait GpuFirstStep::record_listed(VkCommandBuffer commands, std::size_t round,
                                 const IndirectGroups& groups) const noexcept {
  if (round >= dispatches_.size()) return {};
  record_dispatch_indirect(context_, commands, dispatches_[round].pipeline, sets_[round],
                           &dispatches_[round].parameters, groups);
  return kKernelWait;
}

void GpuFirstStep::record(VkCommandBuffer commands) const noexcept {
  record_rounds(context_, commands, 1,
                [&](std::size_t, std::uint32_t round) { return record_round(commands, round); });
}

void GpuFirstStep::record_large_faces(VkCommandBuffer commands) const noexcept {
  for (std::size_t round = 0; round < dispatches_.size(); ++round) {
    if (!dispatches_[round].is_of_large) continue;
    const Wait wait = record_round(commands, round);
    record_barrier(context_, commands, wait.from, wait.to);
  }
}

}  // namespace planish::vulkan
