#include <gtest/gtest.h>
#include <opensubdiv/far/patchTable.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "osd/conformance.h"
#include "planish/osd/vk_compute_evaluator.h"
#include "planish/osd/vk_patch_shader_source.h"
#include "planish/osd/vk_patch_table.h"
#include "planish/osd/vk_vertex_buffer.h"
#include "planish/vulkan/device/context.h"
#include "viewer/device.h"
#include "viewer/fixture.h"

namespace planish::testing {
namespace {

// A vertex that the tessellation made.
struct DrawnVertex {
  float patch, u, v;
  glm::vec3 position, du, dv, normal;
};

static_assert(sizeof(DrawnVertex) == 60);

enum class Spacing {
  Equal,
  FractionalEven,
  FractionalOdd,
};

struct DrawOptions {
  Spacing spacing = Spacing::Equal;
  bool by_screen = false;
  float level = 4;
  glm::mat4 clip_from_object{1};
};

using OpenSubdiv::Osd::BufferDescriptor;
using namespace viewer;

constexpr VkDeviceSize kMostVertices = 400000;
// Mesa's llvmpipe (22.3) counts gl_PrimitiveID anew after so many control points of a draw.
constexpr int kPrimitiveIdRun = 1024;
constexpr vulkan::Scope kVertexInput{
    VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_TESSELLATION_CONTROL_SHADER_BIT |
        VK_PIPELINE_STAGE_TESSELLATION_EVALUATION_SHADER_BIT,
    VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_INDEX_READ_BIT | VK_ACCESS_SHADER_READ_BIT};
constexpr vulkan::Scope kCapture{VK_PIPELINE_STAGE_TRANSFORM_FEEDBACK_BIT_EXT,
                                 VK_ACCESS_TRANSFORM_FEEDBACK_WRITE_BIT_EXT |
                                     VK_ACCESS_TRANSFORM_FEEDBACK_COUNTER_WRITE_BIT_EXT};
constexpr vulkan::Scope kHost{VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};
constexpr VkShaderStageFlags kStages =
    VK_SHADER_STAGE_TESSELLATION_CONTROL_BIT | VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT;

// As drawing/view.glsl has it.
struct View {
  glm::mat4 clip_from_object;
  float level;
  VkBool32 by_screen;
  int first_patch;
};

// Without attachments: triangles are captured before they are drawn.
OwnedRenderPass make_empty_pass(VkDevice device) {
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  return OwnedRenderPass(device, info, "vkCreateRenderPass");
}

OwnedFramebuffer make_empty_framebuffer(VkDevice device, VkRenderPass pass) {
  VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
  info.renderPass = pass;
  info.width = info.height = info.layers = 1;
  return OwnedFramebuffer(device, info, "vkCreateFramebuffer");
}

OwnedPipelineLayout make_patch_layout(VkDevice device, VkDescriptorSetLayout set) {
  const VkPushConstantRange push{kStages, 0, sizeof(View)};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.setLayoutCount = 1;
  info.pSetLayouts = &set;
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &push;
  return OwnedPipelineLayout(device, info, "vkCreatePipelineLayout");
}

OwnedDescriptorPool make_pool(VkDevice device) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1};
  VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  info.maxSets = 1;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  return OwnedDescriptorPool(device, info, "vkCreateDescriptorPool");
}

template <class Function>
Function function(VkDevice device, const char* name) {
  return reinterpret_cast<Function>(vkGetDeviceProcAddr(device, name));
}

// As CMakeLists.txt names them.
constexpr const char* kSpacings[] = {"_equal", "_even", "_odd"};

OwnedShader make_shader(VkDevice device, const std::string& name) {
  std::ifstream file(PLANISH_DRAWING_SHADERS "/" + name + ".spv", std::ios::binary);
  const std::string code(std::istreambuf_iterator<char>(file), {});
  EXPECT_FALSE(code.empty()) << name;
  std::vector<std::uint32_t> words(code.size() / sizeof(std::uint32_t));
  std::memcpy(words.data(), code.data(), code.size());
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = code.size();
  info.pCode = words.data();
  return OwnedShader(device, info, "vkCreateShaderModule");
}

