#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <span>
#include <sstream>
#include <string>

#include "make_scenes/models.h"
#include "make_scenes/scene_list.h"
#include "planish/core/error.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/check.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/statistics.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/level_one_mesh.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish::shapes {
namespace {

const std::filesystem::path kFolder = PLANISH_SCENES;

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << "cannot read " << path << "; run planish-make-scenes scenes";
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// EXPECT_EQ would print megabytes.
void expect_same(const std::filesystem::path& path, const std::string& made) {
  const std::string committed = bytes_of(path);
  const auto [at, unused] =
      std::mismatch(committed.begin(), committed.end(), made.begin(), made.end());
  EXPECT_TRUE(committed == made) << path << " differs from what the generator makes at byte "
                                 << at - committed.begin() << " of " << committed.size();
}

TEST(CommittedFiles, AreWhatTheGeneratorMakesAndNoOthers) {
  const std::string readme = bytes_of(kFolder / "README.md");
  std::set<std::string> made{kScanFile};
  for (const Scene& scene : scenes()) {
    expect_same(kFolder / scene.file, scene_text(scene));
    made.insert(scene.file);
  }
  for (const BadFile& bad : bad_files()) {
    expect_same(kFolder / "bad" / bad.file, bad.bytes);
    made.insert("bad/" + bad.file);
  }
  for (const std::string& file : made) {
    const std::string name = std::filesystem::path(file).filename();
    EXPECT_NE(readme.find("`" + name + "`"), std::string::npos) << file << " is not in README.md";
  }
  // Not below: scenes/out/ holds what runs of the scene files wrote.
  for (const auto& folder : {kFolder, kFolder / "bad"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().lexically_relative(kFolder).generic_string();
      if (entry.path().extension() == ".obj" || name.starts_with("bad/")) {
        EXPECT_TRUE(made.contains(name)) << "scenes/" << name << " is made by nothing";
      }
    }
  }
}

// It needs a mesher and follows every change of the simplifier, so it is not made anew here.
TEST(CommittedFiles, TheScanIsAClosedMeshOfUnevenTrianglesOnTheRockerArm) {
  const std::string bytes = bytes_of(kFolder / kScanFile);
  const PolygonMesh mesh =
      read_mesh(std::as_bytes(std::span(bytes)), kScanFile, FileFormat::Obj).mesh;
  EXPECT_TRUE(check(mesh).empty());
  const MeshStatistics facts = statistics(mesh);
  EXPECT_EQ(facts.boundary_loop_count, 0);
  EXPECT_EQ(facts.genus, 1);
  EXPECT_EQ(facts.component_count, 1);
  EXPECT_EQ(2 * facts.vertex_count, facts.face_count);  // triangles only
  for (const glm::dvec3& p : mesh.positions) EXPECT_LT(std::abs(rocker_arm_field(p)), 2e-6);
}

MeshFile read(const BadFile& bad) {
  return read_mesh(std::as_bytes(std::span(bad.bytes)), bad.file, *format_of(bad.file));
}

TEST(BadFiles, HaveTheProblemThatTheyAreNamedFor) {
  const std::map<std::string, MeshProblemKind> kinds{
      {"no_faces.obj", MeshProblemKind::NoFaces},
      {"empty.obj", MeshProblemKind::NoFaces},
      {"two_corners.obj", MeshProblemKind::FaceTooSmall},
      {"repeated_corner.obj", MeshProblemKind::RepeatedCorner},
      {"duplicate_face.obj", MeshProblemKind::DuplicateFace},
      {"inconsistent_winding.obj", MeshProblemKind::InconsistentWinding},
      {"non_manifold_edge.obj", MeshProblemKind::NonManifoldEdge},
      {"non_manifold_vertex.obj", MeshProblemKind::NonManifoldVertex},
      {"crease_without_edge.obj", MeshProblemKind::UnknownCreaseEdge}};
  for (const BadFile& bad : bad_files()) {
    SCOPED_TRACE(bad.file);
    if (bad.exit_code == 3) {
      EXPECT_NE(
          test::message_of(ErrorCode::UnreadableInput, [&] { (void)read(bad); }).find(bad.file),
          std::string::npos);
      continue;
    }
    const auto problems = check(read(bad).mesh);
    if (bad.exit_code == 0) {
      EXPECT_TRUE(problems.empty());
    } else {
      EXPECT_TRUE(std::ranges::any_of(problems, [&](const MeshProblem& problem) {
        return problem.kind == kinds.at(bad.file);
      })) << problems.size();
    }
  }
}

}  // namespace
}  // namespace planish::shapes

