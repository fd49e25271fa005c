#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <opensubdiv/far/patchMap.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/ptexIndices.h>

#include <array>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "brep/step_checks.h"
#include "planish/brep/quad_layout.h"
#include "planish/brep/subdivision_splines.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/solve/refiner.h"
#include "support/calls.h"

namespace planish::test {
namespace {

// A Catmull-Clark surface by OpenSubdiv's own adaptive patches.
class FarSurface {
 public:
  explicit FarSurface(const PolygonMesh& mesh)
      : topology_(mesh),
        refiner_(make_refiner(mesh, {OpenSubdiv::Sdc::SCHEME_CATMARK, {}}, topology_)),
        faces_(*refiner_) {
    namespace Far = OpenSubdiv::Far;
    constexpr int kLevels = 8;
    Far::TopologyRefiner::AdaptiveOptions adaptive(kLevels);
    adaptive.useInfSharpPatch = true;
    refiner_->RefineAdaptive(adaptive);
    Far::PatchTableFactory::Options options(kLevels);
    options.useInfSharpPatch = true;
    options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_BILINEAR_BASIS);
    table_.reset(Far::PatchTableFactory::Create(*refiner_, options));
    map_.emplace(*table_);
    points_.resize(static_cast<std::size_t>(refiner_->GetNumVerticesTotal()));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) points_[i].value = mesh.positions[i];
    const Far::PrimvarRefinerReal<double> refined(*refiner_);
    Point* from = points_.data();
    for (int level = 1; level <= refiner_->GetMaxLevel(); ++level) {
      Point* const to = from + refiner_->GetLevel(level - 1).GetNumVertices();
      refined.Interpolate(level, from, to);
      from = to;
    }
  }

  struct Place {
    glm::dvec3 position{}, normal{};  // the normal of unit length
  };
  // Of a corner's quarter of its quad, u along its leading edge; nothing where no regular patch is
  // so small.
  [[nodiscard]] std::optional<Place> at(std::int32_t corner, double u, double v) const {
    const std::int32_t face = topology_.face_of(corner), place = topology_.place_of(corner);
    const bool is_quad = topology_.face_size(face) == 4;
    double s = u, t = v;
    if (is_quad) {
      s = place == 0 ? u / 2 : place == 1 ? 1 - v / 2 : place == 2 ? 1 - u / 2 : v / 2;
      t = place == 0 ? v / 2 : place == 1 ? u / 2 : place == 2 ? 1 - v / 2 : 1 - u / 2;
    }
    const auto* const patch = map_->FindPatch(faces_.GetFaceId(face) + (is_quad ? 0 : place), s, t);
    if (patch == nullptr ||
        table_->GetPatchDescriptor(*patch).GetType() != OpenSubdiv::Far::PatchDescriptor::REGULAR)
      return {};
    std::array<double, 16> weights{}, by_s{}, by_t{};
    table_->EvaluateBasis(*patch, s, t, weights.data(), by_s.data(), by_t.data());
    const auto vertices = table_->GetPatchVertices(*patch);
    glm::dvec3 sum(0.0), ds(0.0), dt(0.0);
    for (std::size_t k = 0; k < 16; ++k) {
      const glm::dvec3& p = points_[vertices[static_cast<int>(k)]].value;
      sum += weights[k] * p;
      ds += by_s[k] * p;
      dt += by_t[k] * p;
    }
    return Place{sum, glm::normalize(glm::cross(ds, dt))};
  }

 private:
  // A primvar of OpenSubdiv's protocol.
  struct Point {
    glm::dvec3 value{0.0};
    void Clear() { value = glm::dvec3(0.0); }
    void AddWithWeight(const Point& other, double weight) { value += weight * other.value; }
  };

  MeshTopology topology_;
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
  OpenSubdiv::Far::PtexIndices faces_;
  std::unique_ptr<const OpenSubdiv::Far::PatchTable> table_;
  std::optional<OpenSubdiv::Far::PatchMap> map_;
  std::vector<Point> points_;
};

std::vector<NamedMesh> cages() {
  std::vector<NamedMesh> meshes = step_meshes();
  PolygonMesh slight = cube();
  slight.creases = {{0, 1, 0.6f}, {1, 3, 1.0f}, {3, 2, 0.3f}};
  slight.corners = {{4, 0.5f}};
  meshes.push_back({"creases of one step", slight});
  return meshes;
}