// A cage, its points evaluated on the device.
struct DrawnMesh {
  DrawnMesh(const Cage& cage, const RefineOptions& options, osd::VkDeviceContext& target)
      : refined(refine(cage, options)),
        table(osd::VkPatchTable::Create(refined.patches.get(), &target)) {
    const int coarse = static_cast<int>(cage.positions.size());
    const int rows = refined.vertices->GetNumStencils();
    points.reset(osd::VkVertexBuffer::Create(3, coarse + rows, &target));
    points->UpdateData(cage.positions.front().data(), 0, coarse, &target);
    if (rows > 0) {
      const std::unique_ptr<osd::VkStencilTable> stencils(
          osd::VkStencilTable::Create(refined.vertices.get(), &target));
      EXPECT_TRUE(osd::VkComputeEvaluator::EvalStencils(
          points.get(), BufferDescriptor(0, 3, 3), points.get(), BufferDescriptor(3 * coarse, 3, 3),
          stencils.get(), nullptr, &target));
    }
    target.Synchronize();
  }

  Refined refined;
  std::unique_ptr<osd::VkVertexBuffer> points;  // the cage's, then the refined ones
  std::unique_ptr<osd::VkPatchTable> table;
};

// Draws patches by planish_osd_patches.glsl and captures what the tessellation makes.
class PatchDrawing {
 public:
  // `device` captures.
  explicit PatchDrawing(const Device& device)
      : device_(device),
        context_(device.host()),
        target_(context_, device.queue(), device.family()),
        pass_(make_empty_pass(device)),
        framebuffer_(make_empty_framebuffer(device, pass_)),
        set_layout_(make_set_layout(device, 1, kStages)),
        layout_(make_patch_layout(device, set_layout_)),
        pool_(make_pool(device)),
        made_(device, kMostVertices * sizeof(DrawnVertex),
              VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_BUFFER_BIT_EXT, Place::Host),
        byte_count_(device, sizeof(std::uint32_t),
                    VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_COUNTER_BUFFER_BIT_EXT, Place::Host),
        bind_(function<PFN_vkCmdBindTransformFeedbackBuffersEXT>(
            device, "vkCmdBindTransformFeedbackBuffersEXT")),
        begin_(
            function<PFN_vkCmdBeginTransformFeedbackEXT>(device, "vkCmdBeginTransformFeedbackEXT")),
        end_(function<PFN_vkCmdEndTransformFeedbackEXT>(device, "vkCmdEndTransformFeedbackEXT")) {}

  [[nodiscard]] osd::VkDeviceContext& target() { return target_; }
  // Three vertices a triangle.
  [[nodiscard]] std::vector<DrawnVertex> draw(const DrawnMesh& mesh, const DrawOptions& options) {
    vulkan::check(vkResetDescriptorPool(device_, pool_, 0), "vkResetDescriptorPool");
    const VkDescriptorBufferInfo params{mesh.table->GetPatchParamBuffer(), 0, VK_WHOLE_SIZE};
    set_ = make_set(device_, pool_, set_layout_, {&params, 1});
    std::vector<DrawnVertex> vertices;
    for (const OpenSubdiv::Osd::PatchArray& array : mesh.table->GetPatchArrays()) {
      const int most = kPrimitiveIdRun / array.GetStride();
      for (int first = 0; first < array.GetNumPatches(); first += most) {
        const int count = std::min(most, array.GetNumPatches() - first);
        device_.run([&](VkCommandBuffer commands) {
          record(commands, mesh, array, first, count, options);
        });
        std::uint32_t bytes = 0;
        std::memcpy(&bytes, byte_count_.mapped().data(), sizeof bytes);
        EXPECT_LT(bytes, made_.bytes());  // or some may be missing
        const auto* const made = reinterpret_cast<const DrawnVertex*>(made_.mapped().data());
        vertices.insert(vertices.end(), made, made + bytes / sizeof(DrawnVertex));
      }
    }
    return vertices;
  }

