#include "bench/device_edit.h"

#include <cstring>
#include <map>
#include <memory>
#include <stdexcept>

#include "bench/edit_moves.h"
#include "planish/core/error.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/vulkan_backend.h"

namespace planish::bench {

namespace {

using namespace vulkan;

/// A host of one mesh. Each run moves the listed vertices there, the next one back.
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
