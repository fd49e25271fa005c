#include "planish/vulkan/edit/gpu_edit.h"

#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/group_by.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {
namespace {

// Lists of `vertex_count` vertices: item i is in that of owners[i], where that is not negative.
std::vector<std::uint32_t> lists_of(std::int32_t vertex_count,
                                    const std::vector<std::int32_t>& owners) {
  const Groups<std::uint32_t> lists =
      group_by<std::uint32_t>(static_cast<std::size_t>(vertex_count), [&](const auto& take) {
        for (std::size_t i = 0; i < owners.size(); ++i)
          if (owners[i] >= 0)
            take(static_cast<std::size_t>(owners[i]), static_cast<std::uint32_t>(i));
      });
  std::vector<std::uint32_t> words;
  words.reserve(lists.offsets.size() + lists.values.size());
  for (const std::int32_t offset : lists.offsets)
    words.push_back(static_cast<std::uint32_t>(lists.offsets.size()) +
                    static_cast<std::uint32_t>(offset));
  words.insert(words.end(), lists.values.begin(), lists.values.end());
  return words;
}

}  // namespace

EditRecords edit_records(const PatchMesh& mesh, const PatchRecords& patches,
                         std::vector<std::uint32_t> slots) {
  const std::int32_t vertex_count = mesh.topology().vertex_count();
  if (patches.owners.size() > std::numeric_limits<std::int32_t>::max())
    throw Error(
        ErrorCode::OutOfMemory,
        formatted(
            "edits count {} patches in numbers of 31 bits; use a lower level or a smaller mesh",
            patches.owners.size()));
  EditRecords records;
  records.slots = std::move(slots);
  records.job_count = patches.owners.size();
  records.jobs = lists_of(vertex_count, patches.owners);
  // Sums of large rings are made as a whole.
  std::vector<std::int32_t> owners = state_owners(mesh);
  owners.resize(static_cast<std::size_t>(mesh.state_size()));
  records.places = lists_of(vertex_count, owners);
  return records;
}

namespace {

Buffer make_words(const Maker& on, const std::vector<std::uint32_t>& words, const char* name) {
  const std::uint64_t bytes = words.size() * sizeof(std::uint32_t);
  return make_bindable(on, bytes, name);
}

}  // namespace

EditTables::EditTables(const Maker& on, const EditRecords& records)
    : job_count(records.job_count),
      slots(make_words(on, records.slots, "planish slots")),
      places(make_words(on, records.places, "planish places of vertices")),
      jobs(make_words(on, records.jobs, "planish patches of vertices")) {}

namespace {

// Based on: the paper, section 3.2: the iteration is local. A step of Golub & Varga's
// semi-iteration reaches the vertices of a vertex's faces, so that its steps from a residual that
// is local are those of the whole mesh, on a set that grows by a ring a step.

static_assert(offsetof(EditReach, points) == 4 * shared::kEditRows);
static_assert(offsetof(EditReach, patches) == 4 * shared::kEditPatches);
static_assert(offsetof(EditReach, listed) == 4 * shared::kEditMoves);

constexpr std::uint64_t kEditWordBytes = sizeof(std::uint32_t);

// Words of the kernels' arguments that are not work groups in x.
void set_arguments(std::vector<std::uint32_t>& words, std::size_t at) {
  words[at] = 0;
  words[at + 1] = words[at + 2] = 1;
}

PatchLists patch_lists_of(const Buffer& work, std::uint32_t job_count) {
  PatchLists lists;
  lists.work = &work;
  lists.first_list = shared::kEditHeadWords;
  lists.first_arguments = lists.first_list + shared::kSegmentArguments;
  lists.list_step = lists.arguments_step = shared::kSegmentWords;
  lists.job_count = job_count;
  return lists;
}

}  // namespace

GpuEdit::GpuEdit(const Maker& on, const EditedParts& parts, std::int32_t given_count,
                 std::span<const FrameSlot> slots)
    : context_(on.context()), parts_(parts), instances_(parts.solve.instances()) {
  if (parts.masks.slices().size() != 1)
    throw Error(ErrorCode::OutOfMemory,
                formatted("{}: the limit masks are in {} slices, edits take one; use a smaller "
                          "mesh, or solve all of it",
                          context_.capabilities().name, parts.masks.slices().size()));
  shared::EditParameters parameters = common_parameters(given_count);
  parameters.slot_count = static_cast<std::uint32_t>(slots.size());
  make_work(on, parameters);
  for (const FrameSlot& slot : slots)
    make_slot(on, slot, static_cast<std::uint32_t>(slots_.size()), parameters);
  bind(on);
}