 private:
  VkPipeline pipeline(const OpenSubdiv::Osd::PatchArray& array, Spacing spacing) {
    OwnedGraphicsPipeline& kept = pipelines_[{array.GetPatchType(), spacing}];
    if (kept != VkPipeline(VK_NULL_HANDLE)) return kept;
    const std::string which = std::to_string(array.GetPatchType()) + kSpacings[int(spacing)];
    const std::array shaders{make_shader(device_, "patch.vert"),
                             make_shader(device_, "patch_" + which + ".tesc"),
                             make_shader(device_, "patch_" + which + ".tese")};
    constexpr std::array kKinds{VK_SHADER_STAGE_VERTEX_BIT,
                                VK_SHADER_STAGE_TESSELLATION_CONTROL_BIT,
                                VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT};
    std::array<VkPipelineShaderStageCreateInfo, 3> stages{};
    for (std::size_t i = 0; i < stages.size(); ++i) {
      stages[i].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
      stages[i].stage = kKinds[i];
      stages[i].module = shaders[i];
      stages[i].pName = "main";
    }
    const VkVertexInputBindingDescription binding{0, 3 * sizeof(float),
                                                  VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attribute{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0};
    VkPipelineVertexInputStateCreateInfo input{
        VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    input.vertexBindingDescriptionCount = input.vertexAttributeDescriptionCount = 1;
    input.pVertexBindingDescriptions = &binding;
    input.pVertexAttributeDescriptions = &attribute;
    VkPipelineInputAssemblyStateCreateInfo assembly{
        VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_PATCH_LIST;
    VkPipelineTessellationStateCreateInfo tessellation{
        VK_STRUCTURE_TYPE_PIPELINE_TESSELLATION_STATE_CREATE_INFO};
    tessellation.patchControlPoints = static_cast<std::uint32_t>(array.GetStride());
    VkPipelineRasterizationStateCreateInfo raster{
        VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.rasterizerDiscardEnable = VK_TRUE;
    raster.lineWidth = 1;
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    info.stageCount = stages.size();
    info.pStages = stages.data();
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pTessellationState = &tessellation;
    info.pRasterizationState = &raster;
    info.layout = layout_;
    info.renderPass = pass_;
    kept = OwnedGraphicsPipeline(device_, info, "vkCreateGraphicsPipelines");
    return kept;
  }

  // As many patches of an array.
  void record(VkCommandBuffer commands, const DrawnMesh& mesh,
              const OpenSubdiv::Osd::PatchArray& array, int first, int count,
              const DrawOptions& options) {
    const VkBuffer points = mesh.points->BindVBO(), made = made_, byte_count = byte_count_;
    const VkDeviceSize start = 0, bytes = made_.bytes();
    barrier(commands, vulkan::kExitScope, kVertexInput);
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = pass_;
    begin.framebuffer = framebuffer_;
    begin.renderArea.extent = {1, 1};
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline(array, options.spacing));
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set_, 0,
                            nullptr);
    const View view{options.clip_from_object, options.level, options.by_screen,
                    array.GetPrimitiveIdBase() + first};
    vkCmdPushConstants(commands, layout_, kStages, 0, sizeof view, &view);
    vkCmdBindVertexBuffers(commands, 0, 1, &points, &start);
    vkCmdBindIndexBuffer(commands, mesh.table->GetPatchIndexBuffer(), 0, VK_INDEX_TYPE_UINT32);
    bind_(commands, 0, 1, &made, &start, &bytes);
    begin_(commands, 0, 0, nullptr, nullptr);
    const auto points_of = [&](int patches) {
      return static_cast<std::uint32_t>(patches * array.GetStride());
    };
    vkCmdDrawIndexed(commands, points_of(count), 1,
                     static_cast<std::uint32_t>(array.GetIndexBase()) + points_of(first), 0, 0);
    end_(commands, 0, 1, &byte_count, &start);
    vkCmdEndRenderPass(commands);
    barrier(commands, kCapture, kHost);
  }

  const viewer::Device& device_;
  vulkan::Context context_;
  osd::VkDeviceContext target_;
  viewer::OwnedRenderPass pass_;
  viewer::OwnedFramebuffer framebuffer_;
  viewer::OwnedSetLayout set_layout_;
  viewer::OwnedPipelineLayout layout_;
  viewer::OwnedDescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  viewer::Buffer made_, byte_count_;
  PFN_vkCmdBindTransformFeedbackBuffersEXT bind_;
  PFN_vkCmdBeginTransformFeedbackEXT begin_;
  PFN_vkCmdEndTransformFeedbackEXT end_;
  std::map<std::pair<int, Spacing>, viewer::OwnedGraphicsPipeline> pipelines_;
};

using namespace OpenSubdiv;
using Far::PatchDescriptor;

// Corners of triangles on edges that no other triangle of the patch shares. Where a level is
// hardly above 1, the tessellator rounds inner points onto the border, too.
std::vector<DrawnVertex> border_of(const std::vector<DrawnVertex>& vertices) {
  using Place = std::array<float, 3>;
  const auto place = [](const DrawnVertex& v) { return Place{v.patch, v.u, v.v}; };
  std::map<std::pair<Place, Place>, int> edges;
  const auto each_edge = [&](const auto& visit) {
    for (std::size_t i = 0; i < vertices.size(); i += 3)
      for (std::size_t k = 0; k < 3; ++k) visit(vertices[i + k], vertices[i + (k + 1) % 3]);
  };
  each_edge([&](const auto& a, const auto& b) {
    if (place(a) < place(b))
      ++edges[{place(a), place(b)}];
    else
      --edges[{place(b), place(a)}];
  });
  std::vector<DrawnVertex> border;
  each_edge([&](const auto& a, const auto& b) {
    if (place(a) != place(b) && edges[std::minmax(place(a), place(b))] != 0)
      border.insert(border.end(), {a, b});
  });
  return border;
}

// Points of a border by how far along.
using Side = std::map<float, glm::vec3>;

// Of each patch all borders, halves of transition edges apart.
std::vector<Side> sides_of(const std::vector<Patch>& patches,
                           const std::vector<DrawnVertex>& vertices) {
  std::map<std::pair<int, int>, Side> sides;
  for (const DrawnVertex& made : border_of(vertices)) {
    const auto number = static_cast<int>(made.patch);
    const Patch& patch = patches[number];
    const bool triangle = patch.is_triangle();
    const float far = triangle ? 1 - made.u - made.v : 1 - made.u;
    const auto add = [&](int side, int transition, float t) {
      const bool halves = (patch.param.GetTransition() & transition) != 0;
      if (!halves || t <= 0.5f) sides[{number, 2 * side}][t] = made.position;
      if (halves && t >= 0.5f) sides[{number, 2 * side + 1}][t] = made.position;
    };
    if (made.u == 0) add(0, triangle ? 4 : 8, made.v);
    if (made.v == 0) add(1, 1, made.u);
    if (std::abs(far) < 1e-6f) add(2, 2, made.v);
    if (!triangle && made.v == 1) add(3, 4, made.u);
  }
  std::vector<Side> result;
  for (auto& [key, side] : sides) result.push_back(std::move(side));
  return result;
}

float distance_to(const Side& side, const glm::vec3& p) {
  float least = glm::distance(p, side.begin()->second);
  for (auto a = side.begin(), b = std::next(a); b != side.end(); a = b++) {
    const glm::vec3 along = b->second - a->second;
    const float size = glm::dot(along, along);
    const float t = size > 0 ? std::clamp(glm::dot(p - a->second, along) / size, 0.0f, 1.0f) : 0.0f;
    least = std::min(least, glm::distance(p, a->second + t * along));
  }
  return least;
}

// Edges of triangles whose ends are not, bit by bit, those of an opposite one; how many.
int loose_edges(const std::vector<DrawnVertex>& vertices) {
  std::map<std::array<float, 3>, int> points;
  std::vector<int> numbers;
  for (const DrawnVertex& vertex : vertices) {
    const glm::vec3 p = vertex.position + 0.0f;  // no -0
    numbers.push_back(points.try_emplace({p.x, p.y, p.z}, int(points.size())).first->second);
  }
  std::map<std::pair<int, int>, int> edges;
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    const int* const n = &numbers[i];
    if (n[0] == n[1] || n[1] == n[2] || n[2] == n[0]) continue;
    for (int k = 0; k < 3; ++k) ++edges[{n[k], n[(k + 1) % 3]}];
  }
  EXPECT_FALSE(edges.empty());
  return static_cast<int>(std::ranges::count_if(edges, [&](const auto& edge) {
    const auto opposite = edges.find({edge.first.second, edge.first.first});
    return opposite == edges.end() || opposite->second != edge.second;
  }));
}

// Between the borders that patches of a closed mesh share; their ends are far apart.
float widest_gap(const std::vector<Patch>& patches, const std::vector<DrawnVertex>& vertices,
                 float extent) {
  const std::vector<Side> sides = sides_of(patches, vertices);
  std::vector<glm::vec3> corners;
  const auto corner = [&](const glm::vec3& p) {
    const auto same = std::ranges::find_if(
        corners, [&](const glm::vec3& other) { return glm::distance(p, other) < 1e-4f * extent; });
    const std::ptrdiff_t number = same - corners.begin();
    if (same == corners.end()) corners.push_back(p);
    return number;
  };
  std::map<std::pair<std::ptrdiff_t, std::ptrdiff_t>, std::vector<const Side*>> borders;
  for (const Side& side : sides) {
    const auto a = corner(side.begin()->second), b = corner(side.rbegin()->second);
    borders[std::minmax(a, b)].push_back(&side);
  }
  float widest = 0;
  for (const auto& [ends, shared] : borders) {
    EXPECT_EQ(shared.size() % 2, 0u);
    for (const Side* side : shared) {
      // Of the others the nearest, where two patches share several borders.
      float nearest = HUGE_VALF;
      for (const Side* other : shared) {
        float gap = 0;
        for (const auto& [t, p] : *side) gap = std::max(gap, distance_to(*other, p));
        for (const auto& [t, p] : *other) gap = std::max(gap, distance_to(*side, p));
        if (other != side) nearest = std::min(nearest, gap);
      }
      widest = std::max(widest, nearest);
    }
  }
  return widest;
}

// Patches drawn by planish_osd_patches.glsl: what the tessellation made lies where
// Osd::CpuEvaluator has it, and neighbours meet.
using Far::PatchTableFactory;
using PatchOptions = PatchTableFactory::Options;

class OsdDrawing : public CaptureTest {
 protected:
  void SetUp() override {
    CaptureTest::SetUp();
    if (!IsSkipped() && !HasFatalFailure()) drawing_ = std::make_unique<PatchDrawing>(*device_);
  }
  void TearDown() override {
    drawing_.reset();
    CaptureTest::TearDown();
  }

