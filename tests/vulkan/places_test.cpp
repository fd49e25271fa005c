#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "generated/surface_samples.spv.h"
#include "planish/core/error.h"
#include "planish/vulkan/host/system.h"
#include "support/calls.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/device_cases.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

// The surface at lists of places, in single precision on a device, against LimitSurface.

using namespace vulkan;

// Closed, open, creased, with holes; valences 3 to 20, faces of 3 to 20 corners, valence 2.
std::vector<test::NamedMesh> meshes_for_places() {
  std::vector<test::NamedMesh> meshes = {{"torus", test::torus(12, 7, 2, 0.7)},
                                         {"icosphere", test::icosphere(1)},
                                         {"plate", test::plate_with_hole(5)},
                                         {"L", test::l_shaped_plate(2)},
                                         {"valence 2", test::cube_with_split_edges()}};
  for (int n = 3; n <= 20; ++n) {
    meshes.push_back({"bipyramid " + std::to_string(n), test::bipyramid(n)});
    meshes.push_back({"prism " + std::to_string(n), test::prism(n)});
  }
  const std::vector<test::NamedMesh> kinds = random_kinds();
  meshes.insert(meshes.end(), kinds.begin(), kinds.end());
  const std::vector<test::NamedMesh> rings = large_rings();
  meshes.insert(meshes.end(), rings.begin(), rings.end());
  for (test::NamedMesh& mesh : meshes) mesh.mesh = in_floats(mesh.mesh);
  return meshes;
}

struct PlaceErrors {
  double position = 0, first = 0, second = 0, normal = 0;
};

// First derivatives in parts of themselves, second ones of the first ones and themselves: what
// rounding leaves is in proportion to what is added up. At `distance` from V or F double itself has
// rounded points of the patch before it took differences and made them 1 / distance larger, twice
// for second derivatives.
void compare_place(const PlaceResult& found, const SurfacePoint& expected, double size,
                   double distance, PlaceErrors& errors) {
  const auto grow = [](double& largest, double value) {
    if (!(value <= largest)) largest = value;
  };
  const auto off = [](const glm::vec3& a, const glm::dvec3& b) {
    return glm::distance(glm::dvec3(a), b);
  };
  const double first = glm::length(expected.du) + glm::length(expected.dv) + 0.01 * size;
  grow(errors.position, off(found.position, expected.position) / size);
  const bool is_singular = found.state == PlaceState::Singular;
  ASSERT_TRUE(is_singular || found.state == PlaceState::Regular);
  // Beside such a place first derivatives depend on the direction.
  if (!is_singular || distance == 0)
    grow(errors.first, (off(found.du, expected.du) + off(found.dv, expected.dv)) / first);
  if (is_singular) {
    ASSERT_LT(distance, std::ldexp(1.0, -23));
    for (const glm::vec3& d : {found.duu, found.duv, found.dvv}) ASSERT_EQ(d, glm::vec3(0));
  } else {
    ASSERT_TRUE(expected.has_second);
    const double second = glm::length(expected.duu) + glm::length(expected.duv) +
                          glm::length(expected.dvv) + first + 1e-9 * size / (distance * distance);
    grow(errors.second, (off(found.duu, expected.duu) + off(found.duv, expected.duv) +
                         off(found.dvv, expected.dvv)) /
                            second);
  }
  // At vertices of valence 2 tangents are parallel, and LimitSurface has a normal of places around.
  if (is_singular && found.normal == glm::vec3(0)) return;
  // The less of a direction the more parallel tangents are.
  const double area = glm::length(glm::cross(expected.du, expected.dv)) /
                      (glm::length(expected.du) * glm::length(expected.dv));
  const double shorter = std::min(glm::length(expected.du), glm::length(expected.dv));
  const double noise = distance == 0 ? 0 : 1e-10 * size / (distance * shorter);
  if (area > 1e-3) grow(errors.normal, area * off(found.normal, expected.normal) / (1 + noise));
}

// Of a place in its corner's patch from the nearer one of V and F.
double distance_to_ends(const MeshTopology& topology, const SurfaceParameter& at) {
  const CornerParameter in = corner_parameter(topology, at);
  return std::min(std::max(in.u, in.v), std::max(1 - in.u, 1 - in.v));
}