shared::EditParameters GpuEdit::common_parameters(std::int32_t given_count) const {
  shared::EditParameters result{};
  const auto rows = static_cast<std::uint64_t>(parts_.masks.row_count());
  result.row_count = static_cast<std::uint32_t>(rows);
  result.row_stride = static_cast<std::uint32_t>(instances_.stride(rows));
  result.instances = instances_.count;
  result.max_groups = context_.max_group_count();
  result.given_count = static_cast<std::uint32_t>(given_count);
  result.first_source = static_cast<std::uint32_t>(parts_.masks.slices()[0].rows.first_source);
  result.first_sharp =
      static_cast<std::uint32_t>(parts_.patches.links.size() / (2 * kEditWordBytes));
  for (const StepPart& part : parts_.steps.parts)
    if (part.kind == shared::kStepSharp) result.first_word = part.first_word;
  result.point_stride = static_cast<std::uint32_t>(
      instances_.stride(static_cast<std::uint64_t>(parts_.patches.point_count)));
  result.job_count = static_cast<std::uint32_t>(parts_.edits.job_count);
  return result;
}

void GpuEdit::make_slot(const Maker& on, const FrameSlot& slot, std::uint32_t number,
                        const shared::EditParameters& common) {
  Slot& made = slots_.emplace_back(Slot{slot.moved.buffer != VK_NULL_HANDLE, common, {}, {}});
  made.parameters.slot = number;
  if (!made.has_list) return;
  const GpuGather::Source& source = parts_.given.gather().source(number);
  made.parameters.source_shift = source.shift;
  made.parameters.source_stride = source.stride;
  made.parameters.instance_floats = source.instance_floats;
  const VkDeviceSize aligned = slot.moved.offset - slot.moved.offset % kBindingAlignment;
  made.parameters.moves_shift =
      static_cast<std::uint32_t>((slot.moved.offset - aligned) / kEditWordBytes);
  made.parameters.most_moves = slot.moved.max_count;
  made.moves = {
      slot.moved.buffer, aligned,
      (made.parameters.moves_shift + 1 + std::uint64_t(slot.moved.max_count)) * kEditWordBytes};
  require_binding(context_, made.moves.size, "lists of moved points", kFewerInstances);
  if (slot.vertices.buffer)
    made.evaluation.emplace(on, parts_.patches, parts_.given.given(), parts_.step.state(),
                            slot.vertices, common.row_count, instances_,
                            patch_lists_of(work_, common.job_count));
}

void GpuEdit::make_work(const Maker& on, shared::EditParameters& parameters) {
  const std::vector<PatchSlice>& slices = parts_.patches.slices;
  std::vector<std::uint32_t> words(shared::kEditHeadWords + shared::kSegmentWords * slices.size());
  for (const std::uint32_t at : {shared::kEditForRows, shared::kEditForHeld, shared::kEditForMoves})
    set_arguments(words, at);
  const std::uint64_t rows = std::uint64_t(instances_.count) * parameters.row_count;
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
  parameters.first_listed = static_cast<std::uint32_t>(words.size());
  require_binding(context_, next * kEditWordBytes, "lists of rows and patches", kFewerInstances);
  head_bytes_ = words.size() * kEditWordBytes;
  // The heads of stale lists, and the lists where other slots have edits.
  for (std::uint32_t i = 0; i < parameters.slot_count; ++i) {
    words.resize(words.size() + shared::kStaleWords);
    set_arguments(words, words.size() - shared::kStaleWords + shared::kStaleArguments);
  }
  parameters.most_stale = parameters.slot_count > 1 ? static_cast<std::uint32_t>(rows) : 0;
  const std::uint64_t stale_words =
      parameters.slot_count * (shared::kStaleWords + std::uint64_t(parameters.most_stale));
  require_binding(context_, stale_words * kEditWordBytes, "lists of rows of all slots",
                  kFewerInstances);
  stale_ = Buffer(on, stale_words * kEditWordBytes, MemoryUse::Device, "planish stale rows");
  template_ = Buffer(on, words.size() * kEditWordBytes, MemoryUse::Upload, "planish empty lists");
  template_.write(std::as_bytes(std::span(words)));
  work_ = Buffer(on, next * kEditWordBytes, MemoryUse::Device, "planish lists");
  const std::uint64_t row_words = std::uint64_t(instances_.count) * parameters.row_stride;
  flags_ = Buffer(on, row_words * kEditWordBytes, MemoryUse::Device, "planish listed rows");
  velocity_ = Buffer(on, row_words * kPointBytes, MemoryUse::Device, "planish steps of rows");
}

