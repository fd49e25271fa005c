// A host that traces rays against planish's vertices: an acceleration structure built once and
// refit each frame, as the triangles stay the same.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "generated/rays.comp.spv.h"
#include "planish/osd/vk_vertex_buffer.h"
#include "planish/queries/surface_queries.h"
#include "support/random_meshes.h"
#include "viewer/device.h"
#include "viewer/fixture.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace viewer;
using vulkan::MemoryUse;

constexpr vulkan::Scope kBuild{VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                               VK_ACCESS_SHADER_READ_BIT |
                                   VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                                   VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR};
constexpr vulkan::Scope kTrace{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                               VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT |
                                   VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR};
constexpr VkBufferUsageFlags kFurtherUsage =
    VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
    VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
    VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

template <class Function>
Function extension_function(VkDevice device, const char* name) {
  return reinterpret_cast<Function>(vkGetDeviceProcAddr(device, name));
}
#define PLANISH_CALL(device, name) extension_function<PFN_##name>(device, #name)

VkDeviceAddress address_of(VkDevice device, VkBuffer buffer) {
  VkBufferDeviceAddressInfo info{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  info.buffer = buffer;
  return PLANISH_CALL(device, vkGetBufferDeviceAddressKHR)(device, &info);
}

/// An acceleration structure of one geometry, in buffers that the Context makes.
class Structure {
 public:
  Structure(VkDevice device, vulkan::Context& context,
            const VkAccelerationStructureGeometryKHR& geometry, std::uint32_t count)
      : device_(device), geometry_(geometry), range_{count, 0, 0, 0} {
    info_.type = geometry.geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR
                     ? VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR
                     : VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    info_.flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    info_.geometryCount = 1;
    info_.pGeometries = &geometry_;
    VkAccelerationStructureBuildSizesInfoKHR sizes{
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    PLANISH_CALL(device, vkGetAccelerationStructureBuildSizesKHR)
    (device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info_, &count, &sizes);
    memory_ = vulkan::Buffer(context, sizes.accelerationStructureSize, MemoryUse::Device);
    constexpr VkDeviceSize kScratchStep = 256;  // that devices want at most
    scratch_ = vulkan::Buffer(
        context, std::max(sizes.buildScratchSize, sizes.updateScratchSize) + kScratchStep,
        MemoryUse::Device);
    info_.scratchData.deviceAddress =
        (address_of(device, scratch_.handle()) + kScratchStep - 1) / kScratchStep * kScratchStep;
    VkAccelerationStructureCreateInfoKHR create{
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
    create.buffer = memory_.handle();
    create.size = sizes.accelerationStructureSize;
    create.type = info_.type;
    vulkan::check(
        PLANISH_CALL(device, vkCreateAccelerationStructureKHR)(device, &create, nullptr, &handle_),
        "vkCreateAccelerationStructureKHR");
    info_.dstAccelerationStructure = handle_;
  }
  ~Structure() {
    PLANISH_CALL(device_, vkDestroyAccelerationStructureKHR)(device_, handle_, nullptr);
  }
  Structure(const Structure&) = delete;
  Structure& operator=(const Structure&) = delete;

  /// The first time builds, later ones refit.
  void record(VkCommandBuffer commands) {
    const VkAccelerationStructureBuildRangeInfoKHR* ranges = &range_;
    PLANISH_CALL(device_, vkCmdBuildAccelerationStructuresKHR)(commands, 1, &info_, &ranges);
    info_.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    info_.srcAccelerationStructure = handle_;
  }
  [[nodiscard]] const VkAccelerationStructureKHR& handle() const { return handle_; }
  [[nodiscard]] VkDeviceAddress address() const {
    VkAccelerationStructureDeviceAddressInfoKHR info{
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
    info.accelerationStructure = handle_;
    return PLANISH_CALL(device_, vkGetAccelerationStructureDeviceAddressKHR)(device_, &info);
  }

 private:
  VkDevice device_;
  VkAccelerationStructureGeometryKHR geometry_;
  VkAccelerationStructureBuildRangeInfoKHR range_;
  VkAccelerationStructureBuildGeometryInfoKHR info_{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
  vulkan::Buffer memory_, scratch_;
  VkAccelerationStructureKHR handle_ = VK_NULL_HANDLE;
};

VkAccelerationStructureGeometryKHR triangles_of(VkDeviceAddress vertices, std::uint32_t count,
                                                VkDeviceAddress indices) {
  VkAccelerationStructureGeometryKHR geometry{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
  geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
  geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
  auto& triangles = geometry.geometry.triangles;
  triangles = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR};
  triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
  triangles.vertexData.deviceAddress = vertices;
  triangles.vertexStride = vulkan::VertexLayout{}.stride;
  triangles.maxVertex = count - 1;
  triangles.indexType = VK_INDEX_TYPE_UINT32;
  triangles.indexData.deviceAddress = indices;
  return geometry;
}

VkAccelerationStructureGeometryKHR instances_of(VkDeviceAddress instances) {
  VkAccelerationStructureGeometryKHR geometry{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
  geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
  geometry.geometry.instances = {
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR};
  geometry.geometry.instances.data.deviceAddress = instances;
  return geometry;
}

/// rays.comp with its descriptor set.
class Tracer {
 public:
  Tracer(VkDevice device, const VkAccelerationStructureKHR& scene, VkBuffer rays, VkBuffer hits) {
    constexpr VkDescriptorType kTypes[] = {VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR,
                                           VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                           VK_DESCRIPTOR_TYPE_STORAGE_BUFFER};
    VkDescriptorSetLayoutBinding bindings[3];
    VkDescriptorPoolSize sizes[3];
    for (std::uint32_t i = 0; i < 3; ++i) {
      bindings[i] = {i, kTypes[i], 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
      sizes[i] = {kTypes[i], 1};
    }
    VkDescriptorSetLayoutCreateInfo sets{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    sets.bindingCount = 3;
    sets.pBindings = bindings;
    set_layout_ = OwnedSetLayout(device, sets, "vkCreateDescriptorSetLayout");
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = 3;
    pool.pPoolSizes = sizes;
    pool_ = OwnedDescriptorPool(device, pool, "vkCreateDescriptorPool");
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = set_layout_.address();
    vulkan::check(vkAllocateDescriptorSets(device, &allocate, &set_), "vkAllocateDescriptorSets");
    VkWriteDescriptorSetAccelerationStructureKHR structure{
        VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
    structure.accelerationStructureCount = 1;
    structure.pAccelerationStructures = &scene;
    const VkDescriptorBufferInfo buffers[] = {
        {}, {rays, 0, VK_WHOLE_SIZE}, {hits, 0, VK_WHOLE_SIZE}};
    VkWriteDescriptorSet writes[3];
    for (std::uint32_t i = 0; i < 3; ++i) {
      writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
      writes[i].dstSet = set_;
      writes[i].dstBinding = i;
      writes[i].descriptorCount = 1;
      writes[i].descriptorType = kTypes[i];
      writes[i].pBufferInfo = &buffers[i];
    }
    writes[0].pNext = &structure;
    vkUpdateDescriptorSets(device, 3, writes, 0, nullptr);
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = set_layout_.address();
    layout_ = OwnedPipelineLayout(device, layout, "vkCreatePipelineLayout");
    VkShaderModuleCreateInfo code{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    code.codeSize = sizeof spirv::rays_comp;
    code.pCode = spirv::rays_comp;
    const OwnedShader shader(device, code, "vkCreateShaderModule");
    VkComputePipelineCreateInfo pipeline{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    pipeline.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    pipeline.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    pipeline.stage.module = shader;
    pipeline.stage.pName = "main";
    pipeline.layout = layout_;
    pipeline_ = OwnedComputePipeline(device, pipeline, "vkCreateComputePipelines");
  }

  void record(VkCommandBuffer commands, std::uint32_t count) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0,
                            nullptr);
    vkCmdDispatch(commands, (count + 63) / 64, 1, 1);
  }

 private:
  OwnedSetLayout set_layout_;
  OwnedDescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  OwnedPipelineLayout layout_;
  OwnedComputePipeline pipeline_;
};

class RayTracing : public ViewerTest {
 protected:
  void require(const std::vector<const char*>& extensions) {
    for (const char* extension : extensions)
      if (!has_extension(extension)) GTEST_SKIP() << device_->name() << " lacks " << extension;
    addresses_.bufferDeviceAddress = VK_TRUE;
    structures_.accelerationStructure = VK_TRUE;
    queries_.rayQuery = VK_TRUE;
    structures_.pNext = &queries_;
    if (extensions.size() > 1) addresses_.pNext = &structures_;
    remake_device(extensions, &addresses_);
  }

  VkPhysicalDeviceBufferDeviceAddressFeatures addresses_{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES};
  VkPhysicalDeviceAccelerationStructureFeaturesKHR structures_{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
  VkPhysicalDeviceRayQueryFeaturesKHR queries_{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};
};

// The validation layer speaks where the buffer or its memory was not made for it.
TEST_F(RayTracing, BuffersOfAContextHaveAddressesWhereTheHostWantsThem) {
  require({VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME});
  if (IsSkipped()) return;
  vulkan::Context context(device_->host(),
                          {.further_usage = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT});
  osd::VkDeviceContext target(context, device_->queue(), device_->family());
  // One that shares its memory and one that does not.
  for (const int count : {10, 1 << 18}) {
    const std::unique_ptr<osd::VkVertexBuffer> buffer(
        osd::VkVertexBuffer::Create(3, count, &target));
    EXPECT_NE(address_of(*device_, buffer->BindVBO()), 0u);
  }
}

/// From around a torus towards the circle within it.
std::vector<SurfaceRay> rays_at_torus(double radius, int count) {
  std::vector<SurfaceRay> rays;
  for (int i = 0; i < count; ++i) {
    const double around = 2 * std::numbers::pi * i / count, up = 0.37 * i;
    const glm::dvec3 out(std::cos(around), std::sin(around), 0);
    SurfaceRay& ray = rays.emplace_back();
    ray.origin = (radius + 3 * std::cos(up)) * out + glm::dvec3(0, 0, 3 * std::sin(up));
    ray.direction = glm::normalize(radius * out - ray.origin);
    ray.origin = glm::vec3(ray.origin);
    ray.direction = glm::vec3(ray.direction);
  }
  return rays;
}

TEST_F(RayTracing, RaysMeetWhatSurfaceQueriesMeetAfterRefits) {
  require({VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME,
           VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
           VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
           VK_EXT_DESCRIPTOR_INDEXING_EXTENSION_NAME, VK_KHR_RAY_QUERY_EXTENSION_NAME,
           VK_KHR_SPIRV_1_4_EXTENSION_NAME, VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME});
  if (IsSkipped()) return;
  const VkDevice device = *device_;
  vulkan::Context context(device_->host(), {.further_usage = kFurtherUsage});
  constexpr double kRadius = 2;
  PolygonMesh mesh = in_floats(test::torus(16, 12, kRadius, 0.7));
  const vulkan::System system(mesh, {.level = 4});
  vulkan::DeviceSystem tables(context, system);
  const auto vertex_count = static_cast<std::uint32_t>(tables.vertex_count());
  vulkan::Buffer staging(context, tables.upload_bytes(), MemoryUse::Upload),
      points(context, mesh.positions.size() * sizeof(glm::vec3), MemoryUse::Upload),
      vertices(context, vertex_count * vulkan::VertexLayout{}.stride, MemoryUse::Device),
      indices(context, tables.index_count() * sizeof(std::uint32_t), MemoryUse::Device);
  tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
  staging.flush();
  vulkan::Solve solve(context, tables,
                      {.given = {points.handle()}, .vertices = {.buffer = vertices.handle()}});

  Structure bottom(device, context,
                   triangles_of(address_of(device, vertices.handle()), vertex_count,
                                address_of(device, indices.handle())),
                   tables.index_count() / 3);
  vulkan::Buffer instances(context, sizeof(VkAccelerationStructureInstanceKHR), MemoryUse::Upload);
  VkAccelerationStructureInstanceKHR instance{};
  for (int i = 0; i < 3; ++i) instance.transform.matrix[i][i] = 1;
  instance.mask = 0xff;
  instance.accelerationStructureReference = bottom.address();
  std::memcpy(instances.mapped().data(), &instance, sizeof instance);
  instances.flush();
  Structure top(device, context, instances_of(address_of(device, instances.handle())), 1);

  const std::vector<SurfaceRay> rays = rays_at_torus(kRadius, 1000);
  std::vector<glm::vec4> packed;
  for (const SurfaceRay& ray : rays) {
    packed.emplace_back(ray.origin, 0);
    packed.emplace_back(ray.direction, 0);
  }
  const auto ray_words =
      std::span(reinterpret_cast<const std::uint32_t*>(packed.data()), packed.size() * 4);
  const Buffer ray_buffer = word_buffer(*device_, ray_words);
  const Buffer hits(*device_, rays.size() * sizeof(float), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                    Place::Host);
  const Tracer tracer(*device_, top.handle(), ray_buffer, hits);

  for (int frame = 0; frame < 3; ++frame) {
    SCOPED_TRACE(frame);
    for (glm::dvec3& p : mesh.positions) p = glm::vec3(p * (1 + 0.02 * frame));
    const std::vector<glm::vec3> moved(mesh.positions.begin(), mesh.positions.end());
    std::memcpy(points.mapped().data(), moved.data(), points.size());
    points.flush();
    device_->run([&](VkCommandBuffer commands) {
      if (frame == 0) tables.record_upload(commands, staging.handle(), 0, {indices.handle()});
      solve.record_solve(commands, {.iterations = 0});  // the mesh is its own cage
      solve.record_evaluate(commands);
      barrier(commands, vulkan::kExitScope, kBuild);
      bottom.record(commands);
      barrier(commands, kBuild, kBuild);
      top.record(commands);
      barrier(commands, kBuild, kTrace);
      tracer.record(commands, static_cast<std::uint32_t>(rays.size()));
      barrier(commands, kTrace, vulkan::kHostReadScope);
      // The next frame writes the vertices.
      barrier(commands, kBuild, vulkan::kEntryScope);
    });
    const PlaceOracle oracle(mesh, Weights::DooSabin);
    const SurfaceQueries queries(oracle.limit);
    const auto* const found = reinterpret_cast<const float*>(hits.mapped().data());
    double largest = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto hit = queries.first_hit(rays[i]);
      ASSERT_TRUE(hit) << i;
      largest = std::max(largest, std::abs(hit->t - double(found[i])));
    }
    // Triangles of level 4 are as near.
    EXPECT_LT(largest, 5e-4);
    RecordProperty("frame" + std::to_string(frame), std::to_string(largest));
  }
}

}  // namespace
}  // namespace planish::testing