TEST_F(PlacesOnDevice, AreTheLimitSurfaces) {
  with_both_variants([&] {
    for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
      PlaceErrors worst;
      for (const auto& [name, mesh] : meshes_for_places()) {
        SCOPED_TRACE(name);
        const PlaceOracle oracle(mesh, weights);
        const auto places = places_on(oracle.limit.topology(), 7, 12);
        const auto found = results_of(mesh, places, {.weights = weights});
        const double size = oracle.limit.surface().placement().diagonal;
        PlaceErrors errors;
        for (std::size_t i = 0; i < places.size(); ++i) {
          const SurfaceParameter at{static_cast<std::int32_t>(places[i].face), places[i].u,
                                    places[i].v};
          compare_place(found[i], oracle.limit.evaluate(at), size,
                        distance_to_ends(oracle.limit.topology(), at), errors);
          ASSERT_FALSE(HasFatalFailure()) << places[i].face << " " << at.u << " " << at.v;
        }
        EXPECT_LT(errors.position, 3e-7);
        EXPECT_LT(errors.first, 1e-5);
        EXPECT_LT(errors.second, 1e-5);
        EXPECT_LT(errors.normal, 1e-5);
        worst = {std::max(worst.position, errors.position), std::max(worst.first, errors.first),
                 std::max(worst.second, errors.second), std::max(worst.normal, errors.normal)};
      }
      std::printf("  off by at most %.1e, du %.1e, duu %.1e, normals %.1e\n", worst.position,
                  worst.first, worst.second, worst.normal);
    }
  });
}

// At vertices and centres themselves the limits are closed forms.
TEST_F(PlacesOnDevice, KnowVerticesAndCentres) {
  for (const auto& [name, mesh] : meshes_for_places()) {
    SCOPED_TRACE(name);
    const PlaceOracle oracle(mesh, Weights::DooSabin);
    const MeshTopology& topology = oracle.limit.topology();
    std::vector<PlaceRecord> places;
    for (std::int32_t c = 0; c < topology.corner_count(); ++c)
      for (const double at : {0.0, 1.0}) {
        const SurfaceParameter p = surface_parameter(topology, c, at, at);
        places.push_back({static_cast<std::uint32_t>(p.face), float(p.u), float(p.v)});
      }
    const auto found = results_of(mesh, places);
    const double size = oracle.limit.surface().placement().diagonal;
    PlaceErrors errors;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const SurfacePoint expected = oracle.limit.evaluate(
          {static_cast<std::int32_t>(places[i].face), places[i].u, places[i].v});
      ASSERT_EQ(found[i].state == PlaceState::Regular, expected.has_second) << i;
      compare_place(found[i], expected, size, 0, errors);
    }
    EXPECT_LT(errors.position, 3e-7);
    EXPECT_LT(errors.first, 1e-5);
    EXPECT_LT(errors.normal, 1e-5);
  }
}

TEST_F(PlacesOnDevice, LieOnTheSurfaceOfASolve) {
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    const PolygonMesh mesh =
        in_floats(test::with_random_creases(test::random_open_mesh(2), 0.1, 3));
    const PlaceOracle oracle(mesh, Weights::DooSabin);
    const MeshTopology& topology = oracle.limit.topology();
    std::vector<PlaceRecord> places;
    std::vector<std::int32_t> vertices;
    for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
      const SurfaceParameter p = surface_parameter(topology, c, 0, 0);
      places.push_back({static_cast<std::uint32_t>(p.face), float(p.u), float(p.v)});
      vertices.push_back(topology.vertex_of(c));
    }
    const auto found = results_of(mesh, places, {.method = method}, 60);
    for (std::size_t i = 0; i < places.size(); ++i)
      ASSERT_LT(glm::distance(glm::dvec3(found[i].position), mesh.positions[vertices[i]]), 4e-6)
          << i;
  }
}

// What lists of places may hold, and where their results go.
using ::testing::HasSubstr;

class PlaceLists : public PlacesOnDevice {};

bool is_place_of(const MeshTopology& topology, const SurfaceParameter& at) {
  try {
    (void)corner_parameter(topology, at);
    return true;
  } catch (const Error&) {
    return false;
  }
}

bool is_beside_face(const MeshTopology& topology, const SurfaceParameter& at) {
  for (const double du : {-1e-6, 0.0, 1e-6})
    for (const double dv : {-1e-6, 0.0, 1e-6})
      if (is_place_of(topology, {at.face, at.u + du, at.v + dv})) return true;
  return false;
}

