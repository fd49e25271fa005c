#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <random>
#include <span>
#include <tuple>

#include "generated/layers.frag.spv.h"
#include "generated/patch.tesc.spv.h"
#include "generated/patch.vert.spv.h"
#include "generated/watched_patch.tese.spv.h"
#include "support/random_meshes.h"
#include "viewer/device.h"
#include "viewer/fixture.h"
#include "viewer/renderer.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

// A vertex that the tessellation made.
struct PatchVertex {
  float corner, u, v;
  glm::vec3 position;
};

}  // namespace

static_assert(sizeof(PatchVertex) == 24);

namespace {

// The viewer's patches of a mesh, which is its own cage, by the viewer's vertex and control
// shaders.
class WatchedPatches {
 public:
  // `device` captures.
  WatchedPatches(const viewer::Device& device, const PolygonMesh& mesh, VkExtent2D extent);

  void draw(const viewer::OrbitCamera& camera);
  // Of the last draw, three a triangle.
  [[nodiscard]] std::span<const PatchVertex> vertices() const;
  // How many layers face the eye and turn away at each pixel, 64 a layer (16 a sample).
  [[nodiscard]] std::span<const std::array<std::uint8_t, 4>> layers() const;

 private:
  const viewer::Device& device_;
  VkExtent2D extent_;
  viewer::OwnedRenderPass pass_;
  viewer::Image image_;
  viewer::Targets targets_;
  vulkan::Context context_;
  viewer::Pipelines pipelines_;
  viewer::Model model_;
  viewer::Frame frame_;
  std::unique_ptr<vulkan::Solve> solve_;
  viewer::Buffer made_, byte_count_, picture_;
  viewer::OwnedGraphicsPipeline pipeline_;
  PFN_vkCmdBindTransformFeedbackBuffersEXT bind_;
  PFN_vkCmdBeginTransformFeedbackEXT begin_;
  PFN_vkCmdEndTransformFeedbackEXT end_;
};

using namespace viewer;

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr VkDeviceSize kMostVertices = 2000000;

Scene scene_of(const PolygonMesh& mesh) {
  Scene scene;
  scene.mesh = mesh;
  scene.system.level = 0;
  return scene;
}

template <class Function>
Function function(VkDevice device, const char* name) {
  return reinterpret_cast<Function>(vkGetDeviceProcAddr(device, name));
}

constexpr vulkan::Scope kCapture{VK_PIPELINE_STAGE_TRANSFORM_FEEDBACK_BIT_EXT,
                                 VK_ACCESS_TRANSFORM_FEEDBACK_WRITE_BIT_EXT |
                                     VK_ACCESS_TRANSFORM_FEEDBACK_COUNTER_WRITE_BIT_EXT};
constexpr vulkan::Scope kHost{VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};

WatchedPatches::WatchedPatches(const Device& device, const PolygonMesh& mesh, VkExtent2D extent)
    : device_(device),
      extent_(extent),
      pass_(make_render_pass(device, {kFormat, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL})),
      image_(device, {kFormat, extent, VK_SAMPLE_COUNT_1_BIT,
                      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                      VK_IMAGE_ASPECT_COLOR_BIT}),
      targets_(device, pass_, kFormat, extent, std::array{image_.view()}),
      context_(device.host()),
      pipelines_(device, pass_),
      model_(device, context_, scene_of(mesh)),
      frame_(device, context_, model_),
      made_(device, kMostVertices * sizeof(PatchVertex),
            VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_BUFFER_BIT_EXT, Place::Host),
      byte_count_(device, sizeof(std::uint32_t),
                  VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_COUNTER_BUFFER_BIT_EXT, Place::Host),
      picture_(device, VkDeviceSize{4} * extent.width * extent.height,
               VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Host),
      bind_(function<PFN_vkCmdBindTransformFeedbackBuffersEXT>(
          device, "vkCmdBindTransformFeedbackBuffersEXT")),
      begin_(
          function<PFN_vkCmdBeginTransformFeedbackEXT>(device, "vkCmdBeginTransformFeedbackEXT")),
      end_(function<PFN_vkCmdEndTransformFeedbackEXT>(device, "vkCmdEndTransformFeedbackEXT")) {
  viewer::Drawing drawing{viewer::spirv::patch_vert, spirv::layers_frag, false, false, Blend::Sum};
  drawing.control = viewer::spirv::patch_tesc;
  drawing.evaluation = spirv::watched_patch_tese;
  pipeline_ = make_drawing(device, pass_, pipelines_.layout, drawing);
  vulkan::SolveOptions options;
  options.given = frame_.slot().given;
  options.vertices = frame_.slot().vertices;
  solve_ = std::make_unique<vulkan::Solve>(context_, model_.tables(), options);
  frame_.bind(device, model_, pipelines_, *solve_);
  std::ranges::transform(mesh.positions, frame_.points().begin(),
                         [](const glm::dvec3& p) { return glm::vec3(p); });
  device.run([&](VkCommandBuffer commands) {
    solve_->record_solve(commands, {.iterations = 0});
    solve_->record_surface(commands);
  });
}

void WatchedPatches::draw(const OrbitCamera& camera) {
  const float aspect = static_cast<float>(extent_.width) / static_cast<float>(extent_.height);
  shared::DrawParameters parameters{};
  parameters.clip_from_world = camera.clip_from_world(aspect);
  parameters.viewport = {extent_.width, extent_.height};
  parameters.face_count = model_.face_count();
  parameters.is_software = device_.is_software();
  const std::array sets{frame_.set(), frame_.surface_set()};
  const VkBuffer made = made_, byte_count = byte_count_;
  const VkDeviceSize start = 0, bytes = made_.bytes();
  device_.run([&](VkCommandBuffer commands) {
    targets_.begin(commands, 0);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_.layout, 0,
                            sets.size(), sets.data(), 0, nullptr);
    vkCmdPushConstants(commands, pipelines_.layout, push_stages(device_), 0, sizeof parameters,
                       &parameters);
    bind_(commands, 0, 1, &made, &start, &bytes);
    begin_(commands, 0, 0, nullptr, nullptr);
    for (const Model::Run& run : model_.patches())
      vkCmdDraw(commands, run.count, 1, run.first, run.end);
    end_(commands, 0, 1, &byte_count, &start);
    vkCmdEndRenderPass(commands);
    barrier(commands, kCapture, kHost);
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {extent_.width, extent_.height, 1};
    vkCmdCopyImageToBuffer(commands, image_, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, picture_, 1,
                           &region);
    host_barrier(commands);
  });
}

