// How fast the kernels of a frame are beside a copy of memory: bytes by the ranges that they bind,
// times by the device's own clock, all in one submission.
#include <algorithm>
#include <stdexcept>

#include "bench/access_log.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "bench/device_clock.h"
#include "bench/device_copy.h"
#include "bench/device_frame.h"
#include "bench/device_trace.h"
#include "bench/moving_torus.h"
#include "bench/refusal.h"
#include "planish/core/formatted.h"
#include "planish/vulkan/device/commands.h"

namespace planish::bench {

namespace {

using namespace vulkan;

// Iterations in the submission; one step more measures.
constexpr std::uint32_t kTimedIterations = 4;
constexpr std::uint32_t kCopySpans = 2;
constexpr std::int32_t kCountedPoints = 400;  // more than kSmallRows
constexpr std::int32_t kCountedHub = 512;
constexpr std::uint64_t kSoftwareCopyBytes = 64u << 20;  // caches hold less, and it takes longer

// What the dispatches of one kernel come to.
struct KernelTotal {
  std::string name;
  std::uint64_t dispatches = 0, indirect = 0;
  std::uint64_t barriers = 0;    // behind its dispatches
  std::uint64_t bytes = 0;       // of the others: how often the device runs those is its own affair
  std::vector<double> times_ms;  // per repetition
};

void record_frame(const DeviceFrame& frame, VkCommandBuffer commands) {
  frame.solve.record_solve(commands, {.iterations = kTimedIterations, .measures_last = true});
  frame.solve.record_evaluate(commands);
}

// What one pass of the kernel makes, times its passes.
double elements_of(std::string_view kernel, const PolygonMesh& mesh, const DeviceFrame& frame) {
  if (kernel == "first_step") return static_cast<double>(mesh.face_vertices.size());
  if (kernel == "corner_patches") return frame.system.vertex_count();
  const double passes = kernel == "interpolation_step" ? kTimedIterations + 1 : 1;
  return passes * mesh.vertex_count();
}

class FrameKernels {
 public:
  FrameKernels(VulkanMachine& machine, DeviceCopy& copy, const PolygonMesh& mesh,
               InterpolationMethod method)
      : machine_(machine),
        copy_(copy),
        mesh_(mesh),
        frame_(machine, mesh, {.level = kFrameLevel, .method = method}) {
    group_.name = "kernels";
    group_.size = formatted("{} points, {}{} vertices; {}", mesh.vertex_count(),
                            method == InterpolationMethod::Fair ? "fair, " : "progressive, ",
                            frame_.system.vertex_count(), machine.device.capabilities().name);
    group_.baseline = "vkCmdCopyBuffer";
  }

  std::vector<Row> measure(int repetitions) {
    std::vector<TracedDispatch> dispatches;
    machine_.submitter.run([&](VkCommandBuffer commands) {
      DeviceTrace::begin({});
      record_frame(frame_, commands);
      dispatches = DeviceTrace::end();
    });
    const auto count = static_cast<std::uint32_t>(dispatches.size());
    const DeviceClock clock(machine_, 2 * (kCopySpans + count));
    std::vector<KernelTotal> totals = totals_of(dispatches);
    for (int i = 0; i < repetitions; ++i) run_once(clock, dispatches, totals);
    if (!copy_.has_copied()) throw std::runtime_error("a copy left something out");
    return rows_of(totals);
  }

 private:
  [[nodiscard]] std::vector<KernelTotal> totals_of(
      const std::vector<TracedDispatch>& dispatches) const {
    std::vector<KernelTotal> totals = {{"copy-kernel", 1}, {"vkCmdCopyBuffer", 1}};
    for (KernelTotal& total : totals) total.bytes = 2 * copy_.bytes();
    for (const TracedDispatch& dispatch : dispatches) {
      KernelTotal& total = total_of(totals, dispatch);
      ++(dispatch.is_indirect ? total.indirect : total.dispatches);
      total.barriers += dispatch.barriers;
      if (!dispatch.is_indirect) total.bytes += dispatch.bound_bytes;
    }
    return totals;
  }

  KernelTotal& total_of(std::vector<KernelTotal>& totals, const TracedDispatch& dispatch) const {
    const std::string_view name = kernel_of(machine_.context, dispatch.layout);
    const auto found = std::find_if(totals.begin(), totals.end(),
                                    [&](const KernelTotal& total) { return total.name == name; });
    if (found != totals.end()) return *found;
    return totals.emplace_back(KernelTotal{std::string(name)});
  }

  void run_once(const DeviceClock& clock, const std::vector<TracedDispatch>& dispatches,
                std::vector<KernelTotal>& totals) {
    machine_.submitter.run([&](VkCommandBuffer commands) {
      const auto barrier = [&] {
        record_barrier(machine_.context, commands, kExitScope, kEntryScope);
      };
      clock.record_reset(commands);
      clock.record(commands, 0);
      copy_.record_kernel(commands);
      clock.record(commands, 1);
      barrier();
      clock.record(commands, 2);
      copy_.record_command(commands);
      clock.record(commands, 3);
      barrier();
      DeviceTrace::begin({clock.pool(), 2 * kCopySpans});
      record_frame(frame_, commands);
      (void)DeviceTrace::end();
    });
    const auto count = static_cast<std::uint32_t>(dispatches.size());
    const std::vector<double> spans = clock.spans(0, kCopySpans + count);
    if (spans.empty()) return;
    for (KernelTotal& total : totals) total.times_ms.push_back(0);
    for (std::size_t i = 0; i < spans.size(); ++i) {
      KernelTotal& total =
          i < kCopySpans ? totals[i] : total_of(totals, dispatches[i - kCopySpans]);
      total.times_ms.back() += spans[i];
    }
  }