namespace planish {
namespace {

// From a file with attributes through the fit to the surface, and through the cage's file to the
// same surface.

PolygonMesh scene(const std::string& file) {
  return read_mesh(std::filesystem::path(PLANISH_SCENES) / file).mesh;
}

// The cell of the 3 x 2 charts that a texture coordinate lies in, -1 where it lies in none: as far
// past its border as the surface goes past the edges of the cube, 0.5 % of a side.
int chart_of(const glm::dvec2& uv) {
  const glm::dvec2 cell(std::floor(3 * uv.x), std::floor(2 * uv.y));
  const glm::dvec2 inside(3 * uv.x - cell.x, 2 * uv.y - cell.y);
  constexpr double kMargin = 0.05 - 0.005;
  const bool is_in =
      glm::min(inside.x, inside.y) > kMargin && glm::max(inside.x, inside.y) < 1 - kMargin;
  return is_in ? static_cast<int>(cell.x + 3 * cell.y) : -1;
}

TEST(MappedShapes, EveryFaceOfTheSurfaceStaysInItsChartAndGroup) {
  const PolygonMesh mesh = scene("mapped_cube.obj");
  const auto backend = make_cpu_backend();
  const Fit result = fit(mesh, *backend);
  for (int level = 0; level <= 2; ++level) {
    const SurfaceMesh surface =
        evaluate(result.cage, *backend, {.level = level, .rest_positions = mesh.positions});
    ASSERT_EQ(surface.face_uvs.size(), surface.face_vertices.size());
    ASSERT_EQ(surface.colors.size(), surface.positions.size());
    std::array<int, 6> faces{};
    for (std::int64_t face = 0; face < surface.face_count(); ++face) {
      const int chart = chart_of(surface.uvs[surface.face_uvs[4 * face]]);
      ASSERT_GE(chart, 0) << face;
      ++faces[chart];
      for (int i = 1; i < 4; ++i)
        EXPECT_EQ(chart_of(surface.uvs[surface.face_uvs[4 * face + i]]), chart) << face;
      const FaceGroup& group = surface.groups[surface.face_groups[face]];
      EXPECT_EQ(group.material, chart >= 4 ? "brass" : "plaster");
    }
    for (const int count : faces) EXPECT_EQ(count, 16 << (2 * level));
  }
}

PolygonMesh written_and_read(const PolygonMesh& cage) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "cage.obj";
  write_mesh(path, FileFormat::Obj, cage);
  return read_mesh(path).mesh;
}

TEST(MappedShapes, TheCagesFileGivesTheSameSurface) {
  const auto backend = make_cpu_backend();
  for (const char* file : {"mapped_cube.obj", "cube_with_windows.obj", "bearing_block.obj"}) {
    const PolygonMesh mesh = scene(file);
    const PolygonMesh cage = fit(mesh, *backend).cage;
    const PolygonMesh again = written_and_read(cage);
    EXPECT_EQ(again.hole_faces, cage.hole_faces);
    const EvaluateOptions options{.level = 2, .rest_positions = mesh.positions};
    const SurfaceMesh first = evaluate(cage, *backend, options);
    const SurfaceMesh second = evaluate(again, *backend, options);
    EXPECT_EQ(first.face_vertices, second.face_vertices);
    EXPECT_EQ(first.face_uvs, second.face_uvs);
    EXPECT_EQ(first.face_groups, second.face_groups);
    EXPECT_EQ(first.colors, second.colors);
    ASSERT_EQ(first.positions.size(), second.positions.size());
    ASSERT_EQ(first.uvs.size(), second.uvs.size());
    for (std::size_t i = 0; i < first.positions.size(); ++i)
      EXPECT_LE(glm::distance(first.positions[i], second.positions[i]), 1e-12);
    for (std::size_t i = 0; i < first.uvs.size(); ++i)
      EXPECT_LE(glm::distance(first.uvs[i], second.uvs[i]), 1e-12);
  }
}

double area_of(const SurfaceMesh& surface) {
  double area = 0;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    area += glm::length(area_vector(surface.positions, surface.face(f)));
  }
  return area;
}

TEST(MappedShapes, AFairCagesFileGivesTheSameSurface) {
  const auto backend = make_cpu_backend();
  for (const char* file : {"mapped_cube.obj", "cube_with_windows.obj", "bearing_block.obj"}) {
    const PolygonMesh mesh = scene(file);
    const Fit fitted = fit(mesh, *backend, {.method = InterpolationMethod::Fair});
    const PolygonMesh cage = written_and_read(control_cage(mesh, fitted, {}));
    const LevelOne again = level_one_of_cage(mesh, cage, {});
    const SurfaceMesh direct = evaluate(mesh, fitted, *backend, {.level = 2});
    const SurfaceMesh surface = evaluate(mesh, again, *backend, {.level = 2});
    EXPECT_EQ(surface.face_vertices, direct.face_vertices);
    EXPECT_EQ(surface.face_uvs, direct.face_uvs);
    ASSERT_EQ(surface.uvs.size(), direct.uvs.size());
    for (std::size_t i = 0; i < direct.uvs.size(); ++i)
      EXPECT_LE(glm::distance(surface.uvs[i], direct.uvs[i]), 1e-14);
    ASSERT_EQ(surface.positions.size(), direct.positions.size());
    for (std::size_t i = 0; i < direct.positions.size(); ++i)
      EXPECT_LE(glm::distance(surface.positions[i], direct.positions[i]), 1e-12);
    EXPECT_NEAR(area_of(surface), area_of(direct), 1e-12 * area_of(direct));
    // The progressive method's attributes, as near as the surfaces are.
    const SurfaceMesh progressive = evaluate(mesh, fit(mesh, *backend), *backend, {.level = 2});
    EXPECT_EQ(direct.face_uvs, progressive.face_uvs);
    ASSERT_EQ(direct.uvs.size(), progressive.uvs.size());
    for (std::size_t i = 0; i < direct.uvs.size(); ++i)
      EXPECT_LE(glm::distance(direct.uvs[i], progressive.uvs[i]), 5e-4);
    EXPECT_EQ(direct.face_count(), progressive.face_count());
  }
}