std::span<const PatchVertex> WatchedPatches::vertices() const {
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, byte_count_.mapped().data(), sizeof bytes);
  EXPECT_LT(bytes, made_.bytes());  // or some may be missing
  return {reinterpret_cast<const PatchVertex*>(made_.mapped().data()), bytes / sizeof(PatchVertex)};
}

std::span<const std::array<std::uint8_t, 4>> WatchedPatches::layers() const {
  return {reinterpret_cast<const std::array<std::uint8_t, 4>*>(picture_.mapped().data()),
          std::size_t{extent_.width} * extent_.height};
}

// The viewer's tessellation over many views: what is made on a border that two patches share is the
// same bits on both sides, no pixel sees through, and triangles are as near the surface as they
// should be. PLANISH_TEST_VIEWS says how many views of each mesh (a few by default).

using Patches = CaptureTest;

int view_count() {
  constexpr int kFew = 40;
  const char* views = std::getenv("PLANISH_TEST_VIEWS");
  return views ? std::atoi(views) : kFew;
}

constexpr VkExtent2D kPatchExtent{160, 120};
constexpr float kPatchAspect = 160.0f / 120.0f;

// From all sides, far and near, all of the surface before the near plane.
OrbitCamera random_view(const PolygonMesh& mesh, std::mt19937& random) {
  const auto between = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random()) / 4294967295.0f;
  };
  OrbitCamera camera = camera_around(mesh.positions);
  camera.azimuth_degrees = between(-180, 180);
  camera.elevation_degrees = between(-89, 89);
  camera.zoom = std::exp2(between(-4, 1.5f));
  return camera;
}

// What corners of a mesh share: halves of its edges, from a vertex to the middle; lines from there
// to a face's centre; and the ends of both.
class Borders {
 public:
  enum class Kind {
    Vertex,
    Middle,
    Centre,
    Half,
    Spoke,
  };
  using Key = std::tuple<Kind, std::int32_t, std::int32_t, std::int32_t>;

  explicit Borders(const PolygonMesh& mesh) : mesh_(mesh), faces_(mesh.face_vertices.size()) {
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      for (std::int32_t k = 0; k < mesh.face_size(f); ++k) faces_[mesh.face_offsets[f] + k] = f;
  }

