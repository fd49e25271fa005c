#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/fair/fair_net.h"
#include "planish/solve/iteration.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/edit/gpu_edit.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/gpu_patches.h"
#include "planish/vulkan/evaluate/gpu_places.h"
#include "planish/vulkan/fair/gpu_fair.h"
#include "planish/vulkan/host/frame_parts.h"
#include "planish/vulkan/solve/gpu_given.h"
#include "planish/vulkan/solve/gpu_solve.h"

namespace planish::vulkan {
namespace {

// The first of a call's two timestamps; nothing where the host wants none. At the compute stage,
// where the kernels wait, too: nothing holds back a timestamp at the top of the pipe, which would
// count the end of the work before.
void write_first(const Context& context, VkCommandBuffer commands,
                 const Timestamps& timestamps) noexcept {
  if (timestamps.pool)
    context.vk().vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                     timestamps.pool, timestamps.first);
}

// The second one, after all that the call recorded.
void write_second(const Context& context, VkCommandBuffer commands,
                  const Timestamps& timestamps) noexcept {
  if (timestamps.pool)
    context.vk().vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT,
                                     timestamps.pool, timestamps.first + 1);
}

// Based on: the paper, section 3.2, with Golub & Varga's semi-iteration for its steps: everything
// between a host's points and the vertices that it draws, in the host's command buffer.

GpuSolveOptions solve_options(const Context& context, const SolveOptions& options) {
  const std::uint64_t most = context.max_storage_range() / sizeof(shared::StepRecord) - 1;
  require_option(options.max_iterations >= 1 && options.max_iterations <= most,
                 "max_iterations {} is outside 1 to {}", options.max_iterations, most);
  GpuSolveOptions result;
  result.max_steps = options.max_iterations + 1;  // one more only measures
  result.sums_squares = false;
  result.instances = {options.instances};
  return result;
}

GpuFairOptions fair_options(const SolveOptions& options) {
  require_option(options.polish_steps <= kMostPolishSteps, "polish_steps {} are outside 0 to {}",
                 options.polish_steps, kMostPolishSteps);
  GpuFairOptions result;
  result.polish_steps = options.polish_steps;
  return result;
}

// Calls in lock-step, with their timestamps around all of it. `timestamps_of(i)` and
// `record_round(i, round)` are those of call `i`.
template <class TimestampsOf, class RecordRound>
void record_calls(const Context& context, VkCommandBuffer commands, std::size_t count,
                  const TimestampsOf& timestamps_of, const RecordRound& record_round) noexcept {
  record_barrier(context, commands, kExitScope, kEntryScope);
  for (std::size_t i = 0; i < count; ++i) write_first(context, commands, timestamps_of(i));
  record_rounds(context, commands, count, record_round);
  for (std::size_t i = 0; i < count; ++i) write_second(context, commands, timestamps_of(i));
}

}  // namespace

struct Solve::Parts {
  /// The iteration of the paper.
  struct Progressive {
    Progressive(Arena& arena, const DeviceSystem::Parts& system, const SolveOptions& options,
                std::span<const GivenPoints> points);
    GpuSolve solve;
    GpuGiven given;
  };
  /// Or the fair construction.
  struct Fair {
    Fair(Arena& arena, const DeviceSystem::Parts& system, const GpuFairOptions& options,
         std::span<const GivenPoints> points)
        : gather(arena, system.vertices, system.used_vertices, points),
          fair(arena, *system.fair, gather.points(), with_sums(system, options)) {}
    static GpuFairOptions with_sums(const DeviceSystem::Parts& system, GpuFairOptions options) {
      const PatchTables& patches = *system.patches;
      if (patches.ring_count > 0)
        options.sum_count = static_cast<std::uint64_t>(patches.point_count - patches.first_sum);
      return options;
    }
    GpuGather gather;
    GpuFair fair;
  };

  Parts(Context& on, const DeviceSystem::Parts& system, const SolveOptions& wanted);

