#include "frame.h"
#include "planish/core/formatted.h"

#include <cstring>
#include <string>

namespace planish::viewer {
namespace {

OwnedDescriptorPool make_pool(VkDevice device) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                  shared::kBindingCount + shared::kSurfaceBindingCount};
  VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  info.maxSets = 2;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  return OwnedDescriptorPool(device, info, "vkCreateDescriptorPool");
}

/// planish cuts what is beyond the limit; the viewer binds its vertices whole.
std::uint64_t vertex_bytes(vulkan::Context& context, const Model& model) {
  const std::uint64_t bytes =
      std::uint64_t(model.system().vertex_count()) * shared::kVertexFloats * sizeof(float);
  context.binding_limit().require(bytes, formatted("vertices of level {}", model.system().level()),
                                  "choose a lower level");
  return bytes;
}

}  // namespace

Frame::Frame(const Device& device, vulkan::Context& context, const Model& model)
    : points_(device, model.system().given_count() * sizeof(glm::vec3),
              VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Place::Host),
      vertices_(device, vertex_bytes(context, model),
                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
                    VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                Place::Device),
      status_(device, sizeof(vulkan::GpuStatus), VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Host),
      pool_(make_pool(device)) {}

vulkan::FrameSlot Frame::slot() const {
  constexpr std::uint32_t kFloat = sizeof(float);
  return {
      .given = {points_, 0, sizeof(glm::vec3)},
      .vertices = {vertices_, 0, shared::kVertexFloats * kFloat, 0, shared::kNormalFloat * kFloat}};
}

void Frame::bind(VkDevice device, const Model& model, const Pipelines& pipelines,
                 const vulkan::Solve& solve) {
  // In the order of the bindings in shared.h.
  const std::array<VkBuffer, shared::kBindingCount> buffers{
      points_,       solve.control_points(), vertices_,      model.used(),
      model.edges(), model.offsets(),        model.nearest()};
  std::array<VkDescriptorBufferInfo, shared::kBindingCount> infos{};
  for (std::size_t i = 0; i < buffers.size(); ++i) infos[i] = {buffers[i], 0, VK_WHOLE_SIZE};
  set_ = make_set(device, pool_, pipelines.set_layout, infos);
  if (!pipelines.patches) return;
  const vulkan::SurfaceBuffers surface = vulkan::surface_buffers(model.tables(), solve);
  surface_set_ = make_set(
      device, pool_, pipelines.surface_layout,
      std::array{surface.words, surface.links, surface.state, surface.given, surface.weights});
}

std::span<glm::vec3> Frame::points() const {
  const auto bytes = points_.mapped();
  return {reinterpret_cast<glm::vec3*>(bytes.data()), bytes.size() / sizeof(glm::vec3)};
}

vulkan::GpuStatus Frame::status() const {
  vulkan::GpuStatus status;
  std::memcpy(&status, status_.mapped().data(), sizeof status);
  return status;
}

}  // namespace planish::viewer