  [[nodiscard]] std::vector<Row> rows_of(std::vector<KernelTotal>& totals) const {
    KernelTotal all{"frame"};
    for (std::size_t i = kCopySpans; i < totals.size(); ++i) {
      all.dispatches += totals[i].dispatches;
      all.indirect += totals[i].indirect;
      all.barriers += totals[i].barriers;
      all.bytes += totals[i].bytes;
      all.times_ms.resize(totals[i].times_ms.size());
      for (std::size_t k = 0; k < all.times_ms.size(); ++k)
        all.times_ms[k] += totals[i].times_ms[k];
    }
    totals.push_back(all);
    std::vector<Row> rows;
    double copy_speed = 0;  // of the faster one
    for (const KernelTotal& total : totals) {
      Row row = row_of_times(group_, total.name, total.times_ms);
      const double elements = rows.size() < kCopySpans ? static_cast<double>(copy_.bytes()) / 16
                                                       : elements_of(total.name, mesh_, frame_);
      row.figures = {{"dispatches", static_cast<double>(total.dispatches)},
                     {"indirect_dispatches", static_cast<double>(total.indirect)},
                     {"barriers", static_cast<double>(total.barriers)},
                     {"bytes", static_cast<double>(total.bytes)},
                     {"elements", elements},
                     {"bytes_per_element", static_cast<double>(total.bytes) / elements}};
      // Where the device decides how often a kernel runs, bytes tell nothing of its speed.
      if (row.median_ms > 0 && total.indirect == 0) {
        const double speed = 1e-6 * static_cast<double>(total.bytes) / row.median_ms;
        if (rows.size() < kCopySpans) copy_speed = std::max(copy_speed, speed);
        row.figures.emplace_back("gigabytes_per_second", speed);
        if (rows.size() >= kCopySpans) row.figures.emplace_back("copy_share", speed / copy_speed);
      }
      rows.push_back(row);
    }
    for (Row& row : rows) row.ratio = rows[1].median_ms > 0 ? row.median_ms / rows[1].median_ms : 0;
    return rows;
  }

  VulkanMachine& machine_;
  DeviceCopy& copy_;
  const PolygonMesh& mesh_;
  DeviceFrame frame_;
  Group group_;
};

// A frame's kernels on hardware by what their lanes read and write; each access is logged, so of a
// small mesh; `what`: what mesh that is.
std::vector<Row> count_accesses(const Options& options, InterpolationMethod method,
                                const PolygonMesh& mesh, const std::string& what) {
  AccessLog log(options);
  const DeviceFrame frame(log.machine(), mesh, {.level = kFrameLevel, .method = method});
  std::vector<TracedDispatch> dispatches;
  log.machine().submitter.run([&](VkCommandBuffer commands) {
    DeviceTrace::begin({});
    record_frame(frame, commands);
    dispatches = DeviceTrace::end();
  });
  const std::vector<AccessTotal> totals = log.totals(dispatches.size());
  const std::string size = what + ", " +
                           (method == InterpolationMethod::Fair ? "fair" : "progressive") +
                           ", by accesses of lanes";
  std::vector<std::pair<std::string, AccessTotal>> kernels;
  AccessTotal all;
  for (std::size_t i = 0; i < totals.size(); ++i) {
    const std::string name(kernel_of(log.machine().context, dispatches[i].layout));
    auto found = std::ranges::find(kernels, name, &std::pair<std::string, AccessTotal>::first);
    if (found == kernels.end()) found = kernels.insert(found, {name, {}});
    found->second += totals[i];
    all += totals[i];
  }
  kernels.emplace_back("frame", all);
  std::vector<Row> rows;
  for (const auto& [name, total] : kernels) {
    Row& row = rows.emplace_back(Row{.group = "kernels", .size = size, .peer = name});
    const double elements = elements_of(name, mesh, frame);
    row.figures = {{"elements", elements},
                   {"read_per_element", static_cast<double>(total.read_bytes) / elements},
                   {"written_per_element", static_cast<double>(total.written_bytes) / elements},
                   {"transactions_per_element", static_cast<double>(total.transactions) / elements},
                   {"longest_walk", static_cast<double>(total.longest_walk)}};
  }
  return rows;
}

}  // namespace

std::vector<Row> bench_kernels(const Options& options) {
  const auto machine = traced_machine(options);
  if (!machine) return {};
  const bool is_software = machine->device.capabilities().kind == "software";
  DeviceCopy copy(*machine, is_software ? std::min(options.copy_bytes, kSoftwareCopyBytes)
                                        : options.copy_bytes);
  std::vector<Row> rows;
  for (const std::int32_t point_count : options.point_counts) {
    const PolygonMesh mesh = rough_torus(point_count);
    for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
      try {
        FrameKernels kernels(*machine, copy, mesh, method);
        const std::vector<Row> measured = kernels.measure(options.repetitions);
        rows.insert(rows.end(), measured.begin(), measured.end());
      } catch (const Error& error) {
        const bool is_fair = method == InterpolationMethod::Fair;
        rows.push_back(refusal(error, "kernels", formatted("{} points", mesh.vertex_count()),
                               is_fair ? "fair" : "progressive"));
      }
    }
  }
  const auto count = [&](InterpolationMethod method, const PolygonMesh& mesh,
                         const std::string& what) {
    const std::vector<Row> counted = count_accesses(options, method, mesh, what);
    rows.insert(rows.end(), counted.begin(), counted.end());
  };
  const PolygonMesh torus = rough_torus(std::min(kCountedPoints, options.point_counts.front()));
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair})
    count(method, torus, formatted("{} points", torus.vertex_count()));
  count(InterpolationMethod::Fair, uneven_bipyramid(kCountedHub),
        formatted("hubs of {}", kCountedHub));
  return rows;
}

}  // namespace planish::bench
