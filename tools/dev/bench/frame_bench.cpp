#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "bench/benchmarks.h"
#include "bench/traced_device.h"
#include "planish/core/error.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/vulkan_backend.h"

namespace planish::bench {

using namespace vulkan;

namespace {

// What a frame of a host costs: points that move, a solve from where the last one ended, vertices.

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

namespace {

// Many small meshes in one command buffer against one large mesh.

constexpr std::int32_t kMeshes = 64;
constexpr SolveParameters kSteps{.iterations = 16, .measures_last = true};
constexpr std::uint32_t kBytesOfVertex = 24;

// Instances of one mesh, each with points and vertices of its own: Solves of `each` instances.
struct Instances {
  Instances(VulkanMachine& machine, const PolygonMesh& mesh, std::int32_t count,
            std::int32_t each = 1)
      : system(mesh, {.level = 1}), device(machine.context, system) {
    Buffer staging(machine.context, device.upload_bytes(), MemoryUse::Upload);
    device.write_upload(system, staging.mapped().first(device.upload_bytes()));
    staging.flush();
    machine.submitter.run(
        [&](VkCommandBuffer commands) { device.record_upload(commands, staging.handle(), 0); });
    std::vector<glm::vec3> rounded;
    for (std::int32_t i = 0; i < each; ++i)
      rounded.insert(rounded.end(), mesh.positions.begin(), mesh.positions.end());
    for (std::int32_t i = 0; i < count; ++i) {
      const Buffer& given = points.emplace_back(machine.context, rounded.size() * sizeof(glm::vec3),
                                                MemoryUse::Device);
      machine.submitter.upload(whole(given), std::as_bytes(std::span(rounded)));
      const Buffer& target = vertices.emplace_back(
          machine.context, std::uint64_t(each) * system.vertex_count() * kBytesOfVertex,
          MemoryUse::Device);
      solves.push_back(std::make_unique<vulkan::Solve>(
          machine.context, device,
          SolveOptions{.given = {given.handle()},
                       .vertices = {target.handle()},
                       .instances = static_cast<std::uint32_t>(each)}));
      solve_calls.push_back({solves.back().get(), kSteps});
      evaluate_calls.push_back({solves.back().get(), {}});
    }
  }

  System system;
  DeviceSystem device;
  std::vector<Buffer> points, vertices;
  std::vector<std::unique_ptr<vulkan::Solve>> solves;
  std::vector<SolveCall> solve_calls;
  std::vector<EvaluateCall> evaluate_calls;
};

// `count` of the mesh side by side, as one.
PolygonMesh side_by_side(const PolygonMesh& mesh, std::int32_t count) {
  std::vector<PolygonMesh> meshes(static_cast<std::size_t>(count), mesh);
  for (std::int32_t i = 0; i < count; ++i)
    for (glm::dvec3& p : meshes[i].positions) p.x += 3 * i;
  return merged_meshes(meshes).mesh;
}

void add_peers(Group& group, const std::string& name, VulkanMachine& machine,
               const std::shared_ptr<Instances>& instances) {
  const auto add = [&](const std::string& what, auto record) {
    group.peers.push_back({what, [&machine, instances, record] {
                             machine.submitter.run(
                                 [&](VkCommandBuffer commands) { record(commands, *instances); });
                           }});
  };
  add("solve-" + name, [](VkCommandBuffer commands, const Instances& all) {
    record_solves(commands, all.solve_calls);
  });
  add("evaluate-" + name, [](VkCommandBuffer commands, const Instances& all) {
    record_evaluates(commands, all.evaluate_calls);
  });
  if (instances->solves.size() == 1) return;
  add("solve-" + name + "-apart", [](VkCommandBuffer commands, const Instances& all) {
    for (const SolveCall& call : all.solve_calls)
      call.solve->record_solve(commands, call.parameters);
  });
}

}  // namespace

std::vector<Row> bench_many(const Options& options) {
  if (list_vulkan_devices().best < 0) return {};
  VulkanMachine machine({.wanted = options.device}, {});
  // 128,000 points by default, as many as the small ones together.
  // Tori of 4 x 4 quads at least.
  const std::int32_t large = std::max(options.quad_count * 16 / 125, 16 * kMeshes);
  const auto one = std::make_shared<Instances>(machine, torus_grid(large), 1);
  const PolygonMesh small = torus_grid(large / kMeshes);
  const auto many = std::make_shared<Instances>(machine, small, kMeshes);
  const auto instances = std::make_shared<Instances>(machine, small, 1, kMeshes);
  // One System whose mesh has as many components.
  const auto merged = std::make_shared<Instances>(machine, side_by_side(small, kMeshes), 1);
  // So small that what a dispatch costs is all.
  const auto tiny = std::make_shared<Instances>(machine, torus_grid(16), kMeshes);

  Group group;
  group.name = "many";
  const auto points = [](const Instances& all) {
    return formatted("{} of {}", all.solves.size(), all.system.given_count());
  };
  group.size = formatted("{} points, {}, {}; {} steps; vulkan on {}", points(*one), points(*many),
                         points(*tiny), kSteps.iterations, machine.device.capabilities().name);
  group.baseline = "solve-one";
  add_peers(group, "one", machine, one);
  add_peers(group, "merged", machine, merged);
  add_peers(group, "instances", machine, instances);
  add_peers(group, "many", machine, many);
  add_peers(group, "tiny", machine, tiny);
  return run_group(group, options.repetitions);
}

namespace {

// A host of one mesh. Each run moves the listed vertices there, the next one back.
class DeviceEdits {
 public:
  DeviceEdits(VulkanMachine& machine, const PolygonMesh& mesh)
      : machine_(machine),
        rest_(mesh.positions.begin(), mesh.positions.end()),
        system_(mesh),
        tables_(machine.context, system_, {.max_vertex_stride = 24, .takes_edits = true}),
        points_(machine.context, rest_.size() * sizeof(glm::vec3), MemoryUse::Upload),
        vertices_(machine.context, std::uint64_t(tables_.vertex_count()) * 24, MemoryUse::Device),
        moves_(machine.context, (rest_.size() + 1) * sizeof(std::uint32_t), MemoryUse::Upload),
        report_(machine.context, sizeof(GpuStatus) + sizeof(EditReach), MemoryUse::Download),
        solve_(machine.context, tables_,
               {.given = {points_.handle()},
                .vertices = {vertices_.handle()},
                .moved = {moves_.handle(), 0, static_cast<std::uint32_t>(rest_.size())}}),
        stop_error_(static_cast<float>(system_.tolerance() / 8)) {
    Buffer staging(machine.context, tables_.upload_bytes(), MemoryUse::Upload);
    tables_.write_upload(system_, staging.mapped().first(tables_.upload_bytes()));
    staging.flush();
    machine.submitter.run(
        [&](VkCommandBuffer commands) { tables_.record_upload(commands, staging.handle(), 0); });
    std::memcpy(points_.mapped().data(), rest_.data(), rest_.size() * sizeof(glm::vec3));
    points_.flush();
    solve_all(false);
  }

