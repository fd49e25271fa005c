// The surface as shader code, by bindings of the host's own: positions on shared edges are the same
// bits for all corners that meet there, and all of it is the limit surface.
#include <gtest/gtest.h>

#include <cstring>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "generated/surface_samples.spv.h"
#include "planish/vulkan/host/system.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/places_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;

struct Sample {
  glm::vec3 shared, position, normal;
};

// A host's kernel; all that it has is destroyed with it.
class SampleKernel {
 public:
  SampleKernel(const DeviceFunctions& vk, VkDevice device, const SurfaceBuffers& surface,
               const Buffer& samples)
      : vk_(vk), device_(device) {
    const std::array<VkDescriptorBufferInfo, 6> buffers = {
        surface.links,
        surface.given,
        surface.weights,
        surface.words,
        VkDescriptorBufferInfo{samples.handle(), 0, VK_WHOLE_SIZE},
        surface.state};
    std::array<VkDescriptorSetLayoutBinding, 6> bindings{};
    for (std::uint32_t i = 0; i < bindings.size(); ++i)
      bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set_info.bindingCount = static_cast<std::uint32_t>(bindings.size());
    set_info.pBindings = bindings.data();
    check(vk.vkCreateDescriptorSetLayout(device, &set_info, nullptr, &set_layout_), "set layout");
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 6};
    VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool_info.maxSets = pool_info.poolSizeCount = 1;
    pool_info.pPoolSizes = &size;
    check(vk.vkCreateDescriptorPool(device, &pool_info, nullptr, &pool_), "pool");
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &set_layout_;
    check(vk.vkAllocateDescriptorSets(device, &allocate, &set_), "set");
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set_;
    write.descriptorCount = static_cast<std::uint32_t>(buffers.size());
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = buffers.data();  // goes on from binding to binding
    vk.vkUpdateDescriptorSets(device, 1, &write, 0, nullptr);
    const VkPushConstantRange parameters{VK_SHADER_STAGE_COMPUTE_BIT, 0, 12};
    VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout_info.setLayoutCount = layout_info.pushConstantRangeCount = 1;
    layout_info.pSetLayouts = &set_layout_;
    layout_info.pPushConstantRanges = &parameters;
    check(vk.vkCreatePipelineLayout(device, &layout_info, nullptr, &layout_), "layout");
    VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    module_info.codeSize = sizeof spirv::surface_samples;
    module_info.pCode = spirv::surface_samples;
    check(vk.vkCreateShaderModule(device, &module_info, nullptr, &module_), "module");
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module_;
    info.stage.pName = "main";
    info.layout = layout_;
    check(vk.vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_),
          "pipeline");
  }
  ~SampleKernel() {
    vk_.vkDestroyPipeline(device_, pipeline_, nullptr);
    vk_.vkDestroyShaderModule(device_, module_, nullptr);
    vk_.vkDestroyPipelineLayout(device_, layout_, nullptr);
    vk_.vkDestroyDescriptorPool(device_, pool_, nullptr);
    vk_.vkDestroyDescriptorSetLayout(device_, set_layout_, nullptr);
  }
  SampleKernel(const SampleKernel&) = delete;
  SampleKernel& operator=(const SampleKernel&) = delete;

  void record(VkCommandBuffer commands, const SurfaceBuffers& surface, std::uint32_t side) const {
    const std::uint32_t parameters[] = {surface.face_count, surface.corner_count, side};
    const std::uint32_t count = surface.corner_count * (side + 1) * (side + 1);
    vk_.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
    vk_.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0,
                                nullptr);
    vk_.vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, 12, parameters);
    vk_.vkCmdDispatch(commands, (count + 63) / 64, 1, 1);
  }

 private:
  const DeviceFunctions& vk_;
  VkDevice device_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkShaderModule module_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