  [[nodiscard]] const Buffer& control_points() const {
    return fair ? fair->fair.buffers().state : progressive->given.control_points();
  }
  /// Of all instances.
  [[nodiscard]] const Buffer& given_points() const {
    return fair ? fair->gather.points() : progressive->given.given();
  }
  [[nodiscard]] const Buffer& state_points() const {
    return fair ? fair->fair.buffers().state_offsets : step->state();
  }
  /// Of one.
  [[nodiscard]] BufferRange points_of(const Buffer& points, std::uint64_t count,
                                      std::uint32_t instance) const {
    return {points.handle(), instance * instances.stride(count) * kPointBytes,
            std::max<std::uint64_t>(count, 1) * kPointBytes};
  }
  [[nodiscard]] const Buffer& status() const {
    return fair ? fair->fair.buffers().status : progressive->solve.status();
  }

  Wait record_solve(VkCommandBuffer commands, const SolveParameters& parameters,
                    std::uint32_t round) const noexcept;
  /// What the surface is evaluated from.
  Wait record_surface(VkCommandBuffer commands, std::size_t round) const noexcept;
  Wait record_evaluate(VkCommandBuffer commands, std::uint32_t slot,
                       std::size_t round) const noexcept;

  Context& context;
  Arena arena;  // of all that follows
  const DeviceSystem::Parts& system;
  std::uint32_t max_iterations;
  InstanceSizes sizes;
  Instances instances;
  std::uint32_t slot_count;
  std::uint64_t given_bytes;               // of all instances
  std::vector<HostRange> read;             // of the host's buffers
  std::optional<Buffer> own_given;         // where the host gives no buffer for a slot
  std::optional<Progressive> progressive;  // one of these two
  std::optional<Fair> fair;
  std::optional<GpuLeastBending> bending;
  std::optional<GpuFirstStep> step;                // of the progressive method
  std::optional<GpuRingSums> sums;                 // where large rings are
  std::vector<std::optional<GpuPatches>> patches;  // of each slot
  std::optional<GpuEdit> edit;                     // where the host lists what moves

 private:
  Parts(Context& on, const DeviceSystem::Parts& system, const InstanceSizes& sizes,
        const SolveOptions& options);
  static InstanceSizes sizes_of(const DeviceSystem::Parts& system, const SolveOptions& options);
  /// Of each slot: the host's, or the Solve's own.
  std::vector<GivenPoints> given_points_of(std::span<const FrameSlot> slots);
  void make_patches(std::span<const FrameSlot> slots);
  void make_edit(std::span<const FrameSlot> slots);
};

Solve::Parts::Progressive::Progressive(Arena& arena, const DeviceSystem::Parts& system,
                                       const SolveOptions& options,
                                       std::span<const GivenPoints> points)
    : solve(arena, system.masks, solve_options(arena.context(), options)),
      given(arena, system.masks, solve, system.vertices, system.used_vertices, points) {
  const std::vector<StepCoefficients> steps =
      chebyshev_steps(system.spectral_bound, static_cast<std::int32_t>(options.max_iterations));
  solve.set_plan(steps);
}

InstanceSizes Solve::Parts::sizes_of(const DeviceSystem::Parts& system,
                                     const SolveOptions& options) {
  const auto is_evaluated = [](const auto& slot) {
    return slot.vertices.buffer != VK_NULL_HANDLE || slot.moved.buffer != VK_NULL_HANDLE;
  };
  return {static_cast<std::uint64_t>(system.given_count),
          system.used_vertices.size(),
          static_cast<std::uint64_t>(system.patches->point_count),
          static_cast<std::uint64_t>(system.vertex_count),
          system.max_vertex_stride,
          system.fair.has_value(),
          system.edits.has_value(),
          system.patches->has_frames,
          is_evaluated(options) || std::ranges::any_of(options.further_slots, is_evaluated) ||
              system.places || system.levels};
}