  std::unique_ptr<PatchDrawing> drawing_;
};

RefineOptions refined_to(int level, const Cage& cage,
                         PatchOptions::EndCapType end = PatchOptions::ENDCAP_GREGORY_BASIS) {
  RefineOptions options;
  options.level = level;
  options.adaptive = cage.scheme != Sdc::SCHEME_BILINEAR;
  options.patches = PatchTableFactory::Options(static_cast<unsigned int>(level));
  options.patches.SetEndCapType(end);
  return options;
}

float extent_of(const Cage& cage) {
  float extent = 0;
  for (const auto& point : cage.positions)
    for (const float coordinate : point) extent = std::max(extent, std::abs(coordinate));
  return extent;
}

// The same places by Osd::CpuEvaluator, of the device's points.
struct Expected {
  std::vector<glm::vec3> positions, du, dv;

  Expected(const DrawnMesh& mesh, const std::vector<DrawnVertex>& vertices,
           osd::VkDeviceContext& target)
      : positions(vertices.size()), du(vertices.size()), dv(vertices.size()) {
    const std::vector<Patch> patches = patches_of(*mesh.refined.patches);
    std::vector<Osd::PatchCoord> coords;
    for (const DrawnVertex& vertex : vertices) {
      const Patch& patch = patches.at(static_cast<std::size_t>(vertex.patch));
      coords.push_back(patch.coord(vertex.u, vertex.v));
    }
    std::vector<float> points(std::size_t(3) * mesh.points->GetNumVertices());
    mesh.points->ReadData(points.data(), 0, mesh.points->GetNumVertices(), &target);
    const Osd::CpuPatchTable table(mesh.refined.patches.get());
    const Osd::BufferDescriptor desc(0, 3, 3);
    EXPECT_TRUE(Osd::CpuEvaluator::EvalPatches(
        points.data(), desc, &positions[0].x, desc, &du[0].x, desc, &dv[0].x, desc,
        static_cast<int>(coords.size()), coords.data(), table.GetPatchArrayBuffer(),
        table.GetPatchIndexBuffer(), table.GetPatchParamBuffer()));
  }
};

// What the patches were.
struct Seen {
  std::set<int> types;
  int transitions = 0, boundaries = 0, rotated = 0;

