// Based on: the paper, section 3.2, with Golub & Varga's semi-iteration for its steps: everything
// between a host's points and the vertices that it draws, in the host's command buffer.
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "planish/backend/chebyshev.h"
#include "planish/fair/fair_net.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/edit/gpu_edit.h"
#include "planish/vulkan/evaluate/gpu_first_step.h"
#include "planish/vulkan/evaluate/gpu_patches.h"
#include "planish/vulkan/evaluate/gpu_ring_sums.h"
#include "planish/vulkan/fair/gpu_fair.h"
#include "planish/vulkan/host/device_system.h"
#include "planish/vulkan/host/frame_slots.h"
#include "planish/vulkan/host/write_timestamps.h"
#include "planish/vulkan/solve/gpu_given.h"
#include "planish/vulkan/solve/gpu_least_bending.h"
#include "planish/vulkan/solve/gpu_solve.h"
#include "planish/vulkan/solve/stop_square.h"

namespace planish::vulkan {

namespace {

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

/// Calls in lock-step, with their timestamps around all of it. `timestamps_of(i)` and
/// `record_round(i, round)` are those of call `i`.
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
           parts.step ? &*parts.step : nullptr},
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

}  // namespace planish::vulkan