// What is sharp for more than a step and not for good.
bool is_semi_sharp(const PolygonMesh& mesh) {
  const auto is_semi = [](float s) { return s > 1 && s < kInfiniteSharpness; };
  return std::ranges::any_of(mesh.creases, [&](const auto& c) { return is_semi(c.sharpness); }) ||
         std::ranges::any_of(mesh.corners, [&](const auto& c) { return is_semi(c.sharpness); });
}

struct Places {
  int count = 0;
  double apart = 0;    // of the diagonal
  double outside = 0;  // the same along normals
};

// Of faces, against OpenSubdiv's regular patches: off squares of that size at V and F.
Places compare(const PolygonMesh& mesh, const BrepOptions& options, double square,
               const CatmullClarkSplines& splines, const Brep& brep) {
  const FarSurface exact(mesh);
  const QuadLayout layout(splines, options.face_size);
  Places places;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> within(0, 1);
  for (std::size_t f = 0; f < brep.faces.size(); ++f) {
    const QuadLayout::Rectangle& cells = layout.rectangles()[f];
    for (int k = 0; k < 24; ++k) {
      // Half of them near a corner of the face.
      glm::dvec2 at(within(random) * cells.width, within(random) * cells.height);
      if (k % 2 == 0) {
        const double near = std::ldexp(1.0, -k / 4);
        const double x = near * within(random), y = near * within(random);
        at = {k % 4 == 0 ? x : cells.width - x, k % 8 < 4 ? y : cells.height - y};
      }
      const auto i = std::min(static_cast<std::int32_t>(at.x), cells.width - 1);
      const auto j = std::min(static_cast<std::int32_t>(at.y), cells.height - 1);
      const QuadLayout::Cell& cell = cells.cell(i, j);
      glm::dvec2 uv(at.x - i, at.y - j);
      for (int turn = 0; turn < cell.turn; ++turn) uv = {1 - uv.y, uv.x};
      if (std::max(uv.x, uv.y) < square || std::min(uv.x, uv.y) > 1 - square) continue;
      const auto there = exact.at(cell.corner, uv.x, uv.y);
      if (!there) continue;
      const glm::dvec3 apart =
          (point_of(brep, brep.faces[f], at) - there->position) / splines.placement().diagonal;
      ++places.count;
      places.apart = std::max(places.apart, glm::length(apart));
      places.outside = std::max(places.outside, std::abs(glm::dot(apart, there->normal)));
    }
  }
  return places;
}

TEST(CatmullClarkStep, IsOpenSubdivsSurfaceOffTheSquaresAtExtraordinaryPoints) {
  int count = 0;
  for (const auto& [name, mesh] : cages()) {
    SCOPED_TRACE(name);
    if (is_semi_sharp(mesh)) continue;
    const CatmullClarkSplines splines(mesh, {});
    const BrepOptions options{.angle = 90, .deviation = 1};
    const Brep brep = make_brep(splines, options);
    if (brep.moved > 0) continue;  // squares of twice the size are changed
    const Places places = compare(mesh, options, 0.5, splines, brep);
    EXPECT_GT(places.count, 0);
    EXPECT_LE(places.apart, 1e-12);
    ++count;
  }
  EXPECT_GT(count, 40);
}

// OpenSubdiv's patches reach to 2^-8 of a quad of the mesh from extraordinary points.
TEST(CatmullClarkStep, KeepsTheTolerance) {
  for (const PolygonMesh& mesh : {cube(), icosphere(1), prism(5), torus(7, 5, 3, 1), bipyramid(9),
                                  random_closed_mesh(3), random_open_mesh(2)}) {
    const CatmullClarkSplines splines(mesh, {});
    const BrepOptions options{.angle = 90, .deviation = 1e-5};
    const Brep brep = make_brep(splines, options);
    const Places places = compare(mesh, options, 0, splines, brep);
    EXPECT_GT(places.count, 0);
    EXPECT_LE(brep.max_deviation, 1e-5);
    EXPECT_LE(places.outside, 1.5 * brep.max_deviation + 1e-12);
  }
}