TEST_F(PlaceLists, RecordsOfAnyContentAreAnsweredOrNone) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  for (const PolygonMesh& mesh : {test::torus(5, 4, 2, 0.7), test::prism(13)}) {
    const auto faces = static_cast<std::uint32_t>(mesh.face_count());
    const std::vector<PlaceRecord> bad = {{faces, 0.2f, 0.2f}, {0xffffffffu, 0.2f, 0.2f},
                                          {0x80000000u, 0, 0}, {0, nan, 0.2f},
                                          {0, 0.2f, nan},      {0, infinite, 0},
                                          {0, -infinite, 0},   {0, 0.2f, -0.01f},
                                          {0, 70000.0f, 0.2f}, {0, 0.2f, 3.6f},
                                          {0, -1e30f, 1e30f},  {1, 1e38f, 0.1f},
                                          {0, -0.01f, 0.2f},   {0, 0.2f, 5.2f}};
    with_both_variants([&] {
      for (const PlaceResult& result : results_of(mesh, bad)) {
        EXPECT_EQ(result.state, PlaceState::None);
        for (const glm::vec3& v : {result.position, result.normal, result.du, result.dv, result.duu,
                                   result.duv, result.dvv})
          EXPECT_EQ(v, glm::vec3(0));
      }
      // Any words at all.
      std::mt19937 random(3);
      std::vector<PlaceRecord> any(20'000);
      for (PlaceRecord& place : any) {
        const auto word = [&] { return static_cast<std::uint32_t>(random()); };
        place = {word() % 2 == 0 ? word() % (faces + 2) : word(), std::bit_cast<float>(word()),
                 std::bit_cast<float>(word())};
        if (word() % 4 == 0) place.u = static_cast<float>(word() % 1000) / 200;
        if (word() % 4 == 0) place.v = static_cast<float>(word() % 1000) / 200;
      }
      int answered = 0;
      const PlaceOracle oracle(mesh, Weights::DooSabin);
      const auto found = results_of(mesh, any);
      for (std::size_t i = 0; i < any.size(); ++i) {
        const PlaceResult& result = found[i];
        const SurfaceParameter at{static_cast<std::int32_t>(any[i].face), any[i].u, any[i].v};
        const bool is_place = is_place_of(oracle.limit.topology(), at);
        answered += is_place ? 1 : 0;
        // Places within 1e-6 of a face count here, within 1e-9 there.
        if (is_place || !is_beside_face(oracle.limit.topology(), at)) {
          ASSERT_EQ(result.state != PlaceState::None, is_place)
              << at.face << " " << at.u << " " << at.v;
        }
        ASSERT_TRUE(std::isfinite(result.position.x + result.du.x + result.duv.y)) << i;
      }
      EXPECT_GT(answered, 100);
    });
  }
}

TEST_F(PlaceLists, TakeAnyLayoutAndTouchNothingBeside) {
  const PolygonMesh mesh = in_floats(test::icosphere(1));
  const PlaceOracle oracle(mesh, Weights::DooSabin);
  const auto places = places_on(oracle.limit.topology(), 5, 1);
  const auto count = static_cast<std::uint32_t>(places.size());
  const auto expected = results_of(mesh, places);
  Case c(*context_, *submitter_, mesh);
  Buffer list(*context_, 20 + 28 * std::uint64_t(count), MemoryUse::Upload);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(&list.mapped()[20 + 28 * i], &places[i], sizeof places[i]);
  list.flush();
  PlaceLayout layout{.stride = 40};
  layout.offset = 12;
  layout.dvv_offset = 4;
  layout.position_offset = 28;
  layout.state_offset = 20;
  layout.normal_offset = layout.du_offset = layout.dv_offset = kNotWritten;
  layout.duu_offset = layout.duv_offset = kNotWritten;
  const std::uint32_t asked = count - 7;
  Buffer results(*context_, layout.offset + 40 * std::uint64_t(count), MemoryUse::Download);
  std::memset(results.mapped().data(), 0x5a, results.mapped().size());
  results.flush();
  layout.buffer = results.handle();
  const Places strided(*context_, c.tables, c.solve,
                       {.list = {list.handle(), 20, 28, count}, .results = layout});
  submitter_->run([&](VkCommandBuffer commands) {
    c.solve.record_solve(commands, {});
    c.solve.record_surface(commands);
    strided.record_evaluate(commands, asked);
  });
  results.invalidate();
  for (std::size_t i = 0; i < asked; ++i) {
    std::byte* at = &results.mapped()[layout.offset + 40 * i];
    glm::vec3 position, dvv;
    PlaceState state;
    std::memcpy(&position, at + 28, sizeof position);
    std::memcpy(&dvv, at + 4, sizeof dvv);
    std::memcpy(&state, at + 20, sizeof state);
    ASSERT_EQ(position, expected[i].position) << i;
    ASSERT_EQ(dvv, expected[i].dvv) << i;
    ASSERT_EQ(state, expected[i].state) << i;
    std::memset(at + 28, 0x5a, sizeof position);
    std::memset(at + 4, 0x5a, sizeof dvv);
    std::memset(at + 20, 0x5a, sizeof state);
  }
  EXPECT_THAT(results.mapped(), ::testing::Each(std::byte{0x5a}));
}