std::vector<GivenPoints> Solve::Parts::given_points_of(std::span<const FrameSlot> slots) {
  std::vector<GivenPoints> points;
  for (const FrameSlot& slot : slots) {
    points.push_back(slot.given);
    if (slot.given.buffer) continue;
    if (!own_given) own_given.emplace(arena, given_bytes, MemoryUse::Device, "planish host points");
    points.back().buffer = own_given->handle();
  }
  return points;
}

void Solve::Parts::make_patches(std::span<const FrameSlot> slots) {
  for (const FrameSlot& slot : slots) {
    std::optional<GpuPatches>& target = patches.emplace_back();
    if (slot.vertices.buffer)
      target.emplace(arena, *system.patches, given_points(), state_points(), slot.vertices,
                     sizes.rows, instances);
  }
}

Solve::Parts::Parts(Context& on, const DeviceSystem::Parts& on_device, const SolveOptions& wanted)
    : Parts(on, on_device, sizes_of(on_device, wanted), wanted) {}

Solve::Parts::Parts(Context& on, const DeviceSystem::Parts& of_system, const InstanceSizes& of,
                    const SolveOptions& options)
    : context(on),
      arena(on),
      system(of_system),
      max_iterations(options.max_iterations),
      sizes(of),
      instances{options.instances},
      given_bytes(options.instances * of.given * kVectorBytes) {
  const std::vector<FrameSlot> slots = checked_slots(on, of, options);
  slot_count = static_cast<std::uint32_t>(slots.size());
  read = read_ranges(slots, of, options.instances);
  const std::vector<GivenPoints> points = given_points_of(slots);
  if (system.fair)
    fair.emplace(arena, system, fair_options(options), points);
  else
    progressive.emplace(arena, system, options, points);
  if (system.bending) bending.emplace(arena, *system.bending, given_points(), instances);
  if (progressive && sizes.has_surface)
    step.emplace(arena, *system.patches, *system.step, progressive->given.given(),
                 progressive->given.displacement(), sizes.rows, instances);
  if (sizes.has_surface && system.patches->ring_count > 0)
    sums.emplace(arena, *system.patches, given_points(), state_points(), sizes.rows, instances);
  make_patches(slots);
  if (std::ranges::any_of(
          slots, [](const FrameSlot& slot) { return slot.moved.buffer != VK_NULL_HANDLE; }))
    make_edit(slots);
  arena.finish();
}

void Solve::Parts::make_edit(std::span<const FrameSlot> slots) {
  edit.emplace(
      arena,
      EditedParts{system.masks, system.vertices, *system.edits, *system.patches, *system.step,
                  progressive->solve, progressive->given, *step, sums ? &*sums : nullptr},
      system.given_count, slots);
}

Solve::Solve(Context& context, const DeviceSystem& system, const SolveOptions& options)
    : parts_(std::make_unique<Parts>(context, *system.parts_, options)) {}
Solve::~Solve() = default;
Solve::Solve(Solve&&) noexcept = default;
Solve& Solve::operator=(Solve&&) noexcept = default;

Wait Solve::Parts::record_solve(VkCommandBuffer commands, const SolveParameters& parameters,
                                std::uint32_t round) const noexcept {
  // Between the points' gathering, the first round of both methods, and what reads them.
  if (bending && round > 0) {
    if (round <= GpuLeastBending::kRoundCount) return bending->record_round(commands, round - 1);
    round -= GpuLeastBending::kRoundCount;
  }
  if (fair) {
    if (round == 0) fair->gather.record(commands, parameters.slot % slot_count);
    Wait wait = fair->fair.record_round(commands, round);
    if (round == 0) wait |= kKernelWait;
    return wait;
  }
  StepRun run;
  run.count = std::min(parameters.iterations, max_iterations);
  run.stop_square = stop_square_of(parameters.stop_error);
  run.measures_last = parameters.measures_last || run.count == 0;
  if (round == 1) return progressive->given.record_residual(commands);
  if (round > 1) return progressive->solve.record_round(commands, run, round - 1);
  // What prepares the points and what prepares the steps do not meet.
  if (edit) edit->record_clear(commands);
  Wait wait = progressive->given.record_points(commands, parameters.warm_start,
                                               parameters.slot % slot_count);
  return wait |= progressive->solve.record_round(commands, run, 0);
}

