// Based on: the paper, section 3.2: the iteration is local. A step of Golub & Varga's
// semi-iteration reaches the vertices of a vertex's faces, so that its steps from a residual that
// is local are those of the whole mesh, on a set that grows by a ring a step.
#include "planish/vulkan/edit/gpu_edit.h"

#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/table_slices.h"

namespace planish::vulkan {

namespace {

static_assert(offsetof(EditReach, points) == 4 * shared::kEditRows);
static_assert(offsetof(EditReach, patches) == 4 * shared::kEditPatches);
static_assert(offsetof(EditReach, listed) == 4 * shared::kEditMoves);

constexpr std::uint64_t kEditWordBytes = sizeof(std::uint32_t);

// Words of the kernels' arguments that are not work groups in x.
void set_arguments(std::vector<std::uint32_t>& words, std::size_t at) {
  words[at] = 0;
  words[at + 1] = words[at + 2] = 1;
}

}  // namespace

GpuEdit::GpuEdit(Context& context, const EditedParts& parts, const MovedPoints& moved,
                 std::int32_t given_count, const VertexLayout& layout)
    : context_(context), parts_(parts), instances_(parts.solve.instances()) {
  const auto points = static_cast<std::uint64_t>(parts.patches.point_count);
  require_one_binding(context, instances_.bytes(points), kPointBytes, "points of level 1");
  require_one_binding(context, parts.patches.links.size(), 2 * kEditWordBytes, "corners");
  if (parts.masks.slices().size() != 1)
    throw Error(ErrorCode::OutOfMemory,
                context.capabilities().name + ": the limit masks are in " +
                    std::to_string(parts.masks.slices().size()) +
                    " slices, edits take one; use a smaller mesh, or solve all of it");
  if (parts.given.gather().gathers(0).size() != 1)
    throw Error(ErrorCode::OutOfMemory,
                context.capabilities().name +
                    ": given points are in several bindings, edits take one; use a smaller mesh");
  fill_parameters(given_count);
  make_work();
  bind(moved);
  if (layout.buffer)
    evaluation_.emplace(context, parts.patches, parts.given.given(), parts.step.state(), layout,
                        parameters_.row_count, instances_,
                        ListedPatches{&work_, shared::kEditHeadWords, parameters_.job_count});
}

void GpuEdit::fill_parameters(std::int32_t given_count) {
  const GpuGather::Gather& gather = parts_.given.gather().gathers(0)[0];
  const auto rows = static_cast<std::uint64_t>(parts_.masks.row_count());
  parameters_.row_count = static_cast<std::uint32_t>(rows);
  parameters_.row_stride = static_cast<std::uint32_t>(instances_.stride(rows));
  parameters_.instances = instances_.count;
  parameters_.max_groups = context_.max_group_count();
  parameters_.given_count = static_cast<std::uint32_t>(given_count);
  parameters_.first_vertex = gather.first_vertex;
  parameters_.source_shift = gather.shift;
  parameters_.source_stride = gather.source_stride;
  parameters_.instance_floats = gather.instance_floats;
  parameters_.first_source = static_cast<std::uint32_t>(parts_.masks.slices()[0].rows.first_source);
  parameters_.first_sharp =
      static_cast<std::uint32_t>(parts_.patches.links.size() / (2 * kEditWordBytes));
  for (const StepSlice& slice : parts_.steps.slices)
    if (slice.kind == shared::kStepSharp) parameters_.first_word = slice.first_word;
  parameters_.point_stride = static_cast<std::uint32_t>(
      instances_.stride(static_cast<std::uint64_t>(parts_.patches.point_count)));
  parameters_.job_count = static_cast<std::uint32_t>(parts_.edits.job_count);
}

void GpuEdit::make_work() {
  const std::vector<PatchSlice>& slices = parts_.patches.slices;
  std::vector<std::uint32_t> words(shared::kEditHeadWords + shared::kSegmentWords * slices.size());
  for (const std::uint32_t at : {shared::kEditForRows, shared::kEditForHeld, shared::kEditForMoves})
    set_arguments(words, at);
  const std::uint64_t rows = std::uint64_t(instances_.count) * parameters_.row_count;
  std::uint64_t next = words.size() + rows;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const std::size_t at = shared::kEditHeadWords + shared::kSegmentWords * i;
    set_arguments(words, at + shared::kSegmentArguments);
    words[at + shared::kSegmentList] = static_cast<std::uint32_t>(next);
    words[at + shared::kSegmentEnd] =
        (slices[i].first_group + slices[i].group_count) * shared::kPatchLanes;
    words[at + shared::kSegmentChunks] = slices[i].chunk_count;
    next += std::uint64_t(instances_.count) * slices[i].group_count * shared::kPatchLanes;
  }
  parameters_.first_listed = static_cast<std::uint32_t>(words.size());
  require_one_binding(context_, next * kEditWordBytes, 0, "lists of rows and patches");
  template_ =
      Buffer(context_, words.size() * kEditWordBytes, MemoryUse::Upload, "planish empty lists");
  std::memcpy(template_.mapped().data(), words.data(), words.size() * kEditWordBytes);
  template_.flush();
  work_ = Buffer(context_, next * kEditWordBytes, MemoryUse::Device, "planish lists");
  const std::uint64_t row_words = std::uint64_t(instances_.count) * parameters_.row_stride;
  flags_ = Buffer(context_, row_words * kEditWordBytes, MemoryUse::Device, "planish listed rows");
  velocity_ = Buffer(context_, row_words * kPointBytes, MemoryUse::Device, "planish steps of rows");
}

