#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <random>

#include "brep/far_surface.h"
#include "brep/step_cases.h"
#include "brep/step_checks.h"
#include "planish/brep/quad_layout.h"
#include "planish/brep/subdivision_splines.h"
#include "support/expect_error.h"

namespace planish::test {
namespace {

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