  void list(std::vector<std::int32_t> vertices) { listed_ = std::move(vertices); }
  void edit() {
    move_listed();
    const auto count = static_cast<std::uint32_t>(listed_.size());
    std::memcpy(moves_.mapped().data(), &count, sizeof count);
    std::memcpy(moves_.mapped().data() + sizeof count, listed_.data(),
                listed_.size() * sizeof count);
    moves_.flush();
    machine_.submitter.run([&](VkCommandBuffer commands) {
      solve_.record_edit(commands, {.iterations = 32, .stop_error = stop_error_});
      report(commands);
    });
    require_solved();
  }
  void whole() {
    move_listed();
    solve_all(true);
  }

  [[nodiscard]] GpuStatus status() { return report_at<GpuStatus>(0); }
  [[nodiscard]] EditReach reach() { return report_at<EditReach>(sizeof(GpuStatus)); }

 private:
  void solve_all(bool warm) {
    machine_.submitter.run([&](VkCommandBuffer commands) {
      solve_.record_solve(commands,
                          {.iterations = 60, .stop_error = stop_error_, .warm_start = warm});
      solve_.record_evaluate(commands);
      report(commands);
    });
    require_solved();
  }
  void report(VkCommandBuffer commands) const {
    solve_.record_status(commands, report_.handle(), 0);
    solve_.record_reach(commands, report_.handle(), sizeof(GpuStatus));
  }
  void move_listed() {
    is_there_ = !is_there_;
    const double way = is_there_ ? kWayOfEdit * system_.diagonal() : 0;
    for (const std::int32_t v : listed_) {
      const glm::vec3 to = rest_[v] + glm::vec3(way_of(v, way));
      std::memcpy(points_.mapped().data() + v * sizeof to, &to, sizeof to);
    }
    points_.flush();
  }
  void require_solved() {
    if (status().state != SolveState::Converged)
      throw std::runtime_error("an edit on the device leaves an error of " +
                               std::to_string(status().residual));
  }
  template <class T>
  T report_at(std::size_t offset) {
    report_.invalidate();
    T result;
    std::memcpy(&result, report_.mapped().data() + offset, sizeof result);
    return result;
  }

  VulkanMachine& machine_;
  std::vector<glm::vec3> rest_;
  System system_;
  DeviceSystem tables_;
  Buffer points_, vertices_, moves_, report_;
  vulkan::Solve solve_;
  float stop_error_;
  std::vector<std::int32_t> listed_;
  bool is_there_ = false;
};

}  // namespace

std::vector<Row> bench_device_edits(const Options& options, const PolygonMesh& mesh,
                                    const std::string& size) {
  if (list_vulkan_devices().best < 0) return {};
  VulkanMachine machine({.wanted = options.device}, {});
  Group group{
      "edit", size + "; vulkan on " + machine.device.capabilities().name, "vulkan-whole", {}};
  std::unique_ptr<DeviceEdits> host;
  try {
    host = std::make_unique<DeviceEdits>(machine, mesh);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::OutOfMemory) throw;
    Row row;
    row.group = group.name, row.size = group.size, row.peer = "vulkan-one";
    row.refused = error.what();
    return {row};
  }
  const std::int32_t middle = mesh.vertex_count() / 2;
  std::map<std::string, std::vector<std::pair<std::string, double>>> figures;
  const auto add = [&](const std::string& peer, std::vector<std::int32_t> vertices) {
    group.peers.push_back({peer, [&, peer, vertices] {
                             host->list(vertices);
                             host->edit();
                             const EditReach reach = host->reach();
                             figures[peer] = {{"points_per_move", double(reach.points)},
                                              {"patches_per_move", double(reach.patches)},
                                              {"iterations", double(host->status().iterations)}};
                           }});
  };
  group.peers.push_back({"vulkan-whole", [&] {
                           host->list({middle});
                           host->whole();
                         }});
  add("vulkan-none", {});
  add("vulkan-one", {middle});
  add("vulkan-near-1000", near_vertices(mesh, middle));
  add("vulkan-scattered-1000", scattered_vertices(mesh));
  std::vector<Row> rows = run_group(group, options.repetitions);
  for (Row& row : rows) row.figures = figures[row.peer];
  return rows;
}

}  // namespace planish::bench
