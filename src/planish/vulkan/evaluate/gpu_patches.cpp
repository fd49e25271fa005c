#include "planish/vulkan/evaluate/gpu_patches.h"

#include <algorithm>

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {
namespace {

// Based on: Doo & Sabin 1978; "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces",
// equation (1), in differences between neighbours; its twin is patches/doo_sabin_step.cpp.

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
                           const Points& points, const Instances& instances,
                           const InstanceList& listed)
    : context_(on.context()), instances_(instances), points_(points) {
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

// Based on: rings by sums, a derivation of our own; see patches/patch_mesh.cpp, its twin.

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

namespace {

// Based on: corner patches, a derivation of our own; see patches/patch_surface.cpp, its twin.

constexpr std::uint32_t kWordBytes = sizeof(std::uint32_t);

constexpr bool is_same(VertexFormat format, std::uint32_t of_kernels) {
  return static_cast<std::uint32_t>(format) == of_kernels;
}
static_assert(is_same(VertexFormat::Float3, shared::kFormatFloat3));
static_assert(is_same(VertexFormat::Half4, shared::kFormatHalf4));
static_assert(is_same(VertexFormat::Snorm16x4, shared::kFormatSnorm16x4));
static_assert(is_same(VertexFormat::Octahedral16, shared::kFormatOctahedral16));
static_assert(is_same(VertexFormat::Snorm10, shared::kFormatSnorm10));
static_assert(is_same(VertexFormat::Float4, shared::kFormatFloat4));

// What rows of a host's vertices are written through: a window of positions and one of attributes,
// that of positions again where there are none, and where in them the first row's position and
// normal are, in words.
struct Target {
  BufferRange positions, attributes;
  std::uint32_t position, normal;
};

// The smallest range that has both, of one buffer.
BufferRange joined(const BufferRange& a, const BufferRange& b) {
  const VkDeviceSize begin = std::min(a.offset, b.offset);
  return {a.buffer, begin, std::max(a.offset + a.size, b.offset + b.size) - begin};
}

Target target_of(const Context& context, const VertexLayout& layout, const IndexWindow& rows,
                 const Instances& instances, const PatchLists& lists, bool in_one) {
  const auto window = [&](const VertexStream& stream, std::uint32_t offset, VertexFormat format) {
    ElementWindow result = element_window(
        {stream.buffer, (stream.offset + offset) / kWordBytes, bytes_of(format) / kWordBytes,
         stream.stride / kWordBytes},
        static_cast<std::uint64_t>(rows.first), static_cast<std::uint64_t>(rows.count));
    result.range.size += instances.further() * stream.instance_stride;
    return result;
  };
  const VertexStream attributes = attributes_of(layout);
  const ElementWindow positions =
      window({layout.buffer, layout.offset, layout.stride, layout.instance_stride},
             layout.position_offset, layout.position_format);
  const ElementWindow normals = has_normals(layout)
                                    ? window(attributes, layout.normal_offset, layout.normal_format)
                                    : positions;
  Target target{positions.range, normals.range, 0, 0};
  if (has_tangents(layout))
    target.attributes = joined(
        normals.range, window(attributes, layout.tangent_offset, layout.tangent_format).range);
  if (in_one) target.positions = target.attributes = joined(target.positions, target.attributes);
  const auto word = [&](const ElementWindow& first, const BufferRange& range) {
    require_window(context, {range, 0}, lists.vertices, lists.remedy);
    return static_cast<std::uint32_t>((first.range.offset - range.offset) / kWordBytes) +
           first.shift;
  };
  target.position = word(positions, target.positions);
  target.normal = word(normals, target.attributes);
  return target;
}

}  // namespace

GpuPatches::GpuPatches(const Maker& on, const PatchTables& tables, const Buffer& given,
                       const Buffer& state, const VertexLayout& layout, std::uint64_t vertex_count,
                       const Instances& instances, const PatchLists& lists)
    : context_(on.context()),
      instances_(instances),
      work_(lists.work ? lists.work->handle() : VK_NULL_HANDLE) {
  const Context& context = context_;
  const Kernel kernel = work_ ? lists.kernel : Kernel::CornerPatches;
  const Instances& places = kernel == Kernel::InstancePatches ? lists.places : instances;
  const auto point_count = static_cast<std::uint64_t>(tables.point_count);
  const std::uint32_t units_per_group = context.variant().chunks_per_group;
  const VertexStream attributes = attributes_of(layout);
  // Kernels that write rows by way of their work group then write whole ones.
  const bool in_one = work_ || (context.variant().read_path == ReadPath::Storage &&
                                layout.attributes.buffer == VK_NULL_HANDLE);
  std::vector<BoundKernel> bound;
  for (const PatchSlice& slice : tables.slices) {
    const Target target = target_of(context, layout, slice.rows, places, lists, in_one);
    const std::uint32_t constants[] = {
        slice.gather,
        slice.samples,
        static_cast<std::uint32_t>(layout.position_format),
        has_normals(layout) ? static_cast<std::uint32_t>(layout.normal_format)
                            : shared::kFormatNone,
        has_tangents(layout) ? static_cast<std::uint32_t>(layout.tangent_format)
                             : shared::kFormatNone,
        in_one};
    Dispatch& dispatch = dispatches_.emplace_back();
    dispatch.pipeline = context.pipelines().specialised(kernel, constants);
    shared::CornerPatchParameters& parameters = dispatch.parameters;
    parameters.unit_count = slice.group_count * slice.chunk_count;
    parameters.chunk_count = slice.chunk_count;
    parameters.first_group = slice.first_group;
    parameters.first_word = static_cast<std::uint32_t>(slice.words.first);
    parameters.first_weight = static_cast<std::uint32_t>(slice.weights.first);
    parameters.first_row = static_cast<std::uint32_t>(slice.rows.first);
    parameters.first_position = target.position;
    parameters.position_stride = layout.stride / kWordBytes;
    parameters.position_instance = static_cast<std::uint32_t>(layout.instance_stride / kWordBytes);
    parameters.first_normal = target.normal;
    parameters.normal_stride = attributes.stride / kWordBytes;
    parameters.normal_instance =
        static_cast<std::uint32_t>(attributes.instance_stride / kWordBytes);
    parameters.tangent_shift = (layout.tangent_offset - layout.normal_offset) / kWordBytes;
    parameters.center_x = layout.box_center[0];
    parameters.center_y = layout.box_center[1];
    parameters.center_z = layout.box_center[2];
    parameters.scale_x = 1 / layout.box_half[0];
    parameters.scale_y = 1 / layout.box_half[1];
    parameters.scale_z = 1 / layout.box_half[2];
    parameters.instance_points = static_cast<std::uint32_t>(instances.stride(point_count));
    parameters.instance_rows = static_cast<std::uint32_t>(instances.stride(vertex_count));
    const auto number = static_cast<std::uint32_t>(dispatches_.size() - 1);
    parameters.segment = lists.first_list + lists.list_step * number;
    parameters.job_count = lists.job_count;
    dispatch.arguments =
        (lists.first_arguments + lists.arguments_step * number) * sizeof(std::uint32_t);
    dispatch.groups = (parameters.unit_count + units_per_group - 1) / units_per_group;
    bound.push_back(
        {kernel,
         {whole(tables.groups), window_range(tables.words, slice.words, sizeof(std::uint32_t)),
          whole(lists.links ? *lists.links : tables.links), whole(state), whole(given),
          window_range(tables.weights, slice.weights, sizeof(PatchRecords::Weight)),
          target.positions, work_ ? whole(*lists.work) : target.attributes}});
  }
  sets_ = DescriptorSets(on, bound);
}

// Windows of neighbouring dispatches may share their edge: a round each.
Wait GpuPatches::record_round(VkCommandBuffer commands, std::size_t round) const noexcept {
  if (round >= dispatches_.size()) return {};
  const Dispatch& dispatch = dispatches_[round];
  if (work_)
    record_dispatch_indirect(context_, commands, dispatch.pipeline, sets_[round],
                             &dispatch.parameters, {work_, dispatch.arguments});
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
