#include "vulkan/embedding.h"

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>

#include "planish/fair/fair_net.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "vulkan/pretended_driver.h"

namespace planish::testing {

using namespace vulkan;

PolygonMesh posed(const PolygonMesh& rest, int frame) {
  PolygonMesh mesh = rest;
  for (glm::dvec3& p : mesh.positions) {
    const double phase = 0.3 * frame + 1.1 * p.x - 0.7 * p.z;
    p += 0.1 * glm::dvec3(std::sin(phase), std::cos(1.3 * phase), std::sin(0.7 * phase + p.y));
  }
  return mesh;
}

PolygonMesh without_holes(PolygonMesh mesh) {
  mesh.hole_faces.clear();
  return mesh;
}

// Those that embedding makes: without a look at the finished surface, as fit() has one.
static FairDecisions decisions_of(const PolygonMesh& pose, const PolygonMesh& rest,
                                  const SystemOptions& options) {
  const PolygonMesh mesh = without_unused_vertices(pose).mesh;
  const MeshTopology topology(mesh);
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, options.sharp);
  const Subdivision subdivision(topology, features, Weights::DooSabin);
  const Placement placement = placement_of(without_unused_vertices(rest).mesh);
  std::vector<glm::dvec3> given = mesh.positions;
  for (glm::dvec3& p : given) p = placement.to_unit(p);
  return fair_net(mesh, subdivision, given).decisions;
}

std::vector<Vertex> surface_by_cpu(const PolygonMesh& mesh, const PolygonMesh& rest,
                                   const SystemOptions& options) {
  const auto backend = make_cpu_backend();
  FitOptions fitting{.method = options.method,
                     .weights = options.weights,
                     .tolerance = 1e-12,
                     .fair_decisions = options.fair_decisions,
                     .sharp = options.sharp};
  const EvaluateOptions evaluation{.level = options.level,
                                   .weights = options.weights,
                                   .sharp = options.sharp,
                                   .rest_positions = rest.positions};
  const PolygonMesh whole = without_holes(mesh);
  FairDecisions decisions;
  if (options.method == InterpolationMethod::Fair && !options.fair_decisions) {
    decisions = decisions_of(whole, without_holes(rest), options);
    fitting.fair_decisions = &decisions;
  }
  const SurfaceMesh surface = evaluate(whole, fit(whole, *backend, fitting), *backend, evaluation);
  std::vector<Vertex> vertices(surface.positions.size());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    vertices[i] = {glm::vec3(surface.positions[i]), surface.normals[i]};
  return vertices;
}

Difference difference(const std::vector<Vertex>& a, const std::vector<Vertex>& b) {
  Difference result;
  if (a.size() != b.size()) return {std::numeric_limits<double>::infinity(), -1};
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double distance = glm::distance(a[i].position, b[i].position);
    if (!(distance <= result.distance)) result.distance = distance;
    if (a[i].normal == glm::vec3(0) || b[i].normal == glm::vec3(0)) continue;
    const double cosine = glm::dot(a[i].normal, b[i].normal);
    if (!(cosine >= result.cosine)) result.cosine = cosine;
  }
  return result;
}

void upload_tables(Context& context, Submitter& submitter, const System& system,
                   const DeviceSystem& tables) {
  Buffer staging(context, tables.upload_bytes(), MemoryUse::Upload);
  tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
  staging.flush();
  submitter.run(
      [&](VkCommandBuffer commands) { tables.record_upload(commands, staging.handle(), 0); });
}

HostTopology::HostTopology(Context& context, Submitter& submitter, const PolygonMesh& rest,
                           const SystemOptions& options, const DeviceSystemOptions& tables)
    : system(rest, options),
      device(context, system, tables),
      indices(context, device.index_count() * sizeof(std::uint32_t), MemoryUse::Download),
      staging(context, device.upload_bytes(), MemoryUse::Upload) {
  device.write_upload(system, staging.mapped().first(device.upload_bytes()));
  staging.flush();
  submitter.run([&](VkCommandBuffer commands) {
    device.record_upload(commands, staging.handle(), 0, {indices.handle(), 0});
  });
  indices.invalidate();
}

namespace {

VertexLayout vertices_of(const HostFrame& frame) {
  const Layout& layout = frame.layout;
  return {.buffer = frame.output.handle(),
          .offset = layout.offset,
          .stride = layout.stride,
          .position_offset = layout.position_offset,
          .normal_offset = layout.normal_offset,
          .instance_stride = frame.instance_stride()};
}

}  // namespace

HostFrame::HostFrame(Context& context, const HostTopology& topology, const Layout& wanted,
                     std::uint32_t instance_count, std::uint32_t max_iterations)
    : vertex_count(topology.system.vertex_count()),
      instances(instance_count),
      layout(wanted),
      points(context, instances * topology.system.given_count() * sizeof(glm::vec3),
             MemoryUse::Upload),
      output(context, wanted.offset + instances * instance_stride(), MemoryUse::Download),
      report(context, reach_offset() + sizeof(EditReach), MemoryUse::Download),
      solve(context, topology.device,
            {.max_iterations = max_iterations,
             .given = {points.handle()},
             .vertices = vertices_of(*this),
             .instances = instances}) {}