  void add(const Far::PatchTable& table) {
    for (const Patch& patch : patches_of(table)) {
      types.insert(patch.type);
      transitions += patch.param.GetTransition() != 0;
      boundaries += patch.param.GetBoundary() != 0;
      rotated += patch.is_triangle() && patch.param.IsTriangleRotated();
    }
  }
};

void expect_as_evaluated(PatchDrawing& drawing, const DrawnMesh& mesh, float extent) {
  DrawOptions options;
  options.level = 5;
  const std::vector<DrawnVertex> vertices = drawing.draw(mesh, options);
  const std::vector<Patch> patches = patches_of(*mesh.refined.patches);
  std::set<float> drawn;
  const Expected expected(mesh, vertices, drawing.target());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const DrawnVertex& made = vertices[i];
    const Patch& patch = patches[made.patch];
    drawn.insert(made.patch);
    const float grown = static_cast<float>(1 << patch.param.GetDepth());
    const glm::vec3 du = expected.du[i], dv = expected.dv[i], across = glm::cross(du, dv);
    ASSERT_LT(glm::distance(made.position, expected.positions[i]), 4e-7f * extent)
        << "patch " << made.patch << " at " << made.u << ", " << made.v;
    ASSERT_LT(glm::distance(made.du, du), 1e-6f * grown * extent)
        << "patch " << made.patch << " at " << made.u << ", " << made.v;
    ASSERT_LT(glm::distance(made.dv, dv), 1e-6f * grown * extent)
        << "patch " << made.patch << " at " << made.u << ", " << made.v;
    if (glm::length(across) > 0.01f * extent * extent) {
      ASSERT_LT(glm::distance(made.normal, glm::normalize(across)), 2e-3f)
          << "patch " << made.patch << " at " << made.u << ", " << made.v;
    }
  }
  EXPECT_EQ(drawn.size(), patches.size());
}