Wait Solve::Parts::record_surface(VkCommandBuffer commands, std::size_t round) const noexcept {
  if (progressive && round-- == 0) {
    progressive->given.record_control_points(commands);
    return kKernelWait;
  }
  const std::size_t steps = step ? step->round_count() : 0;
  if (round < steps) return step->record_round(commands, round);
  return sums && round == steps ? sums->record(commands) : Wait{};
}

Wait Solve::Parts::record_evaluate(VkCommandBuffer commands, std::uint32_t slot,
                                   std::size_t round) const noexcept {
  const std::size_t surface_rounds =
      (progressive ? 1 : 0) + (step ? step->round_count() : 0) + (sums ? 1 : 0);
  if (round < surface_rounds) return record_surface(commands, round);
  const std::optional<GpuPatches>& vertices = patches[slot % slot_count];
  return vertices ? vertices->record_round(commands, round - surface_rounds) : Wait{};
}

SolvePoints Solve::surface_points(std::uint32_t instance) const {
  return {parts_->points_of(parts_->given_points(), parts_->sizes.rows, instance),
          parts_->points_of(parts_->state_points(), parts_->sizes.points, instance)};
}
EvaluatedParts Solve::evaluated_parts() const {
  const Parts& parts = *parts_;
  const PatchTables& patches = *parts.system.patches;
  const std::int64_t points = patches.ring_count > 0 ? patches.first_sum : patches.point_count;
  const std::uint64_t hull = parts.fair ? static_cast<std::uint64_t>(points) : parts.sizes.rows;
  return {parts.sizes,
          {patches, parts.system.step ? &*parts.system.step : nullptr, *parts.system.levels,
           parts.control_points(), hull, parts.instances.stride(hull), parts.given_points(),
           parts.state_points(), parts.sizes.rows, parts.instances,
           parts.progressive ? &parts.progressive->given.displacement() : nullptr},
          parts.progressive ? &parts.progressive->given : nullptr,
          parts.read};
}
std::uint32_t Solve::instance_count() const { return parts_->instances.count; }
VkDeviceSize Solve::control_point_stride() const {
  const InstanceSizes& sizes = parts_->sizes;
  return parts_->instances.stride(sizes.is_fair ? sizes.points : sizes.rows) * kPointBytes;
}
VkBuffer Solve::control_points() const { return parts_->control_points().handle(); }

void Solve::record_reset(VkCommandBuffer commands) const noexcept {
  record_barrier(parts_->context, commands, kExitScope, kEntryScope);
  if (parts_->progressive) parts_->progressive->solve.record_clear(commands);
}

void Solve::record_given(VkCommandBuffer commands, VkBuffer source,
                         VkDeviceSize offset) const noexcept {
  if (!parts_->own_given)
    return parts_->context.tell(
        "planish: record_given does nothing, as each slot has a buffer of points; write that, or "
        "set GivenPoints without one");
  if (parts_->given_bytes == 0) return;
  record_barrier(parts_->context, commands, kExitScope, kEntryScope);
  const VkBufferCopy copy{offset, 0, parts_->given_bytes};
  parts_->context.vk().vkCmdCopyBuffer(commands, source, parts_->own_given->handle(), 1, &copy);
}

void Solve::record_solve(VkCommandBuffer commands,
                         const SolveParameters& parameters) const noexcept {
  const SolveCall call{this, parameters};
  record_solves(commands, std::span(&call, 1));
}

void Solve::record_evaluate(VkCommandBuffer commands,
                            const EvaluateParameters& parameters) const noexcept {
  const EvaluateCall call{this, parameters};
  record_evaluates(commands, std::span(&call, 1));
}

void Solve::record_surface(VkCommandBuffer commands) const noexcept {
  const LabelScope label(parts_->context, commands, "planish surface");
  record_barrier(parts_->context, commands, kExitScope, kEntryScope);
  record_rounds(parts_->context, commands, 1, [&](std::size_t, std::uint32_t round) {
    return parts_->record_surface(commands, round);
  });
}