BufferRange GpuEdit::moves_range(const MovedPoints& moved) {
  const VkDeviceSize aligned = moved.offset - moved.offset % kBindingAlignment;
  parameters_.moves_shift = static_cast<std::uint32_t>((moved.offset - aligned) / kEditWordBytes);
  parameters_.most_moves = moved.max_count;
  const BufferRange range{
      moved.buffer, aligned,
      (parameters_.moves_shift + 1 + std::uint64_t(moved.max_count)) * kEditWordBytes};
  require_one_binding(context_, range.size, 0, "lists of moved points");
  return range;
}

void GpuEdit::bind(const MovedPoints& moved) {
  const DeviceTable::Slice& slice = parts_.masks.slices()[0];
  const BufferRange moves = moves_range(moved);
  const GpuSolve& solve = parts_.solve;
  const auto given = whole(parts_.given.given()), displacement = whole(parts_.given.displacement());
  const auto work = whole(work_), flags = whole(flags_), velocity = whole(velocity_);
  const auto links = whole(parts_.patches.links), corners = whole(parts_.steps.vertices);
  const auto places = whole(parts_.edits.places);
  const BoundKernel bound[kStages] = {
      {Kernel::EditBegin, {moves, work}},
      {Kernel::EditTake,
       {moves, whole(parts_.vertices), parts_.given.gather().gathers(0)[0].source, given, velocity,
        flags, work}},
      {Kernel::EditResidual,
       {whole(slice.entries), whole(slice.chunks), whole(parts_.edits.slots), given, displacement,
        velocity, whole(solve.steps()), work}},
      {Kernel::EditAdvance,
       {places, links, corners, displacement, velocity, whole(solve.steps()), flags, work}},
      {Kernel::EditCommit,
       {whole(solve.side(0)), whole(solve.side(1)), whole(solve.side(2)), whole(solve.status()),
        given, displacement, whole(parts_.given.control_points()), work}},
      {Kernel::EditJobs, {whole(parts_.edits.jobs), flags, work}},
      {Kernel::EditPoints,
       {places, whole(parts_.steps.words), links, corners, given, displacement,
        whole(parts_.step.state()), work}}};
  sets_ = DescriptorSets(context_, bound);
  for (std::size_t i = 0; i < kStages; ++i)
    pipelines_[i] = context_.pipelines().specialised(bound[i].kernel, {});
}

void GpuEdit::record_clear(VkCommandBuffer commands) const noexcept {
  context_.vk().vkCmdFillBuffer(commands, flags_.handle(), 0, VK_WHOLE_SIZE, 0);
}

void GpuEdit::wait(VkCommandBuffer commands) const noexcept {
  record_barrier(context_, commands, kIndirectScope, kIndirectScope);
}

void GpuEdit::record(VkCommandBuffer commands, std::uint32_t step_count,
                     float stop_square) const noexcept {
  const VkBufferCopy heads{0, 0, template_.size()};
  context_.vk().vkCmdCopyBuffer(commands, template_.handle(), work_.handle(), 1, &heads);
  parts_.solve.record_plan(commands, step_count);
  record_barrier(context_, commands, kEntryScope, kEntryScope);
  record_dispatch(context_, commands, pipelines_[Begin], sets_[Begin], &parameters_, 1);
  wait(commands);
  shared::EditParameters parameters = parameters_;
  parameters.stop_square = stop_square;
  const auto run = [&](Stage stage, std::uint32_t arguments) {
    record_dispatch_indirect(context_, commands, pipelines_[stage], sets_[stage], &parameters,
                             {work_.handle(), arguments * kEditWordBytes});
  };
  const auto walk = [&](Stage stage, std::uint32_t arguments) {
    run(stage, arguments);
    wait(commands);
  };
  walk(Take, shared::kEditForMoves);
  // The rows that name a moved point, before any step.
  parameters.step = shared::kNone;
  walk(Advance, shared::kEditForHeld);
  for (parameters.step = 0; parameters.step < step_count; ++parameters.step) {
    walk(Residual, shared::kEditForRows);
    walk(Advance, shared::kEditForHeld);
  }
  walk(Residual, shared::kEditForRows);
  // What stands between two waits writes buffers of its own.
  run(Commit, shared::kEditForRows);
  run(Points, shared::kEditForRows);
  wait(commands);
  run(Jobs, shared::kEditForRows);
  parts_.solve.record_status_of(commands, step_count, stop_square);
  parts_.step.record_large_faces(commands);
  wait(commands);
  if (parts_.sums) {
    (void)parts_.sums->record(commands);
    wait(commands);
  }
  if (evaluation_) evaluation_->record(commands);
  record_barrier(context_, commands, kExitScope, kExitScope);
}

}  // namespace planish::vulkan
