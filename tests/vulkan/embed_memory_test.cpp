// What an object takes of a host's device: a block for each use of memory, and one pool.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <optional>

#include "planish/vulkan/device/driver.h"
#include "support/meshes.h"
#include "vulkan/embedding_fixture.h"
#include "vulkan/pretended_memory.h"

namespace planish::testing {
namespace {

using namespace vulkan;
using ::testing::ElementsAre;
using ::testing::Pair;
using enum MemoryUse;

/// A host's allocator, which counts.
class HostBlocks {
 public:
  HostBlocks(const HostDevice& host, const VkPhysicalDeviceMemoryProperties& memory)
      : device_(host.device),
        memory_(memory),
        vk_(DeviceFunctions::load(
            InstanceFunctions::load(host.get_instance_proc, host.instance).vkGetDeviceProcAddr,
            host.device)) {}

  MemoryHooks hooks() {
    return {[this](const MemoryRequest& request) { return allocate(request); },
            [this](const MemoryBlock& block) { vk_.vkFreeMemory(device_, block.memory, nullptr); }};
  }
  std::map<MemoryUse, int> taken;

 private:
  MemoryBlock allocate(const MemoryRequest& request) {
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = request.requirements.size;
    info.memoryTypeIndex = mapped_type(memory_, request.requirements.memoryTypeBits);
    MemoryBlock block;
    check(vk_.vkAllocateMemory(device_, &info, nullptr, &block.memory), "vkAllocateMemory");
    check(vk_.vkMapMemory(device_, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped),
          "vkMapMemory");
    ++taken[request.use];
    return block;
  }

  VkDevice device_;
  VkPhysicalDeviceMemoryProperties memory_;
  DeviceFunctions vk_;
};

class EmbedMemory : public Embedding {
 protected:
  /// Pools are looked at as well: as many as `pools`.
  std::map<MemoryUse, int> taken_by(HostBlocks& blocks, int pools,
                                    const std::function<void()>& make) {
    blocks.taken.clear();
    const int before = PretendedDriver::count("vkCreateDescriptorPool");
    make();
    EXPECT_EQ(PretendedDriver::count("vkCreateDescriptorPool") - before, pools);
    return blocks.taken;
  }
};

TEST_F(EmbedMemory, IsABlockForEachUseAndAPoolForAnObject) {
  HostBlocks blocks(own_->host_device(), own_->capabilities().memory);
  HostDevice host = own_->host_device();
  host.memory = blocks.hooks();
  Context context(host);
  const Buffer vertices(context, 1 << 20, Device);
  const SystemOptions all{.levels = {1, 2}};
  SystemOptions within = all, fair = all;
  within.within = 0.01;
  fair.method = InterpolationMethod::Fair;
  for (const SystemOptions& options : {all, within, fair}) {
    const bool is_fair = options.method == InterpolationMethod::Fair;
    const bool takes_edits = !is_fair && options.within == 0;
    const System system(test::icosphere(1), options);
    std::optional<DeviceSystem> tables;
    EXPECT_THAT(taken_by(blocks, 0,
                         [&] {
                           tables.emplace(context, system,
                                          DeviceSystemOptions{.answers_places = true,
                                                              .takes_edits = takes_edits});
                         }),
                ElementsAre(Pair(Device, 1)));
    SolveOptions wanted;
    wanted.vertices.buffer = vertices.handle();
    wanted.further_slots = {{.vertices = {vertices.handle()}}, {.vertices = {vertices.handle()}}};
    if (takes_edits) wanted.moved = {vertices.handle(), 1 << 19, 9};
    std::optional<vulkan::Solve> solve;
    const auto of_solve = taken_by(blocks, 1, [&] { solve.emplace(context, *tables, wanted); });
    if (is_fair)
      EXPECT_THAT(of_solve, ElementsAre(Pair(Device, 1)));
    else
      EXPECT_THAT(of_solve, ElementsAre(Pair(Device, 1), Pair(Upload, 1)));
    std::optional<Tessellation> levels;
    EXPECT_THAT(taken_by(blocks, 1,
                         [&] {
                           levels.emplace(context, *tables, *solve,
                                          TessellationOptions{.vertices = {vertices.handle()}});
                         }),
                ElementsAre(Pair(Device, 1), Pair(Upload, 1)));
    std::optional<Places> places;
    EXPECT_THAT(taken_by(blocks, 1,
                         [&] {
                           places.emplace(context, *tables, *solve,
                                          PlacesOptions{.list = {.count = 9},
                                                        .results = {.buffer = vertices.handle()}});
                         }),
                ElementsAre(Pair(Device, 1)));
  }
}

// Of memory that is not coherent, too, whose blocks lie in atoms.
TEST_F(EmbedMemory, IsInSeveralBlocksWhereOneWouldBeAboveTheLimit) {
  const PolygonMesh mesh = test::torus(40, 30, 2, 0.7);
  const auto surface = [&](int& allocations) {
    const int before = PretendedDriver::count("vkAllocateMemory");
    HostTopology topology(*context_, mesh, {.level = 2}, /*max_vertex_stride=*/24);
    topology.upload(*submitter_);
    HostFrame frame(*context_, topology);
    std::vector<Vertex> vertices = run(frame, mesh, iterations(30));
    allocations = PretendedDriver::count("vkAllocateMemory") - before;
    return vertices;
  };
  with_both_variants([&] {
    const ContextOptions options{.variant = context_->variant()};
    int few = 0, many = 0;
    const std::vector<Vertex> whole = surface(few);
    PretendedDriver::pretence().split_memory = true;
    PretendedDriver::pretence().allocation_size = 700'000;
    open(options);
    const std::vector<Vertex> cut = surface(many);
    EXPECT_GT(many, few);
    EXPECT_TRUE(same_bits(cut, whole));
    // Nothing is taken of what is too large as a whole.
    const int before = PretendedDriver::count("vkAllocateMemory");
    EXPECT_THROW(Buffer(*context_, 700'001, Device), Error);
    EXPECT_EQ(PretendedDriver::count("vkAllocateMemory"), before);
    PretendedDriver::pretence() = {};
  });
}

}  // namespace
}  // namespace planish::testing
