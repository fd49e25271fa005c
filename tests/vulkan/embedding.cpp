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
  FitOptions fitting;
  fitting.method = options.method;
  fitting.weights = options.weights;
  fitting.sharp = options.sharp;
  fitting.fair_decisions = options.fair_decisions;
  fitting.tolerance = 1e-12;
  EvaluateOptions evaluation;
  evaluation.level = options.level;
  evaluation.weights = options.weights;
  evaluation.sharp = options.sharp;
  evaluation.rest_positions = rest.positions;
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

HostTopology::HostTopology(Context& context, const PolygonMesh& rest, const SystemOptions& options,
                           std::uint32_t max_vertex_stride)
    : system(rest, options),
      device(context, system, {max_vertex_stride}),
      indices(context, device.index_count() * sizeof(std::uint32_t), MemoryUse::Download),
      staging(context, device.upload_bytes(), MemoryUse::Upload) {
  device.write_upload(system, staging.mapped().first(device.upload_bytes()));
  staging.flush();
}

void HostTopology::upload(Submitter& submitter) {
  submitter.run([&](VkCommandBuffer commands) {
    device.record_upload(commands, staging.handle(), 0, {indices.handle(), 0});
  });
  indices.invalidate();
}

namespace {

SolveOptions options_of(const HostFrame& frame, std::uint32_t max_iterations,
                        std::uint32_t instances) {
  SolveOptions options;
  options.max_iterations = max_iterations;
  options.given = {frame.points.handle(), 0, sizeof(glm::vec3)};
  options.vertices = {frame.output.handle(),      frame.layout.offset,
                      frame.layout.stride,        frame.layout.position_offset,
                      frame.layout.normal_offset, frame.instance_stride()};
  options.instances = instances;
  return options;
}

}  // namespace

HostFrame::HostFrame(Context& context, const HostTopology& topology, const Layout& wanted,
                     std::uint32_t max_iterations, std::uint32_t instances)
    : vertex_count(topology.system.vertex_count()),
      layout(wanted),
      points(context, instances * topology.system.given_count() * sizeof(glm::vec3),
             MemoryUse::Upload),
      output(context, wanted.offset + instances * instance_stride(), MemoryUse::Download),
      report(context, instances * sizeof(GpuStatus), MemoryUse::Download),
      solve(context, topology.device, options_of(*this, max_iterations, instances)) {}

std::uint64_t HostFrame::instance_stride() const {
  return std::uint64_t(vertex_count) * layout.stride + layout.gap;
}

void HostFrame::set_points(const PolygonMesh& pose, std::uint32_t instance) {
  std::vector<glm::vec3> rounded(pose.positions.begin(), pose.positions.end());
  const std::size_t bytes = rounded.size() * sizeof(glm::vec3);
  std::memcpy(points.mapped().data() + instance * bytes, rounded.data(), bytes);
  points.flush();
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
  report.invalidate();
  GpuStatus result;
  std::memcpy(&result, report.mapped().data() + instance * sizeof result, sizeof result);
  return result;
}

void HostFrame::record(VkCommandBuffer commands, const SolveParameters& parameters) const {
  solve.record_solve(commands, parameters);
  solve.record_evaluate(commands);
  solve.record_status(commands, report.handle(), 0);
}

HostCommands::HostCommands(const OwnDevice& device, VkCommandBufferLevel level)
    : host_(device.host_device()),
      vk_(DeviceFunctions::load(
          InstanceFunctions::load(host_.get_instance_proc, host_.instance).vkGetDeviceProcAddr,
          host_.device)),
      queue_(device.queue()),
      level_(level) {
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.queueFamilyIndex = device.capabilities().compute_family;
  check(vk_.vkCreateCommandPool(host_.device, &pool, nullptr, &pool_), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.level = level;
  allocate.commandBufferCount = 1;
  check(vk_.vkAllocateCommandBuffers(host_.device, &allocate, &commands_),
        "vkAllocateCommandBuffers");
  const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  check(vk_.vkCreateFence(host_.device, &fence, nullptr, &fence_), "vkCreateFence");
}

HostCommands::~HostCommands() {
  vk_.vkDestroyFence(host_.device, fence_, nullptr);
  vk_.vkDestroyCommandPool(host_.device, pool_, nullptr);
}

void HostCommands::record(const std::function<void(VkCommandBuffer)>& work) {
  check(vk_.vkResetCommandPool(host_.device, pool_, 0), "vkResetCommandPool");
  const VkCommandBufferInheritanceInfo inheritance{
      VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO};
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  if (level_ == VK_COMMAND_BUFFER_LEVEL_SECONDARY) begin.pInheritanceInfo = &inheritance;
  check(vk_.vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer");
  work(commands_);
  // The host reads what planish wrote.
  VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  barrier.srcAccessMask = kExitScope.accesses;
  barrier.dstAccessMask = kHostReadScope.accesses;
  vk_.vkCmdPipelineBarrier(commands_, kExitScope.stages, kHostReadScope.stages, 0, 1, &barrier, 0,
                           nullptr, 0, nullptr);
  check(vk_.vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
}

void HostCommands::submit() {
  check(vk_.vkResetFences(host_.device, 1, &fence_), "vkResetFences");
  VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands_;
  check(vk_.vkQueueSubmit(queue_, 1, &info, fence_), "vkQueueSubmit");
}

void HostCommands::wait() {
  check(vk_.vkWaitForFences(host_.device, 1, &fence_, VK_TRUE, UINT64_MAX), "vkWaitForFences");
}

}  // namespace planish::testing