void Solve::record_edit(VkCommandBuffer commands, const EditParameters& parameters) const noexcept {
  const Context& context = parts_->context;
  const std::uint32_t slot = parameters.slot % parts_->slot_count;
  if (!parts_->edit || !parts_->edit->has_list(slot))
    return context.tell(
        "planish: record_edit does nothing, as its slot has no list; set SolveOptions::moved, or "
        "FrameSlot::moved");
  const LabelScope label(context, commands, "planish edit");
  record_barrier(context, commands, kExitScope, kEntryScope);
  write_first(context, commands, parameters.timestamps);
  parts_->edit->record(commands, slot, std::min(parameters.iterations, parts_->max_iterations),
                       stop_square_of(parameters.stop_error));
  write_second(context, commands, parameters.timestamps);
}

void Solve::record_reach(VkCommandBuffer commands, VkBuffer target,
                         VkDeviceSize offset) const noexcept {
  if (!parts_->edit)
    return parts_->context.tell(
        "planish: record_reach does nothing, as no slot has a list; set SolveOptions::moved");
  record_barrier(parts_->context, commands, kExitScope, kEntryScope);
  const VkBufferCopy copy{0, offset, sizeof(EditReach)};
  parts_->context.vk().vkCmdCopyBuffer(commands, parts_->edit->reach(), target, 1, &copy);
}

void Solve::record_status(VkCommandBuffer commands, VkBuffer target,
                          VkDeviceSize offset) const noexcept {
  record_barrier(parts_->context, commands, kExitScope, kEntryScope);
  // The first words of each instance's, some at a time: recording takes no memory.
  std::array<VkBufferCopy, 64> copies;
  const std::uint32_t count = parts_->instances.count;
  for (std::uint32_t first = 0; first < count; first += copies.size()) {
    const std::uint32_t some = std::min<std::uint32_t>(count - first, copies.size());
    for (std::uint32_t i = 0; i < some; ++i)
      copies[i] = {(first + i) * sizeof(shared::SolveStatus),
                   offset + (first + i) * sizeof(GpuStatus), sizeof(GpuStatus)};
    parts_->context.vk().vkCmdCopyBuffer(commands, parts_->status().handle(), target, some,
                                         copies.data());
  }
}

void record_solves(VkCommandBuffer commands, std::span<const SolveCall> calls) noexcept {
  if (calls.empty()) return;
  const Context& context = calls.front().solve->parts_->context;
  const LabelScope label(context, commands, "planish solve");
  record_calls(
      context, commands, calls.size(),
      [&](std::size_t i) -> const Timestamps& { return calls[i].parameters.timestamps; },
      [&](std::size_t i, std::uint32_t round) {
        return calls[i].solve->parts_->record_solve(commands, calls[i].parameters, round);
      });
}

void record_evaluates(VkCommandBuffer commands, std::span<const EvaluateCall> calls) noexcept {
  if (calls.empty()) return;
  const Context& context = calls.front().solve->parts_->context;
  const LabelScope label(context, commands, "planish evaluate");
  record_calls(
      context, commands, calls.size(),
      [&](std::size_t i) -> const Timestamps& { return calls[i].parameters.timestamps; },
      [&](std::size_t i, std::uint32_t round) {
        return calls[i].solve->parts_->record_evaluate(commands, calls[i].parameters.slot, round);
      });
}