  // Where the vertex lies, and how far along; nothing inside a patch.
  std::optional<std::pair<Key, float>> of(const PatchVertex& made) const {
    const auto corner = static_cast<std::size_t>(made.corner);
    const std::int32_t face = faces_[corner];
    const auto ring = mesh_.face(face);
    const std::size_t k = corner - static_cast<std::size_t>(mesh_.face_offsets[face]);
    const std::int32_t v = ring[k], next = ring[(k + 1) % ring.size()],
                       last = ring[(k + ring.size() - 1) % ring.size()];
    const bool low_u = made.u == 0, high_u = made.u == 1, low_v = made.v == 0, high_v = made.v == 1;
    const auto edge = [&](std::int32_t other) {
      return std::pair{std::min(v, other), std::max(v, other)};
    };
    if (low_u && low_v) return {{{Kind::Vertex, v, 0, 0}, 0.0f}};
    if (high_u && high_v) return {{{Kind::Centre, face, 0, 0}, 0.0f}};
    if (high_u && low_v) return {{{Kind::Middle, edge(next).first, edge(next).second, 0}, 0.0f}};
    if (low_u && high_v) return {{{Kind::Middle, edge(last).first, edge(last).second, 0}, 0.0f}};
    if (low_v) return {{{Kind::Half, v, next, 0}, made.u}};
    if (low_u) return {{{Kind::Half, v, last, 0}, made.v}};
    if (high_u) return {{{Kind::Spoke, face, edge(next).first, edge(next).second}, made.v}};
    if (high_v) return {{{Kind::Spoke, face, edge(last).first, edge(last).second}, made.u}};
    return {};
  }

 private:
  const PolygonMesh& mesh_;
  std::vector<std::int32_t> faces_;
};

std::array<std::uint32_t, 3> bits(const glm::vec3& p) {
  return {std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
          std::bit_cast<std::uint32_t>(p.z)};
}

// Each side's own points, by how far along.
using Side = std::map<float, std::array<std::uint32_t, 3>>;

// Both sides of each border have the same points. How many points were compared.
std::size_t expect_equal_sides(const Borders& borders, std::span<const PatchVertex> vertices) {
  std::map<Borders::Key, std::map<float, Side>> sides;
  for (const PatchVertex& made : vertices)
    if (const auto at = borders.of(made)) {
      const auto [place, is_new] =
          sides[at->first][made.corner].emplace(at->second, bits(made.position));
      EXPECT_EQ(place->second, bits(made.position)) << "corner " << made.corner;
    }
  std::size_t compared = 0;
  for (const auto& [key, by_corner] : sides) {
    EXPECT_GE(by_corner.size(), 2u);
    for (const auto& [corner, side] : by_corner) {
      compared += side.size();
      EXPECT_EQ(side, by_corner.begin()->second)
          << "corners " << by_corner.begin()->first << " and " << corner;
    }
  }
  return compared;
}

std::vector<PolygonMesh> closed_meshes() {
  return {in_floats(test::with_random_creases(test::random_closed_mesh(4), 0.15, 2)),
          in_floats(test::torus(7, 5, 2, 0.7)), in_floats(test::prism(9)),
          in_floats(test::bipyramid(36))};
}

TEST_F(Patches, NeighboursMakeTheSamePointsAndNoPixelSeesThrough) {
  std::size_t compared = 0, covered = 0;
  std::mt19937 random(1);
  for (const PolygonMesh& mesh : closed_meshes()) {
    WatchedPatches patches(*device_, mesh, kPatchExtent);
    const Borders borders(mesh);
    for (int view = 0; view < view_count() && !HasFailure(); ++view) {
      SCOPED_TRACE("view " + std::to_string(view));
      patches.draw(random_view(mesh, random));
      compared += expect_equal_sides(borders, patches.vertices());
      // Of a closed surface without a crack every sample is entered as often as it is left.
      for (const auto& pixel : patches.layers()) {
        ASSERT_EQ(pixel[0], pixel[1]);
        covered += pixel[0] > 0;
      }
    }
  }
  RecordProperty("compared", std::to_string(compared));
  RecordProperty("covered", std::to_string(covered));
  EXPECT_GT(compared, 1000u * static_cast<std::size_t>(view_count()));
  EXPECT_GT(covered, 1000u * static_cast<std::size_t>(view_count()));
}

