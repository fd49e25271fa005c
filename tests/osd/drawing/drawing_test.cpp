// Patches drawn by planish_osd_patches.glsl: what the tessellation made lies where
// Osd::CpuEvaluator has it, and neighbours meet.
#include <gtest/gtest.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <random>
#include <set>
#include <string>

#include "osd/drawing/borders.h"
#include "planish/osd/vk_patch_shader_source.h"
#include "viewer/fixture.h"

namespace planish::testing {
namespace {

using namespace OpenSubdiv;
using Far::PatchDescriptor;
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

/// The same places by Osd::CpuEvaluator, of the device's points.
struct Expected {
  std::vector<glm::vec3> positions, du, dv;

  Expected(const DrawnMesh& mesh, const std::vector<DrawnVertex>& vertices,
           osd::VkDeviceContext& target)
      : positions(vertices.size()), du(vertices.size()), dv(vertices.size()) {
    const std::vector<Patch> patches = patches_of(*mesh.refined.patches);
    std::vector<Osd::PatchCoord> coords;
    for (const DrawnVertex& vertex : vertices) {
      const Patch& patch = patches.at(static_cast<std::size_t>(vertex.patch));
      float s = vertex.u, t = vertex.v;
      if (is_triangle(patch.type))
        patch.param.UnnormalizeTriangle(s, t);
      else
        patch.param.Unnormalize(s, t);
      coords.emplace_back(patch.handle, s, t);
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

/// What the patches were.
struct Seen {
  std::set<int> types;
  int transitions = 0, boundaries = 0, rotated = 0;

  void add(const Far::PatchTable& table) {
    for (const Patch& patch : patches_of(table)) {
      types.insert(patch.type);
      transitions += patch.param.GetTransition() != 0;
      boundaries += patch.param.GetBoundary() != 0;
      rotated += is_triangle(patch.type) && patch.param.IsTriangleRotated();
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

/// The same with faces that begin at any of their corners, and points a little elsewhere.
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
