// Based on: corner patches, a derivation of our own; see patches/patch_surface.cpp, its twin.
#include "planish/vulkan/evaluate/gpu_patches.h"

#include <algorithm>

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/stencil_pass.h"

namespace planish::vulkan {

namespace {

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
// and where in them the first row's position and normal are, in words.
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
  const ElementWindow normals = window(attributes, layout.normal_offset, layout.normal_format);
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
    const std::uint32_t constants[] = {slice.gather,
                                       slice.samples,
                                       static_cast<std::uint32_t>(layout.position_format),
                                       static_cast<std::uint32_t>(layout.normal_format),
                                       has_tangents(layout)
                                           ? static_cast<std::uint32_t>(layout.tangent_format)
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