// Points between two of a border, off their chord by this many pixels at most, seen square on.
double largest_deviation(const PlaceOracle& oracle, std::span<const PatchVertex> vertices,
                         const OrbitCamera& camera) {
  const glm::mat4 clip = camera.clip_from_world(kPatchAspect);
  const double scale =
      0.5 * kPatchExtent.height * glm::length(glm::dvec3(clip[0][1], clip[1][1], clip[2][1]));
  std::map<std::pair<float, bool>, std::map<float, glm::dvec3>> lines;
  for (const PatchVertex& made : vertices) {
    if (made.v == 0) lines[{made.corner, false}][made.u] = made.position;
    if (made.u == 1) lines[{made.corner, true}][made.v] = made.position;
  }
  double largest = 0;
  for (const auto& [line, points] : lines)
    for (auto to = std::next(points.begin()), from = points.begin(); to != points.end();
         from = to++) {
      const double t = 0.5 * (double(from->first) + double(to->first));
      const glm::dvec3 exact =
          oracle.limit
              .evaluate(surface_parameter(oracle.limit.topology(),
                                          static_cast<std::int32_t>(line.first),
                                          line.second ? 1 : t, line.second ? t : 0))
              .position;
      const double depth = (clip * glm::vec4(glm::vec3(exact), 1)).w;
      largest = std::max(largest,
                         glm::distance(exact, 0.5 * (from->second + to->second)) * scale / depth);
    }
  return largest;
}

TEST_F(Patches, AreAsFineAsTheyAreSeen) {
  const PolygonMesh mesh = in_floats(test::torus(7, 5, 2, 0.7));
  const PlaceOracle oracle(mesh, Weights::DooSabin);
  WatchedPatches patches(*device_, mesh, kPatchExtent);
  OrbitCamera camera = camera_around(mesh.positions);
  std::size_t far = 0;
  for (const float zoom : {0.05f, 0.4f, 1.0f, 3.0f}) {
    camera.zoom = zoom;
    patches.draw(camera);
    const auto vertices = patches.vertices();
    for (const PatchVertex& made : vertices)
      ASSERT_LT(
          glm::distance(glm::dvec3(made.position),
                        oracle.limit
                            .evaluate(surface_parameter(oracle.limit.topology(),
                                                        static_cast<std::int32_t>(made.corner),
                                                        double(made.u), double(made.v)))
                            .position),
          2e-6);
    // Half as much again, as an edge's depth is its nearest point's and its curve no parabola.
    EXPECT_LT(largest_deviation(oracle, vertices, camera), 1.5 * shared::kChordPixels) << zoom;
    if (zoom == 0.05f) far = vertices.size();
    if (zoom == 3.0f) {
      EXPECT_GT(vertices.size(), 4 * far);
    }
  }
}

// The viewer's own pipeline: the same picture as of a mesh of a high level, and no hole face.
TEST_F(Patches, LookAsAHighLevelDoes) {
  PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  mesh.hole_faces = {0, 7};
  HeadlessOptions options = options_for(mesh);
  options.settings.level = 4;
  std::vector<std::uint8_t> pictures[2];
  for (const bool tessellate : {false, true}) {
    options.settings.tessellate = tessellate;
    Headless headless(*device_, scene_of(mesh), options);
    headless.run(3);
    pictures[tessellate] = headless.picture();
  }
  std::size_t differ = 0;
  for (std::size_t i = 0; i < pictures[0].size(); ++i)
    differ += std::abs(pictures[0][i] - pictures[1][i]) > 6;
  // On outlines, where a quarter of a pixel may be another sample.
  EXPECT_LT(differ, pictures[0].size() / 200);
  EXPECT_NE(pictures[0], pictures[1]);
}

// While frames are in flight, to and from the fixed level.
TEST_F(Patches, CanBeHadFromFrameToFrame) {
  const PolygonMesh rest = test::torus(9, 6, 2, 0.7);
  const OwnedRenderPass pass =
      make_render_pass(*device_, {VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
  const Image image(*device_,
                    {VK_FORMAT_R8G8B8A8_UNORM, kPatchExtent, VK_SAMPLE_COUNT_1_BIT,
                     VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     VK_IMAGE_ASPECT_COLOR_BIT});
  const Targets targets(*device_, pass, VK_FORMAT_R8G8B8A8_UNORM, kPatchExtent,
                        std::array{image.view()});
  Renderer renderer(*device_, pass, scene_of(rest));
  for (int frame = 0; frame < 8; ++frame) {
    ViewSettings settings;
    settings.tessellate = frame % 3 != 1;
    settings.heat = frame % 4 == 3;
    renderer.prepare(2);
    const VkCommandBuffer commands = renderer.begin_frame(frame / 60.0, settings);
    targets.begin(commands, 0);
    renderer.draw(commands, camera_around(rest.positions), kPatchExtent, settings);
    vkCmdEndRenderPass(commands);
    renderer.end_frame();
  }
  renderer.finish();
  EXPECT_LT(renderer.status()->residual, 0.1);
}

}  // namespace
}  // namespace planish::testing