namespace {

constexpr std::uint32_t kPlaceBytes = shared::kPlaceWords * sizeof(float);

[[noreturn]] void refuse_places(const std::string& message) {
  throw Error(ErrorCode::InvalidArgument, message);
}

void check_list(const PlaceList& list) {
  if (list.count == 0) refuse_places("a list of places has none; give its count");
  if (list.offset % sizeof(float) != 0 || list.stride % sizeof(float) != 0 ||
      list.stride < kPlaceBytes)
    refuse_places(
        formatted("a list of places with offset {} and stride {}: both are multiples of 4 bytes, "
                  "the stride 12 at least",
                  list.offset, list.stride));
}

// Results from each other, and from the list.
void check_apart(const PlacesOptions& options) {
  const PlaceList& list = options.list;
  const PlaceLayout& to = options.results;
  std::vector<HostRange> written;
  const auto add = [&](const char* what, std::uint32_t offset, std::uint64_t bytes) {
    if (offset != kNotWritten)
      written.push_back({what, to.buffer, to.offset + offset, to.stride, list.count, bytes});
  };
  add("positions of places", to.position_offset, kVectorBytes);
  add("normals of places", to.normal_offset, kVectorBytes);
  add("du of places", to.du_offset, kVectorBytes);
  add("dv of places", to.dv_offset, kVectorBytes);
  add("duu of places", to.duu_offset, kVectorBytes);
  add("duv of places", to.duv_offset, kVectorBytes);
  add("dvv of places", to.dvv_offset, kVectorBytes);
  add("states of places", to.state_offset, sizeof(PlaceState));
  require_apart(written);
  const HostRange read{"a list of places", list.buffer, list.offset,
                       list.stride,        list.count,  kPlaceBytes};
  require_apart(std::span(&read, 1), written);
}

void check_results(const PlacesOptions& options) {
  const PlaceLayout& layout = options.results;
  const std::uint32_t offsets[] = {layout.position_offset, layout.normal_offset, layout.du_offset,
                                   layout.dv_offset,       layout.duu_offset,    layout.duv_offset,
                                   layout.dvv_offset,      layout.state_offset};
  if (!layout.buffer) refuse_places("results of places have no buffer");
  if (layout.offset % sizeof(float) != 0 || layout.stride % sizeof(float) != 0)
    refuse_places(
        formatted("results of places lie at multiples of 4 bytes, not from {} on every {}",
                  layout.offset, layout.stride));
  for (const std::uint32_t offset : offsets)
    if (offset != kNotWritten && (offset % sizeof(float) != 0 || offset >= layout.stride))
      refuse_places(
          formatted("the offset {} of a place's result is no multiple of 4 below the stride {}",
                    offset, layout.stride));
  const std::uint64_t end = result_bytes(layout);
  if (end == 0) refuse_places("no result of places is wanted; give one an offset");
  if (end > layout.stride)
    refuse_places(
        formatted("a place's results end at {} bytes, behind the stride {}", end, layout.stride));
  check_apart(options);
}

const PlaceTables& tables_of(const std::optional<PlaceTables>& tables) {
  if (!tables)
    refuse_places("the DeviceSystem has no tables for places; make it with answers_places");
  return *tables;
}

void check_instance(const Solve& solve, std::uint32_t instance) {
  if (instance >= solve.instance_count())
    refuse_places(formatted("instance {} of places is none of the Solve's {}", instance,
                            solve.instance_count()));
}

std::optional<Buffer> make_list(Context& context, const PlaceList& list) {
  check_list(list);
  if (list.buffer) return {};
  if (list.stride != kPlaceBytes || list.offset != 0)
    refuse_places("a list of places without a buffer begins at 0 with stride 12");
  return Buffer(context, std::uint64_t(list.count) * kPlaceBytes, MemoryUse::Device,
                "planish places");
}

}  // namespace

struct Places::Parts {
  Parts(Context& on, const PatchTables& patches, const PlaceTables& tables,
        const SolvePoints& points, const PlacesOptions& options)
      : context(on), count(options.list.count), own_list(make_list(on, options.list)) {
    check_results(options);
    PlaceList list = options.list;
    if (own_list) list.buffer = own_list->handle();
    places.emplace(on, patches, tables, points.given, points.state, list, options.results);
  }

  Context& context;
  std::uint32_t count;
  std::optional<Buffer> own_list;  // where the host gives no buffer
  std::optional<GpuPlaces> places;
};