TEST_F(OsdDrawing, VerticesAreThoseOfTheCpuEvaluator) {
  Seen seen;
  int number = 0;
  for (const Cage& cage : all_cages()) {
    SCOPED_TRACE(cage.name);
    // Each end cap of every third, Gregory's of all.
    const PatchOptions::EndCapType others[] = {PatchOptions::ENDCAP_BILINEAR_BASIS,
                                               PatchOptions::ENDCAP_BSPLINE_BASIS,
                                               PatchOptions::ENDCAP_GREGORY_BASIS};
    for (const auto& [level, end] :
         {std::pair{3, PatchOptions::ENDCAP_GREGORY_BASIS}, std::pair{1, others[number++ % 3]}}) {
      const DrawnMesh mesh(cage, refined_to(level, cage, end), drawing_->target());
      expect_as_evaluated(*drawing_, mesh, extent_of(cage));
      if (HasFatalFailure()) return;
      seen.add(*mesh.refined.patches);
    }
  }
  EXPECT_EQ(seen.types,
            (std::set<int>{PatchDescriptor::QUADS, PatchDescriptor::TRIANGLES,
                           PatchDescriptor::LOOP, PatchDescriptor::REGULAR,
                           PatchDescriptor::GREGORY_BASIS, PatchDescriptor::GREGORY_TRIANGLE}));
  EXPECT_GT(seen.boundaries, 100);
  EXPECT_GT(seen.rotated, 100);
}