TEST(CatmullClarkStep, FacesMeetAlongEdges) {
  for (const auto& [name, mesh] : cages()) {
    SCOPED_TRACE(name);
    if (is_semi_sharp(mesh)) continue;
    const CatmullClarkSplines splines(mesh, {});
    const Brep brep = make_brep(splines, {.angle = 2, .deviation = 1e-4});
    write_step(scratch("cubic.step"), brep, {.diagonal = splines.placement().diagonal});
    const StepFile file(scratch("cubic.step"));
    const auto border_count =
        std::ranges::count_if(brep.edges, [](const Brep::Edge& e) { return e.lines[1].face < 0; });
    double size = splines.placement().diagonal;
    for (const glm::dvec3& p : brep.vertices) size = std::max(size, glm::length(p));
    expect_joined(file, 1e-12 * size, 1e-9 * size, border_count);
    expect_loops(file);
    const auto count = [&](const char* keyword) { return std::ssize(file.all(keyword)); };
    EXPECT_EQ(count("VERTEX_POINT") - count("EDGE_CURVE") + count("ADVANCED_FACE"),
              euler_number(splines.topology(), splines.hidden()));
    for (const std::int64_t id : file.all("B_SPLINE_SURFACE_WITH_KNOTS")) {
      ASSERT_EQ(file.at(id).values[1].number(), 3);
      ASSERT_EQ(file.at(id).values[2].number(), 3);
    }
  }
}

TEST(CatmullClarkStep, NormalsAgreeAcrossSmoothEdges) {
  for (const PolygonMesh& mesh : {cube(), torus(7, 5, 3, 1), icosphere(1), prism(5)}) {
    const Brep brep = make_brep(CatmullClarkSplines(mesh, {}), {});
    EXPECT_LE(brep.max_angle, 0.25);
    EXPECT_LE(brep.max_deviation, 1e-6);
    write_step(scratch("cubic_angles.step"), brep, {});
    EXPECT_LE(worst_jump(StepFile(scratch("cubic_angles.step"))), 0.26);
  }
}

// Where no point of the mesh is extraordinary, the only knots are lines of the mesh, every other
// one of M_1.
TEST(CatmullClarkStep, RegularPartsNeedNoFurtherKnots) {
  const Brep brep = make_brep(CatmullClarkSplines(torus(12, 8, 3, 1), {}), {});
  EXPECT_EQ(brep.extraordinary, 0);
  for (const Brep::Face& face : brep.faces) {
    for (const auto& knots : {face.knots_u, face.knots_v})
      for (std::size_t k = 2; k + 1 < knots.size(); ++k) EXPECT_EQ(knots[k] - knots[k - 1], 2);
  }
}

TEST(CatmullClarkStep, HasTheSameBytesOnEveryNumberOfThreads) {
  const PolygonMesh mesh = random_closed_mesh(7);
  std::array<std::string, 2> bytes;
  for (const std::size_t i : {0u, 1u}) {
    const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                              i == 0 ? 1 : 4);
    write_step(scratch("cubic_threads.step"), make_brep(CatmullClarkSplines(mesh, {})), {});
    bytes[i] = bytes_of(scratch("cubic_threads.step"));
  }
  EXPECT_TRUE(bytes[0] == bytes[1]);
  EXPECT_GT(bytes[0].size(), 100'000u);
}

TEST(CatmullClarkStep, CreasesThatAreSharpForSomeStepsAreRefused) {
  PolygonMesh mesh = cube();
  mesh.creases = {{0, 1, 2.5f}};
  const std::string message =
      message_of(ErrorCode::UnusableMesh, [&] { (void)CatmullClarkSplines(mesh, {}); });
  EXPECT_NE(message.find("the edge between vertices 0 and 1 has sharpness 2.5"), std::string::npos)
      << message;
  mesh.creases.clear();
  mesh.corners = {{3, 2.0f}};
  EXPECT_NE(message_of(ErrorCode::UnusableMesh, [&] { (void)CatmullClarkSplines(mesh, {}); })
                .find("vertex 3 has sharpness 2"),
            std::string::npos);
}

}  // namespace
}  // namespace planish::test