SurfaceBuffers surface_buffers(const DeviceSystem& system, const Solve& solve,
                               std::uint32_t instance) {
  const PlaceTables& tables = tables_of(system.parts_->places);
  check_instance(solve, instance);
  const SolvePoints points = solve.surface_points(instance);
  const auto info = [](const BufferRange& range) {
    return VkDescriptorBufferInfo{range.buffer, range.offset, range.size};
  };
  return {info(whole(tables.words)),   info(whole(system.parts_->patches->links)),
          info(points.state),          info(points.given),
          info(whole(tables.weights)), tables.face_count,
          tables.corner_count};
}

Places::Places(Context& context, const DeviceSystem& system, const Solve& solve,
               const PlacesOptions& options) {
  const PlaceTables& tables = tables_of(system.parts_->places);
  check_instance(solve, options.instance);
  parts_ = std::make_unique<Parts>(context, *system.parts_->patches, tables,
                                   solve.surface_points(options.instance), options);
}
Places::~Places() = default;
Places::Places(Places&&) noexcept = default;
Places& Places::operator=(Places&&) noexcept = default;

void Places::record_list(VkCommandBuffer commands, VkBuffer source,
                         VkDeviceSize offset) const noexcept {
  if (!parts_->own_list)
    return parts_->context.tell(
        "planish: record_list does nothing, as the list has a buffer; write that, or set PlaceList "
        "without one");
  const Context& context = parts_->context;
  record_barrier(context, commands, kExitScope, kEntryScope);
  const VkBufferCopy copy{offset, 0, std::uint64_t(parts_->count) * kPlaceBytes};
  context.vk().vkCmdCopyBuffer(commands, source, parts_->own_list->handle(), 1, &copy);
}

void Places::record_evaluate(VkCommandBuffer commands, std::uint32_t count,
                             const Timestamps& timestamps) const noexcept {
  const Context& context = parts_->context;
  const LabelScope label(context, commands, "planish places");
  record_barrier(context, commands, kExitScope, kEntryScope);
  write_first(context, commands, timestamps);
  parts_->places->record(commands, std::min(count, parts_->count));
  write_second(context, commands, timestamps);
}

namespace {

// A number of places for each level.
std::vector<std::uint32_t> places_of(const LevelSetTables& tables, std::uint32_t count,
                                     std::vector<std::uint32_t> places) {
  const std::size_t levels = tables.levels.size();
  if (places.empty()) places.assign(levels, count);
  require_option(places.size() == levels, "places are of {} levels, but the System has {}",
                 places.size(), levels);
  for (std::uint32_t& of_level : places) {
    require_option(of_level > 0,
                   "a level has places for no instance; give it some, or leave it out");
    of_level = std::min(of_level, count);
  }
  require_option(places[0] == count,
                 "the coarsest level has places for {} instances, but takes all {}", places[0],
                 count);
  return places;
}

std::uint64_t vertex_total(const LevelSetTables& tables, std::span<const std::uint32_t> places) {
  std::uint64_t vertices = 0;
  for (std::size_t k = 0; k < places.size(); ++k)
    vertices += std::uint64_t{places[k]} * tables.levels[k].vertex_count;
  return vertices;
}

TessellationOptions checked(const LevelSetTables& tables, const EvaluatedParts& solve,
                            TessellationOptions options) {
  require_option(options.vertices.buffer, "vertices of a Tessellation have no buffer");
  check_layout(options.vertices, solve.sizes);
  require_option(attributes_of(options.vertices).buffer == options.vertices.buffer,
                 "a Tessellation has positions and attributes in one buffer");
  const bool has_previous = options.previous_positions.stride > 0;
  require_option(!has_previous || options.previous_positions.buffer,
                 "previous positions of a Tessellation have no buffer");
  options.places = places_of(tables, solve.chosen.instances.count, std::move(options.places));
  const std::uint64_t vertices = vertex_total(tables, options.places);
  std::vector<HostRange> written =
      vertex_ranges(options.vertices, " of the Tessellation", vertices, 1);
  if (has_previous) {
    const VertexLayout previous = previous_layout(options);
    check_layout(previous, solve.sizes);
    std::ranges::move(vertex_ranges(previous, " of the view before", vertices, 1),
                      std::back_inserter(written));
  }
  require_apart(written);
  require_apart(solve.read, written);
  return options;
}

const LevelSetTables& level_set_of(const std::optional<LevelSetTables>& tables) {
  require_option(tables.has_value(),
                 "the System has no levels to choose from; give SystemOptions some");
  return *tables;
}

}  // namespace