TEST_F(OsdDrawing, SingleCreasePatchesAreThoseOfTheCpuEvaluator) {
  int sharp = 0;
  for (const Cage& cage : all_cages()) {
    if (cage.crease_sharpness.empty() || cage.scheme != Sdc::SCHEME_CATMARK) continue;
    SCOPED_TRACE(cage.name);
    RefineOptions options = refined_to(3, cage);
    options.patches.useSingleCreasePatch = true;
    const DrawnMesh mesh(cage, options, drawing_->target());
    expect_as_evaluated(*drawing_, mesh, extent_of(cage));
    for (const Patch& patch : patches_of(*mesh.refined.patches))
      sharp += mesh.refined.patches->GetSingleCreasePatchSharpnessValue(patch.handle) > 0;
  }
  EXPECT_GT(sharp, 10);
}

bool is_closed(const Cage& cage) {
  const auto refiner = make_refiner(cage);
  const Far::TopologyLevel& level = refiner->GetLevel(0);
  for (int edge = 0; edge < level.GetNumEdges(); ++edge)
    if (level.GetEdgeFaces(edge).size() != 2) return false;
  return cage.holes.empty();
}

DrawOptions seen_from(const Cage& cage, float azimuth, float zoom) {
  std::vector<glm::dvec3> points;
  for (const auto& p : cage.positions) points.emplace_back(p[0], p[1], p[2]);
  viewer::OrbitCamera camera = viewer::camera_around(points);
  camera.azimuth_degrees = azimuth;
  camera.zoom = zoom;
  DrawOptions options;
  options.by_screen = true;
  options.level = 20;
  options.clip_from_object = camera.clip_from_world(1);
  return options;
}

TEST_F(OsdDrawing, NeighboursMeet) {
  Seen seen;
  float widest = 0, mixed = HUGE_VALF;
  for (const Cage& cage : all_cages()) {
    if (!is_closed(cage)) continue;
    SCOPED_TRACE(cage.name);
    const DrawnMesh mesh(cage, refined_to(3, cage), drawing_->target());
    const std::vector<Patch> patches = patches_of(*mesh.refined.patches);
    seen.add(*mesh.refined.patches);
    const float extent = extent_of(cage);
    const auto expect_no_gap = [&](const DrawOptions& options) {
      const float gap = widest_gap(patches, drawing_->draw(mesh, options), extent) / extent;
      EXPECT_LT(gap, 2e-6f) << "level " << options.level << ", spacing " << int(options.spacing);
      widest = std::max(widest, gap);
    };
    for (const float level : {1.0f, 5.0f, 6.4f}) expect_no_gap({.level = level});
    for (const Spacing spacing :
         {Spacing::Equal, Spacing::FractionalEven, Spacing::FractionalOdd}) {
      DrawOptions options = seen_from(cage, 35, 1.3f);
      options.spacing = spacing;
      expect_no_gap(options);
    }
    if (cage.name != "cube") continue;
    // Of every other patch another level.
    std::vector<DrawnVertex> vertices = drawing_->draw(mesh, {.level = 16});
    const std::vector<DrawnVertex> others = drawing_->draw(mesh, {.level = 24});
    std::erase_if(vertices, [](const auto& vertex) { return int(vertex.patch) % 2 == 0; });
    std::ranges::copy_if(others, std::back_inserter(vertices),
                         [](const auto& vertex) { return int(vertex.patch) % 2 == 0; });
    mixed = widest_gap(patches, vertices, extent) / extent;
  }
  RecordProperty("widest", std::to_string(widest));
  EXPECT_GT(mixed, 1e-4f);
  EXPECT_LT(mixed, 1);
  EXPECT_GT(seen.transitions, 100);
}