class SurfaceCode : public PlacesOnDevice {
 protected:
  // The mesh itself is the cage.
  std::vector<Sample> samples_of(Case& on, std::uint32_t side) {
    const SurfaceBuffers surface = surface_buffers(on.tables, on.solve);
    std::vector<Sample> samples(std::size_t(surface.corner_count) * (side + 1) * (side + 1));
    Buffer target(*context_, samples.size() * sizeof samples[0], MemoryUse::Download);
    const HostCommands commands(*own_);
    const SampleKernel kernel(commands.vk(), own_->host_device().device, surface, target);
    submitter_->run([&](VkCommandBuffer recorded) {
      on.solve.record_solve(recorded, {.iterations = 0});
      on.solve.record_surface(recorded);
      VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
      barrier.srcAccessMask = kExitScope.accesses;
      barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT;
      commands.vk().vkCmdPipelineBarrier(recorded, kExitScope.stages,
                                         VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1, &barrier, 0,
                                         nullptr, 0, nullptr);
      kernel.record(recorded, surface, side);
    });
    target.invalidate();
    std::memcpy(samples.data(), target.mapped().data(), samples.size() * sizeof samples[0]);
    return samples;
  }
};

// By the rows of a tessellation, of which copies across sharp edges have one position.
TEST_F(SurfaceCode, CornersThatMeetHaveTheSameBits) {
  constexpr std::uint32_t kSide = 8;
  std::size_t shared = 0, would_differ = 0;
  for (const PolygonMesh& mesh :
       {in_floats(test::random_closed_mesh(3)), in_floats(test::random_open_mesh(5)),
        in_floats(test::with_random_creases(test::random_closed_mesh(4), 0.15, 2)),
        in_floats(test::with_random_creases(test::random_open_mesh(2), 0.1, 3)),
        in_floats(test::torus(9, 7, 2, 0.7)), in_floats(test::prism(40)),
        in_floats(test::bipyramid(36))}) {
    Case on(*context_, *submitter_, mesh, {.level = 4}, {.list = {.count = 1}});
    const std::vector<Sample> samples = samples_of(on, kSide);
    const PatchNumbering& numbering = on.system.surface_records().patches.numbering();
    ASSERT_EQ(numbering.samples().side(), kSide);
    const PlaceOracle oracle(mesh, Weights::DooSabin);
    std::vector<const Sample*> first(static_cast<std::size_t>(on.system.vertex_count()), nullptr);
    const Sample* sample = samples.data();
    for (std::int32_t c = 0; c < oracle.limit.topology().corner_count(); ++c)
      for (std::uint32_t b = 0; b <= kSide; ++b)
        for (std::uint32_t a = 0; a <= kSide; ++a, ++sample) {
          const auto row = static_cast<std::size_t>(
              on.system.copied_vertices()[numbering.row(c, std::int32_t(a), std::int32_t(b))]);
          const SurfacePoint expected = oracle.limit.evaluate(
              surface_parameter(oracle.limit.topology(), c, double(a) / kSide, double(b) / kSide));
          ASSERT_LT(glm::distance(glm::dvec3(sample->shared), expected.position), 2e-6);
          ASSERT_LT(glm::distance(glm::dvec3(sample->position), expected.position), 2e-6);
          if (sample->normal != glm::vec3(0)) {
            ASSERT_GT(glm::dot(glm::dvec3(sample->normal), expected.normal), 1 - 1e-5);
          }
          if (!first[row]) {
            first[row] = sample;
            continue;
          }
          ++shared;
          ASSERT_EQ(std::memcmp(&sample->shared, &first[row]->shared, sizeof sample->shared), 0)
              << "corner " << c << " at " << a << ", " << b;
          would_differ +=
              std::memcmp(&sample->position, &first[row]->position, sizeof sample->position) != 0;
        }
  }
  // Without owners they do not.
  EXPECT_GT(shared, 10000u);
  EXPECT_GT(would_differ, shared / 10);
}

}  // namespace
}  // namespace planish::testing