std::uint64_t DeviceSystem::tessellation_bytes(const TessellationOptions& options,
                                               std::uint32_t instances) const {
  const LevelSetTables& tables = level_set_of(parts_->levels);
  const std::uint64_t vertices = vertex_total(tables, places_of(tables, instances, options.places));
  const VertexStream attributes = attributes_of(options.vertices);
  const std::uint64_t own = std::max(options.vertices.offset + vertices * options.vertices.stride,
                                     attributes.offset + vertices * attributes.stride);
  const VertexStream& previous = options.previous_positions;
  if (previous.stride == 0 || vertices == 0) return own;
  return std::max(own, previous.offset + (vertices - 1) * previous.stride +
                           bytes_of(options.vertices.position_format));
}

struct Tessellation::Parts {
  Parts(Context& on, const LevelSetTables& tables, const EvaluatedParts& solve,
        const TessellationOptions& options)
      : arena(on),
        context(on),
        given(solve.given),
        instances(solve.chosen.instances),
        indices(tables.indices.handle()),
        levels(arena, solve.chosen, checked(tables, solve, options)) {
    arena.finish();
  }

  Arena arena;  // of all that follows
  Context& context;
  const GpuGiven* given;
  Instances instances;
  VkBuffer indices;
  GpuLevels levels;
};

Tessellation::Tessellation(Context& context, const DeviceSystem& system, const Solve& solve,
                           const TessellationOptions& options) {
  const LevelSetTables& tables = level_set_of(system.parts_->levels);
  parts_ = std::make_unique<Parts>(context, tables, solve.evaluated_parts(), options);
}
Tessellation::~Tessellation() = default;
Tessellation::Tessellation(Tessellation&&) noexcept = default;
Tessellation& Tessellation::operator=(Tessellation&&) noexcept = default;

void Tessellation::record_reset(VkCommandBuffer commands) const noexcept {
  const Context& context = parts_->context;
  record_barrier(context, commands, kExitScope, kEntryScope);
  if (parts_->given && parts_->levels.writes_previous()) {
    // Of the last solve, as is its displacement.
    parts_->given->record_control_points(commands);
    record_barrier(context, commands, kEntryScope, kEntryScope);
  }
  parts_->levels.record_reset(commands);
}

void Tessellation::record_evaluate(VkCommandBuffer commands,
                                   const TessellateParameters& parameters) const noexcept {
  const Context& context = parts_->context;
  const LabelScope label(context, commands, "planish levels");
  record_barrier(context, commands, kExitScope, kEntryScope);
  write_first(context, commands, parameters.timestamps);
  if (parts_->given) parts_->given->record_control_points(commands);
  parts_->levels.record(commands, parameters);
  write_second(context, commands, parameters.timestamps);
}

void Tessellation::record_levels(VkCommandBuffer commands, VkBuffer target,
                                 VkDeviceSize offset) const noexcept {
  const Context& context = parts_->context;
  record_barrier(context, commands, kExitScope, kEntryScope);
  const VkDeviceSize bytes = VkDeviceSize(parts_->instances.count) * sizeof(std::uint32_t);
  const VkBufferCopy copy{bytes, offset, bytes};
  context.vk().vkCmdCopyBuffer(commands, parts_->levels.levels(), target, 1, &copy);
}

LevelDraw Tessellation::level_draw(std::size_t level) const {
  return parts_->levels.level_draw(level);
}
VkBuffer Tessellation::draws() const { return parts_->levels.draws(); }
VkBuffer Tessellation::indices() const { return parts_->indices; }

}  // namespace planish::vulkan