// The same with faces that begin at any of their corners, and points a little elsewhere.
Cage turned(Cage cage, const std::string& name) {
  cage.name = name;
  std::mt19937 random(1);
  for (auto& point : cage.positions)
    for (float& coordinate : point) coordinate += 1e-11f * static_cast<float>(random());
  auto corner = cage.corners.begin();
  for (const int size : cage.face_sizes) {
    std::rotate(corner, corner + static_cast<int>(random() % 4) % size, corner + size);
    corner += size;
  }
  return cage;
}

TEST_F(OsdDrawing, NeighboursOfOneLevelAndTypeMeetToTheBit) {
  std::set<int> types;
  int creased = 0;
  std::vector<Cage> cages = all_cages();
  for (const bool creases : {false, true})
    for (const bool triangles : {false, true}) {
      Cage cage = triangles ? triangle_torus(7, 5) : torus(7, 5);
      if (triangles) cage.scheme = Sdc::SCHEME_LOOP;
      for (int i = 0; creases && i < 7; ++i)
        cage.crease(i, (i + 1) % 7, Sdc::Crease::SHARPNESS_INFINITE);
      cages.push_back(turned(cage, creases ? "turned torus, creased" : "turned torus"));
    }
  int compared = 0;
  for (const Cage& cage : cages) {
    if (!is_closed(cage)) continue;
    SCOPED_TRACE(cage.name);
    RefineOptions refinement = refined_to(1, cage);
    refinement.patches.useInfSharpPatch = true;
    const DrawnMesh mesh(cage, refinement, drawing_->target());
    Seen seen;
    seen.add(*mesh.refined.patches);
    if (seen.types.size() > 1 || seen.transitions > 0) continue;
    EXPECT_EQ(loose_edges(drawing_->draw(mesh, {.level = 5})), 0);
    EXPECT_EQ(loose_edges(drawing_->draw(mesh, seen_from(cage, 70, 1.3f))), 0);
    types.merge(seen.types);
    creased += !cage.crease_sharpness.empty();
    compared += cage.name.starts_with("turned");
  }
  EXPECT_EQ(types, (std::set<int>{PatchDescriptor::QUADS, PatchDescriptor::LOOP,
                                  PatchDescriptor::REGULAR, PatchDescriptor::GREGORY_BASIS}));
  EXPECT_GT(creased, 3);
  EXPECT_EQ(compared, 4);
}

// For hosts that compile at run time.
TEST(OsdPatchShaderSource, IsTheInstalledFiles) {
  const auto read = [](const std::string& name) {
    std::ifstream file(PLANISH_OSD_SHADERS "/" + name);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string text = read("planish_osd_patches.glsl") + read("planish_osd_tessellation.glsl");
  EXPECT_GT(text.size(), 10000u);
  using Source = osd::VkPatchShaderSource;
  EXPECT_EQ(Source::GetPatchDrawingShaderSource(PatchDescriptor::REGULAR),
            "#define OSD_PATCH_TYPE 6\n" + text);
  EXPECT_EQ(Source::GetPatchDrawingShaderSource(PatchDescriptor::GREGORY_TRIANGLE),
            "#define OSD_PATCH_TYPE 10\n" + text);
  for (const auto type :
       {PatchDescriptor::NON_PATCH, PatchDescriptor::POINTS, PatchDescriptor::LINES,
        PatchDescriptor::GREGORY, PatchDescriptor::GREGORY_BOUNDARY})
    EXPECT_EQ(Source::GetPatchDrawingShaderSource(type), "");
}

// As planish_osd_patches.glsl says: along du x dv, where `cw` is declared.
TEST_F(OsdDrawing, TrianglesFaceAlongTheNormal) {
  for (const Cage& cage : all_cages()) {
    if (cage.name != "torus crease" && cage.name != "loop icosahedron crease") continue;
    const DrawnMesh mesh(cage, refined_to(2, cage), drawing_->target());
    const std::vector<DrawnVertex> made = drawing_->draw(mesh, {.level = 6});
    for (std::size_t i = 0; i < made.size(); i += 3) {
      const glm::vec3 across = glm::cross(made[i + 1].position - made[i].position,
                                          made[i + 2].position - made[i].position);
      ASSERT_GT(glm::dot(across, made[i].normal), 0);
    }
  }
}

}  // namespace
}  // namespace planish::testing
