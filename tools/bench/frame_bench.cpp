// What a frame of a host costs: points that move, a solve from where the last one ended, vertices.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <stdexcept>

#include "bench/benchmarks.h"
#include "bench/device_clock.h"
#include "bench/device_frame.h"
#include "bench/device_trace.h"
#include "bench/moving_torus.h"
#include "bench/refusal.h"
#include "planish/core/formatted.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/fenced_commands.h"
#include "planish/vulkan/device/result.h"

namespace planish::bench {

namespace {

using namespace vulkan;

constexpr double kFrameTolerance = 1e-5;  // of the diagonal
constexpr double kFrameWithin = 1e-3;     // of the diagonal
constexpr int kPoses = 16;                // there and back again, as often as wanted
constexpr std::uint32_t kSpareIterations = 4;
constexpr double kLoopSeconds = 5;  // after which the loop takes no more frames
constexpr std::array<double, 3> kMemorySpeeds = {200, 500, 3000};  // GB/s: laptop, desktop, server

struct FrameTimes {
  std::vector<double> solve, evaluate, frame;
  std::vector<double> iterations;
  double largest_error = 0;
};

class FrameBudget {
 public:
  FrameBudget(VulkanMachine& machine, const PolygonMesh& mesh, double within = 0)
      : machine_(machine),
        frame_(machine, mesh,
               {.level = kFrameLevel, .within = within, .tolerance = kFrameTolerance}),
        clock_(machine, 4),
        status_(machine.context, sizeof(GpuStatus), MemoryUse::Download) {
    for (int i = 0; i < kPoses; ++i) poses_.push_back(twisted(mesh, i));
    group_.name = "frame";
    group_.size = formatted("{} points, {} vertices; {}{}", mesh.vertex_count(),
                            frame_.system.vertex_count(), machine.device.capabilities().name,
                            clock_.pool() ? "" : ", by the host's clock: it has no timestamps");
    group_.baseline = "warm-frame";
  }

  std::vector<Row> measure(const Options& options) {
    const FrameTimes cold = run_frames(options.repetitions, false);
    const FrameTimes warm = run_frames(options.repetitions, true);
    std::vector<Row> rows = {row_of_times(group_, "cold-solve", cold.solve),
                             row_of_times(group_, "warm-solve", warm.solve),
                             row_of_times(group_, "evaluate", warm.evaluate),
                             row_of_times(group_, "warm-frame", warm.frame)};
    rows[0].figures = solve_figures(cold);
    rows[1].figures = solve_figures(warm);
    rows[3].figures = frame_figures(warm);
    rows.push_back(run_loop(options.loop_frames));
    for (Row& row : rows) row.ratio = rows[3].median_ms > 0 ? row.median_ms / rows[3].median_ms : 0;
    return rows;
  }

  // The warm solve of surfaces that may leave their points.
  Row measure_within(const Options& options) {
    const FrameTimes warm = run_frames(options.repetitions, true);
    Row row = row_of_times(group_, "within-solve", warm.solve);
    row.figures = frame_figures(warm);
    return row;
  }

 private:
  [[nodiscard]] const std::vector<glm::vec3>& pose(int frame) const {
    const int place = frame % (2 * kPoses - 2);
    return poses_[place < kPoses ? place : 2 * kPoses - 2 - place];
  }
  [[nodiscard]] SolveParameters parameters(bool warm) const {
    SolveParameters result;
    result.iterations = frame_.system.rest_iterations() + kSpareIterations;
    result.stop_error = static_cast<float>(frame_.system.tolerance());
    result.warm_start = warm;
    return result;
  }

  // The first is not counted: it compiles, and has no last frame to start from.
  FrameTimes run_frames(int count, bool warm) {
    FrameTimes times;
    for (int i = 0; i <= count; ++i) {
      frame_.set_points(machine_, pose(i));
      SolveParameters solve = parameters(warm && i > 0);
      solve.timestamps = {clock_.pool(), 0};
      const auto began = std::chrono::steady_clock::now();
      machine_.submitter.run([&](VkCommandBuffer commands) {
        clock_.record_reset(commands);
        frame_.solve.record_solve(commands, solve);
        frame_.solve.record_evaluate(commands, {.timestamps = {clock_.pool(), 2}});
        frame_.solve.record_status(commands, status_.handle(), 0);
      });
      const std::chrono::duration<double, std::milli> waited =
          std::chrono::steady_clock::now() - began;
      if (i > 0) take(times, waited.count());
    }
    return times;
  }

  void take(FrameTimes& times, double waited_ms) {
    status_.invalidate();
    GpuStatus status;
    std::memcpy(&status, status_.mapped().data(), sizeof status);
    if (status.state != SolveState::Converged)
      throw std::runtime_error("a frame's solve has not converged: " +
                               std::to_string(status.residual));
    times.iterations.push_back(status.iterations);
    times.largest_error =
        std::max(times.largest_error, double(status.residual) / frame_.system.diagonal());
    const std::vector<double> spans = clock_.spans(0, 2);
    if (spans.empty()) return times.frame.push_back(waited_ms);
    times.solve.push_back(spans[0]);
    times.evaluate.push_back(spans[1]);
    times.frame.push_back(spans[0] + spans[1]);
  }