std::uint64_t HostFrame::instance_stride() const {
  return std::uint64_t(vertex_count) * layout.stride + layout.gap;
}

std::uint64_t HostFrame::reach_offset() const { return instances * sizeof(GpuStatus); }

EditReach HostFrame::reach() { return fetched<EditReach>(report, 1, reach_offset()).front(); }

void HostFrame::set_points(const PolygonMesh& pose, std::uint32_t instance) {
  put(points, points_of(pose), instance * pose.positions.size() * sizeof(glm::vec3));
}

std::vector<Vertex> HostFrame::vertices(std::uint32_t instance) {
  output.invalidate();
  std::vector<Vertex> result(vertex_count);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const std::byte* vertex =
        &output.mapped()[layout.offset + instance * instance_stride() + i * layout.stride];
    std::memcpy(&result[i].position, vertex + layout.position_offset, sizeof(glm::vec3));
    std::memcpy(&result[i].normal, vertex + layout.normal_offset, sizeof(glm::vec3));
  }
  return result;
}

GpuStatus HostFrame::status(std::uint32_t instance) {
  return fetched<GpuStatus>(report, 1, instance * sizeof(GpuStatus)).front();
}

void HostFrame::record(VkCommandBuffer commands, const SolveParameters& parameters) const {
  solve.record_solve(commands, parameters);
  solve.record_evaluate(commands);
  solve.record_status(commands, report.handle(), 0);
}

FramesInFlight::Slot::Slot(Context& context, const OwnDevice& device, const HostTopology& topology,
                           const Layout& layout, std::uint32_t instances, std::uint32_t most_moves)
    : frame(context, topology, layout, instances),
      moves(context, (1 + most_moves) * sizeof(std::uint32_t), MemoryUse::Upload),
      commands(device) {}

FramesInFlight::FramesInFlight(Context& context, const OwnDevice& device,
                               const HostTopology& topology, int count, std::uint32_t instances,
                               std::uint32_t most_moves) {
  constexpr Layout kLayouts[] = {{}, {20, 32, 16, 0}, {64, 40, 4, 24, 12}};
  SolveOptions options{.instances = instances};
  for (int i = 0; i < count; ++i) {
    const Slot& slot =
        slots_.emplace_back(context, device, topology, kLayouts[i % 3], instances, most_moves);
    FrameSlot& of_slot = options.further_slots.emplace_back();
    of_slot = {{slot.frame.points.handle()}, vertices_of(slot.frame), {}};
    if (most_moves > 0) of_slot.moved = {slot.moves.handle(), 0, most_moves};
  }
  options.given = options.further_slots[0].given;
  options.vertices = options.further_slots[0].vertices;
  options.moved = options.further_slots[0].moved;
  options.further_slots.erase(options.further_slots.begin());
  solve_.emplace(context, topology.device, options);
}

FramesInFlight::~FramesInFlight() {
  for (int i = 0; i < static_cast<int>(slots_.size()); ++i) done(i);
}

FramesInFlight::Slot& FramesInFlight::done(int number) {
  Slot& slot = *std::next(slots_.begin(), number % static_cast<int>(slots_.size()));
  if (slot.is_under_way) slot.commands.wait();
  slot.is_under_way = false;
  return slot;
}

void FramesInFlight::submit(int number, const std::function<void(VkCommandBuffer, Slot&)>& record) {
  Slot& slot = done(number);
  slot.commands.record([&](VkCommandBuffer commands) { record(commands, slot); });
  slot.commands.submit();
  slot.is_under_way = true;
}

HostBlocks::HostBlocks(const HostDevice& host, const VkPhysicalDeviceMemoryProperties& memory)
    : device_(host.device),
      memory_(memory),
      vk_(DeviceFunctions::load(
          InstanceFunctions::load(host.get_instance_proc, host.instance).vkGetDeviceProcAddr,
          host.device)) {}

MemoryHooks HostBlocks::hooks() {
  return {[this](const MemoryRequest& request) { return allocate(request); },
          [this](const MemoryBlock& block) { free(block); }};
}

MemoryBlock HostBlocks::allocate(const MemoryRequest& request) {
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = request.requirements.size;
  info.memoryTypeIndex = mapped_type(memory_, request.requirements.memoryTypeBits);
  MemoryBlock block;
  check(vk_.vkAllocateMemory(device_, &info, nullptr, &block.memory), "vkAllocateMemory");
  check(vk_.vkMapMemory(device_, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped), "vkMapMemory");
  ++taken[request.use], ++living, ++made;
  return block;
}

void HostBlocks::free(const MemoryBlock& block) {
  vk_.vkFreeMemory(device_, block.memory, nullptr);
  --living;
}

}  // namespace planish::testing