// By itself, refined as any Doo-Sabin cage: the second level of the surface is its first.
TEST(MappedShapes, AFairCageCarriesItsCharts) {
  const PolygonMesh mesh = scene("mapped_cube.obj");
  const auto backend = make_cpu_backend();
  const Fit fitted = fit(mesh, *backend, {.method = InterpolationMethod::Fair});
  const PolygonMesh cage = written_and_read(control_cage(mesh, fitted, {}));
  const SurfaceMesh direct = evaluate(mesh, fitted, *backend, {.level = 2});
  const SurfaceMesh surface = evaluate(cage, *backend, {.level = 1});
  ASSERT_EQ(surface.positions.size(), direct.positions.size());
  ASSERT_EQ(surface.face_count(), direct.face_count());
  // Where the surface has its texture coordinates, by place.
  const auto key = [](const glm::dvec3& p) {
    return std::array{std::llround(p.x * 1e9), std::llround(p.y * 1e9), std::llround(p.z * 1e9)};
  };
  std::multimap<std::array<long long, 3>, glm::dvec2> given;
  for (std::size_t c = 0; c < direct.face_vertices.size(); ++c) {
    given.emplace(key(direct.positions[direct.face_vertices[c]]), direct.uvs[direct.face_uvs[c]]);
  }
  std::int64_t apart = 0;
  for (std::size_t c = 0; c < surface.face_vertices.size(); ++c) {
    const auto [first, last] = given.equal_range(key(surface.positions[surface.face_vertices[c]]));
    ASSERT_NE(first, last) << c;
    const glm::dvec2 uv = surface.uvs[surface.face_uvs[c]];
    apart += std::none_of(
        first, last, [&](const auto& entry) { return glm::distance(entry.second, uv) < 0.01; });
  }
  // The net's coordinates are linear in the faces' parameters, the surface's are not: a thirtieth
  // of a chart. Only across seams is one chart continued where the surface has the other: a ring of
  // quads around each of twelve edges of four faces.
  EXPECT_LT(static_cast<double>(apart) / static_cast<double>(surface.face_vertices.size()), 0.1);
}

TEST(MappedShapes, AFairCagesHolesCoverTheWindows) {
  const PolygonMesh mesh = scene("cube_with_windows.obj");
  const auto backend = make_cpu_backend();
  const Fit fitted = fit(mesh, *backend, {.method = InterpolationMethod::Fair});
  const PolygonMesh cage = written_and_read(control_cage(mesh, fitted, {}));
  ASSERT_FALSE(cage.hole_faces.empty());
  const SurfaceMesh holed = evaluate(mesh, fitted, *backend, {.level = 4});
  PolygonMesh closed = mesh;
  closed.hole_faces.clear();
  const double windows =
      area_of(evaluate(closed, fitted.fair->level_one, *backend, {.level = 4})) - area_of(holed);
  double tagged = 0;
  for (const std::int32_t f : cage.hole_faces)
    tagged += glm::length(area_vector(cage.positions, cage.face(f)));
  // A net lies a little outside its surface.
  EXPECT_NEAR(tagged / windows, 1.0, 0.05);
}

TEST(MappedShapes, WindowsStayOpen) {
  const PolygonMesh mesh = scene("cube_with_windows.obj");
  ASSERT_EQ(mesh.hole_faces.size(), 6u);
  const auto backend = make_cpu_backend();
  const SurfaceMesh surface = evaluate(mesh, *backend, {.level = 1});
  EXPECT_EQ(surface.face_count(), 4 * 48);
  for (std::int64_t face = 0; face < surface.face_count(); ++face) {
    glm::dvec3 centre(0.0);
    for (const std::int32_t v : surface.face(face)) centre += surface.positions[v] / 4.0;
    // Windows are seen from the middle of the cube along the axes.
    int small_count = 0;
    for (int axis = 0; axis < 3; ++axis) small_count += std::abs(centre[axis]) < 0.3 ? 1 : 0;
    EXPECT_LT(small_count, 2) << face;
  }
}

}  // namespace
}  // namespace planish