  static std::vector<std::pair<std::string, double>> solve_figures(const FrameTimes& times) {
    return {
        {"iterations", median(times.iterations)},
        {"most_iterations", *std::max_element(times.iterations.begin(), times.iterations.end())},
        {"error", times.largest_error}};
  }

  // Bytes of the dispatches that run: the median's iterations, and the step that measures.
  std::vector<std::pair<std::string, double>> frame_figures(const FrameTimes& times) {
    std::vector<TracedDispatch> dispatches;
    machine_.submitter.run([&](VkCommandBuffer commands) {
      SolveParameters solve;
      solve.iterations = static_cast<std::uint32_t>(median(times.iterations));
      solve.warm_start = true;
      DeviceTrace::begin({});
      frame_.solve.record_solve(commands, solve);
      frame_.solve.record_evaluate(commands);
      dispatches = DeviceTrace::end();
    });
    double bytes = 0;
    for (const TracedDispatch& dispatch : dispatches)
      bytes += static_cast<double>(dispatch.bound_bytes);
    const double ms = median(times.frame);
    std::vector<std::pair<std::string, double>> figures = {
        {"dispatches", static_cast<double>(dispatches.size())},
        {"bytes", bytes},
        {"table_bytes", static_cast<double>(frame_.tables.device_bytes())},
        {"gigabytes_per_second", ms > 0 ? 1e-6 * bytes / ms : 0}};
    for (const double speed : kMemorySpeeds)
      figures.emplace_back(formatted("predicted_ms_{}", static_cast<int>(speed)),
                           1e-6 * bytes / speed);
    return figures;
  }

  // One of the frames in flight.
  struct Slot {
    Slot(VulkanMachine& machine, const DeviceFrame& frame)
        : points(machine.context, frame.points.size(), MemoryUse::Device),
          staging(machine.context, frame.points.size(), MemoryUse::Upload),
          commands(machine.context, machine.device.capabilities().compute_family) {}
    Buffer points, staging;
    FencedCommands commands;
    bool is_under_way = false;
  };

  // Waits for what is under way before anything that it uses goes.
  struct Idle {
    ~Idle() { context.vk().vkDeviceWaitIdle(context.device()); }
    Context& context;
  };

  void submit(const vulkan::Solve& solve, Slot& slot, int frame) {
    const std::span<const std::byte> bytes = std::as_bytes(std::span(pose(frame)));
    std::memcpy(slot.staging.mapped().data(), bytes.data(), bytes.size());
    slot.staging.flush();
    slot.commands.submit(machine_.device.queue(), [&](VkCommandBuffer commands) {
      const VkBufferCopy copy{0, 0, bytes.size()};
      record_barrier(machine_.context, commands, kExitScope, kEntryScope);
      machine_.context.vk().vkCmdCopyBuffer(commands, slot.staging.handle(), slot.points.handle(),
                                            1, &copy);
      SolveParameters wanted = parameters(frame > 0);
      wanted.slot = static_cast<std::uint32_t>(frame);
      solve.record_solve(commands, wanted);
      solve.record_evaluate(commands, {.slot = wanted.slot});
    });
    slot.is_under_way = true;
  }

  // Two frames in flight, points that come from the host; from one end of a wait to the next.
  Row run_loop(int frame_count) {
    std::array<Slot, 2> slots = {Slot(machine_, frame_), Slot(machine_, frame_)};
    const vulkan::Solve solve =
        frame_.make_solve(machine_, {slots[0].points.handle(), slots[1].points.handle()});
    const Idle idle{machine_.context};
    std::vector<double> times;
    auto last = std::chrono::steady_clock::now();
    const auto began = last;
    int submitted = 0;
    for (int i = 0; i < submitted + 2; ++i) {
      Slot& slot = slots[i % 2];
      if (slot.is_under_way) {
        check(slot.commands.wait(UINT64_MAX), "vkWaitForFences");
        const auto now = std::chrono::steady_clock::now();
        times.push_back(std::chrono::duration<double, std::milli>(now - last).count());
        last = now;
      }
      const std::chrono::duration<double> so_far = last - began;
      if (i == submitted && i < frame_count && (i < 2 || so_far.count() < kLoopSeconds)) {
        submit(solve, slot, i);
        ++submitted;
      }
    }
    const std::chrono::duration<double> all = last - began;
    Row row = row_of_times(group_, "loop", times);
    row.figures = {{"frames", static_cast<double>(submitted)},
                   {"frames_per_second", submitted / all.count()}};
    return row;
  }

  VulkanMachine& machine_;
  DeviceFrame frame_;
  DeviceClock clock_;
  Buffer status_;
  std::vector<std::vector<glm::vec3>> poses_;
  Group group_;
};

}  // namespace

std::vector<Row> bench_frame(const Options& options) {
  const auto machine = traced_machine(options);
  if (!machine) return {};
  std::vector<Row> rows;
  for (const std::int32_t point_count : options.point_counts) {
    const PolygonMesh mesh = rough_torus(point_count);
    try {
      FrameBudget budget(*machine, mesh);
      const std::vector<Row> measured = budget.measure(options);
      rows.insert(rows.end(), measured.begin(), measured.end());
      rows.push_back(FrameBudget(*machine, mesh, kFrameWithin).measure_within(options));
    } catch (const Error& error) {
      rows.push_back(
          refusal(error, "frame", formatted("{} points", mesh.vertex_count()), "warm-frame"));
    }
  }
  return rows;
}

}  // namespace planish::bench
