#include "planish/vulkan/solve/gpu_given.h"

#include <array>
#include <bit>

#include "planish/core/parallel.h"
#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

BendingRecords bending_records(const BendingTable& table, double unit, double bound) {
  BendingRecords records;
  records.unit = unit;
  records.bound = bound;
  records.vertices.resize(static_cast<std::size_t>(table.vertex_count()));
  parallel_each(records.vertices.size(), [&](std::int32_t v) {
    const auto count = static_cast<std::uint32_t>(table.row(v).size());
    records.vertices[v] = {static_cast<std::uint32_t>(table.offsets[v]),
                           table.kinds[v] | (table.is_closed[v] != 0 ? shared::kBendingClosed : 0) |
                               count << shared::kBendingCountShift,
                           table.inverse_areas[v], table.steps[v]};
  });
  records.entries.resize(table.entries.size());
  records.theirs.resize(table.entries.size());
  parallel_each(records.entries.size(), [&](std::size_t i) {
    const BendingTable::Entry& entry = table.entries[i];
    records.entries[i] = {static_cast<std::uint32_t>(entry.vertex),
                          std::bit_cast<std::uint32_t>(entry.own)};
    records.theirs[i] = entry.theirs;
  });
  return records;
}

BendingTables::BendingTables(const Maker& on, const BendingRecords& records)
    : vertex_count(static_cast<std::uint32_t>(records.vertices.size())),
      unit(static_cast<float>(records.unit)),
      bound(static_cast<float>(records.bound)),
      vertices(make_bindable(on, std::as_bytes(std::span(records.vertices)).size(),
                             "planish bending vertices")),
      entries(make_bindable(on, std::as_bytes(std::span(records.entries)).size(),
                            "planish bending entries")),
      theirs(make_bindable(on, std::as_bytes(std::span(records.theirs)).size(),
                           "planish bending weights")) {}

namespace {

// Based on: Beck & Teboulle 2009, as fair/least_bending.cpp, whose functions are the kernels'
// twins.

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

namespace {

// Based on: the paper, section 3.2: the iteration starts from the given points, so that its first
// residual is D^0 = V0 - B V0; in terms of the displacement, from zero or from the last frame's.

enum : std::size_t { kTakeUp, kControlPoints, kMasks };  // sets; of each slice of the masks

}  // namespace

GpuGiven::GpuGiven(const Maker& on, const DeviceTable& masks, const GpuSolve& solve,
                   const Buffer& vertices, std::span<const std::int32_t> row_vertices,
                   std::span<const GivenPoints> given)
    : context_(on.context()),
      masks_(masks),
      instances_(solve.instances()),
      row_count_(static_cast<std::uint64_t>(masks.row_count())),
      gather_(on, vertices, row_vertices, given, instances_),
      control_(make_bindable(on, instances_.bytes(row_count_), "planish control points")),
      moved_(make_bindable(on, instances_.bytes(row_count_), "planish last displacement")) {
  bind(on, solve);
}

void GpuGiven::bind(const Maker& on, const GpuSolve& solve) {
  std::vector<BoundKernel> bound;
  const auto range = [&](const Buffer& points, std::int32_t first, std::int32_t count) {
    return instances_.widened(point_range(points, first, count), row_count_);
  };
  const auto status = whole(solve.status());
  const auto side = [&](std::uint32_t i) { return whole(solve.side(i)); };
  bound.push_back({Kernel::TakeUp, {side(0), side(1), side(2), status}});
  bound.push_back({Kernel::ControlPoints,
                   {side(0), side(1), side(2), status, whole(gather_.points()), whole(control_),
                    whole(moved_)}});
  for (const DeviceTable::Slice& slice : masks_.slices())
    bound.push_back({Kernel::InitialResidual,
                     {whole(slice.entries), whole(slice.chunks),
                      range(gather_.points(), slice.rows.first_source, slice.rows.source_count),
                      range(solve.initial(), slice.rows.first_row, slice.rows.row_count)}});
  sets_ = DescriptorSets(on, bound);
}

void GpuGiven::record_rows(VkCommandBuffer commands, Kernel kernel, std::size_t set,
                           bool warm_start) const noexcept {
  shared::VectorParameters parameters{};
  parameters.count = static_cast<std::uint32_t>(row_count_);
  parameters.warm = warm_start ? 1 : 0;
  parameters.instance_rows = static_cast<std::uint32_t>(instances_.stride(row_count_));
  record_dispatch(context_, commands, kernel, sets_[set], &parameters, row_groups(row_count_),
                  instances_.count);
}

Wait GpuGiven::record_points(VkCommandBuffer commands, bool warm_start,
                             std::uint32_t slot) const noexcept {
  gather_.record(commands, slot);
  record_rows(commands, Kernel::TakeUp, kTakeUp, warm_start);
  return kKernelWait;
}

Wait GpuGiven::record_residual(VkCommandBuffer commands) const noexcept {
  for (std::size_t i = 0; i < masks_.slices().size(); ++i) {
    // Windows of several instances overlap.
    if (i > 0 && instances_.count > 1)
      record_barrier(context_, commands, kKernelScope, kKernelScope);
    shared::TableParameters parameters = masks_.parameters(i);
    parameters.instance_rows = static_cast<std::uint32_t>(instances_.stride(row_count_));
    masks_.record_dispatch(commands, Kernel::InitialResidual, sets_[kMasks + i], i, parameters,
                           instances_.count);
  }
  return kKernelWait;
}

void GpuGiven::record_control_points(VkCommandBuffer commands) const noexcept {
  record_rows(commands, Kernel::ControlPoints, kControlPoints, false);
}

}  // namespace planish::vulkan