void GpuEdit::bind(const Maker& on) {
  const DeviceTable::Slice& slice = parts_.masks.slices()[0];
  const GpuSolve& solve = parts_.solve;
  const auto given = whole(parts_.given.given()), displacement = whole(parts_.given.displacement());
  const auto work = whole(work_), flags = whole(flags_), velocity = whole(velocity_);
  const auto links = whole(parts_.patches.links), corners = whole(parts_.steps.vertices);
  const auto places = whole(parts_.edits.places);
  const auto stale = whole(stale_);
  std::vector<BoundKernel> bound = {
      {Kernel::EditResidual,
       {whole(slice.entries), whole(slice.chunks), whole(parts_.edits.slots), given, displacement,
        velocity, whole(solve.steps()), work}},
      {Kernel::EditAdvance,
       {places, links, corners, displacement, velocity, whole(solve.steps()), flags, work}},
      {Kernel::EditCommit,
       {whole(solve.side(0)), whole(solve.side(1)), whole(solve.side(2)), whole(solve.status()),
        given, displacement, whole(parts_.given.control_points()), work}},
      {Kernel::EditPoints,
       {places, whole(parts_.steps.words), links, corners, given, displacement,
        whole(parts_.step.state()), work}},
      {Kernel::EditStale, {flags, work, stale}},
      {Kernel::EditJobs, {whole(parts_.edits.jobs), flags, work, stale}}};
  for (std::uint32_t i = 0; i < slots_.size(); ++i) {
    // What has no list is never run, but has its place.
    const BufferRange moves = slots_[i].has_list ? slots_[i].moves : work;
    bound.push_back({Kernel::EditBegin, {moves, work}});
    bound.push_back({Kernel::EditTake,
                     {moves, whole(parts_.vertices), parts_.given.gather().source(i).range, given,
                      velocity, flags, work}});
  }
  sets_ = DescriptorSets(on, bound);
  for (std::size_t i = 0; i < kStages; ++i)
    pipelines_[i] = context_.pipelines().specialised(bound[i].kernel, {});
}

void GpuEdit::record_clear(VkCommandBuffer commands) const noexcept {
  context_.vk().vkCmdFillBuffer(commands, flags_.handle(), 0, VK_WHOLE_SIZE, 0);
  const VkBufferCopy heads{head_bytes_, 0, template_.size() - head_bytes_};
  context_.vk().vkCmdCopyBuffer(commands, template_.handle(), stale_.handle(), 1, &heads);
}

void GpuEdit::wait(VkCommandBuffer commands) const noexcept {
  record_barrier(context_, commands, kIndirectScope, kIndirectScope);
}

void GpuEdit::record(VkCommandBuffer commands, std::uint32_t slot, std::uint32_t step_count,
                     float stop_square) const noexcept {
  const VkBufferCopy heads{0, 0, head_bytes_};
  context_.vk().vkCmdCopyBuffer(commands, template_.handle(), work_.handle(), 1, &heads);
  parts_.solve.record_plan(commands, step_count);
  record_barrier(context_, commands, kEntryScope, kEntryScope);
  shared::EditParameters parameters = slots_[slot].parameters;
  record_dispatch(context_, commands, pipelines_[Begin], set_of(Begin, slot), &parameters, 1);
  wait(commands);
  parameters.stop_square = stop_square;
  const auto run_by = [&](Stage stage, const Buffer& words, std::uint32_t arguments) {
    record_dispatch_indirect(context_, commands, pipelines_[stage], set_of(stage, slot),
                             &parameters, {words.handle(), arguments * kEditWordBytes});
  };
  const auto run = [&](Stage stage, std::uint32_t arguments) { run_by(stage, work_, arguments); };
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
  if (slots_.size() > 1) {
    run_by(Stale, stale_, slot * shared::kStaleWords + shared::kStaleArguments);
    wait(commands);
  }
  run(Jobs, shared::kEditForRows);
  parts_.solve.record_status_of(commands, step_count, stop_square);
  parts_.step.record_large_faces(commands);
  wait(commands);
  if (parts_.sums) {
    (void)parts_.sums->record(commands);
    wait(commands);
  }
  if (slots_[slot].evaluation) slots_[slot].evaluation->record(commands);
  record_barrier(context_, commands, kExitScope, kExitScope);
}

}  // namespace planish::vulkan