TEST_F(PlaceLists, SlicesAndListsOfTheirOwnChangeNothing) {
  const PolygonMesh mesh = in_floats(test::with_random_creases(test::icosphere(1), 0.1, 3));
  const PlaceOracle oracle(mesh, Weights::DooSabin);
  const auto places = places_on(oracle.limit.topology(), 6, 60);
  const auto count = static_cast<std::uint32_t>(places.size());
  const auto expected = results_of(mesh, places);
  for (const ContextOptions& low :
       {ContextOptions{.max_storage_range = 1 << 20}, ContextOptions{.max_group_count = 3}}) {
    open(low);
    PretendedDriver::forget_notes();
    Case c(*context_, *submitter_, mesh, {}, {.list = {.count = count}});
    put(c.list, places);
    const Places asked(*context_, c.tables, c.solve,
                       {.list = {.count = count}, .results = {.buffer = c.results.handle()}});
    submitter_->run([&](VkCommandBuffer commands) {
      asked.record_list(commands, c.list.handle(), 0);
      c.solve.record_solve(commands, {});
      c.solve.record_surface(commands);
      asked.record_evaluate(commands);
    });
    if (low.max_group_count > 0) {
      EXPECT_LE(PretendedDriver::notes().largest_dispatch, low.max_group_count);
    }
    const auto found = fetched<PlaceResult>(c.results, count);
    EXPECT_EQ(std::memcmp(found.data(), expected.data(), count * sizeof found[0]), 0);
  }
}

TEST_F(PlaceLists, RecordingIsOnlyVkCmd) {
  const PolygonMesh mesh = test::icosphere(1);
  Case c(*context_, *submitter_, mesh, {}, {.list = {.count = 100}});
  const Places asked(*context_, c.tables, c.solve,
                     {.list = {.count = 100}, .results = {.buffer = c.results.handle()}});
  std::memset(c.list.mapped().data(), 0, c.list.mapped().size());
  c.list.flush();
  HostCommands commands(*own_);
  recorded_calls(commands, [&](VkCommandBuffer buffer) {
    c.solve.record_solve(buffer, {});
    c.solve.record_surface(buffer);
    asked.record_list(buffer, c.list.handle(), 0);
    asked.record_evaluate(buffer, 50);
  });
  commands.submit();
  commands.wait();
}

TEST_F(PlaceLists, BadOptionsAreRefused) {
  const PolygonMesh mesh = test::icosphere(1);
  Case c(*context_, *submitter_, mesh, {}, {.list = {.count = 8}});
  const DeviceSystem without(*context_, c.system);
  const PlaceLayout results{.buffer = c.results.handle()};
  const PlaceList list{.count = 8};
  const VkBuffer own = c.list.handle();
  const auto with = [&](std::uint32_t PlaceLayout::*offset, std::uint32_t value) {
    PlaceLayout bad = results;
    bad.*offset = value;
    return PlacesOptions{.list = list, .results = bad};
  };
  struct Row {
    PlacesOptions options;
    const char* words;
    const DeviceSystem* tables;
  };
  const Row rows[] = {{{.results = results}, "has none", &c.tables},
                      {{.list = {own, 2, 12, 8}, .results = results}, "offset 2", &c.tables},
                      {{.list = {own, 0, 8, 8}, .results = results}, "stride 8", &c.tables},
                      {{.list = {{}, 0, 16, 8}, .results = results}, "stride 12", &c.tables},
                      {{.list = list}, "no buffer", &c.tables},
                      {with(&PlaceLayout::dvv_offset, 80), "end at 92 bytes", &c.tables},
                      {with(&PlaceLayout::dvv_offset, 88), "offset 88", &c.tables},
                      {with(&PlaceLayout::duv_offset, 56),
                       "duu of places and duv of places share bytes 56 to ", &c.tables},
                      {{.list = {c.results.handle(), 0, 12, 8}, .results = results},
                       "a list of places and positions of places share bytes 0 to ",
                       &c.tables},
                      {{.list = list, .results = results}, "answers_places", &without}};
  for (const Row& row : rows)
    EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                                 [&] { Places(*context_, *row.tables, c.solve, row.options); }),
                HasSubstr(row.words));
}

TEST_F(PlaceLists, LowLimitsAreNamed) {
  open({.max_storage_range = 1 << 18});
  const System system(test::random_closed_mesh(2));
  EXPECT_THAT(test::message_of(ErrorCode::OutOfMemory,
                               [&] {
                                 DeviceSystem(*context_, system,
                                              {.max_vertex_stride = 24, .answers_places = true});
                               }),
              HasSubstr("kinds of corners take"));
}

// The surface as shader code, by bindings of the host's own: positions on shared edges are the same
// bits for all corners that meet there, and all of it is the limit surface.

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
    const std::size_t count = std::size_t(surface.corner_count) * (side + 1) * (side + 1);
    Buffer target(*context_, count * sizeof(Sample), MemoryUse::Download);
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
    return fetched<Sample>(target, count);
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
