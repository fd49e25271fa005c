#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "planish/core/error.h"
#include "planish/measure/figures.h"
#include "planish/mesh/sound_topology.h"
#include "planish/patches/patch_mesh.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/calls.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// Largest distance of a vertex from the cage's limit surface, relative to the diagonal.
double interpolation_error(const PolygonMesh& given, const Fit& fit, const FitOptions& options) {
  const auto limits = limit_positions(fit.cage, options.weights, options.sharp);
  double largest = 0;
  for (std::size_t v = 0; v < limits.size(); ++v) {
    largest = std::max(largest, glm::length(limits[v] - given.positions[v]));
  }
  return largest / fit.placement.diagonal;
}

TEST(Fit, SurfacePassesThroughEveryVertex) {
  for (const PolygonMesh& mesh :
       {test::cube(), test::dodecahedron(), test::prism(9), test::plate_with_hole(5),
        test::l_shaped_plate(3), test::jittered(test::icosphere(2), 0.1, 4)}) {
    for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
      FitOptions options;
      options.weights = weights;
      options.tolerance = 1e-12;
      const Fit result = fit(mesh, *make_cpu_backend(), options);
      EXPECT_TRUE(result.interpolation.converged);
      EXPECT_LT(interpolation_error(mesh, result, options), 1.01e-12);
      EXPECT_EQ(result.cage.face_vertices, mesh.face_vertices);
    }
  }
}

TEST(Fit, FarFromTheOriginInFloatReachesTheTolerance) {
  PolygonMesh mesh = test::icosphere(2);
  for (auto& p : mesh.positions) p += glm::dvec3(20.0, -20.0, 20.0);
  FitOptions options;
  options.tolerance = 2e-9;
  const Fit result = fit(mesh, *make_cpu_backend({Precision::Float}), options);
  EXPECT_TRUE(result.interpolation.converged);
  EXPECT_LT(interpolation_error(mesh, result, options), 2.1e-9);
}

TEST(Fit, LeavesUnusedVerticesWhereTheyAre) {
  PolygonMesh mesh = test::cube();
  mesh.positions.push_back({50, 60, 70});
  const Fit result = fit(mesh, *make_cpu_backend());
  EXPECT_EQ(result.cage.positions.back(), glm::dvec3(50, 60, 70));
  const Fit plain = fit(test::cube(), *make_cpu_backend());
  for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(result.cage.positions[v], plain.cage.positions[v]);
}

TEST(Fit, NamesTheWorstVertexOfTheGivenMesh) {
  PolygonMesh mesh = test::jittered(test::icosphere(1), 0.2, 5);
  mesh.positions.insert(mesh.positions.begin(), 3, glm::dvec3(0.0));
  for (std::int32_t& v : mesh.face_vertices) v += 3;
  FitOptions options;
  options.max_iterations = 3;
  options.tolerance = 1e-12;
  const Fit result = fit(mesh, *make_cpu_backend({Precision::Double}), options);
  const auto limits = limit_positions(result.cage, options.weights, options.sharp);
  std::vector<double> errors;
  for (std::size_t v = 0; v < limits.size(); ++v)
    errors.push_back(glm::length(limits[v] - mesh.positions[v]));
  const auto worst = std::ranges::max_element(errors);
  EXPECT_EQ(result.interpolation.worst_vertex, worst - errors.begin());
  EXPECT_NEAR(result.interpolation.error.max, *worst / result.placement.diagonal, 1e-12);
}

// Before anything is solved, and by the mesh's own numbers.
TEST(Fit, RefusesRingsWhoseSquareAveragedWeightsWouldTake) {
  FitOptions options;
  options.weights = Weights::Averaged;
  PolygonMesh hub = test::bipyramid(kLargestByPoints + 1);
  hub.positions.insert(hub.positions.begin(), 2, glm::dvec3(0.5));  // in no face
  for (std::int32_t& v : hub.face_vertices) v += 2;
  const auto said = [&](const PolygonMesh& mesh) {
    return test::message_of(ErrorCode::UnusableMesh,
                            [&] { (void)fit(mesh, *make_cpu_backend(), options); });
  };
  EXPECT_THAT(said(hub),
              testing::ContainsRegex("^vertex [0-9]+ has 1025 faces, averaged weights take 1024 "
                                     "at most; doo-sabin weights take more$"));
  EXPECT_EQ(said(test::prism(kLargestByPoints + 1)).substr(0, 24), "face 0 has 1025 corners,");
  // What is evaluated has as many: no cage gets round it.
  EXPECT_THROW((void)evaluate(hub, *make_cpu_backend(), {.weights = Weights::Averaged}), Error);
  const MeshTopology largest(test::bipyramid(kLargestByPoints));
  EXPECT_EQ(ring_columns(largest, Weights::Averaged), RingColumns::Points);
  options.weights = Weights::DooSabin;
  EXPECT_TRUE(fit(hub, *make_cpu_backend(), options).interpolation.converged);
}

TEST(Fit, ConjugateGradientsOnAnOpenMeshIsAUsageError) {
  FitOptions options;
  options.solver = Solver::ConjugateGradients;
  try {
    (void)fit(test::flat_grid(3, 3), *make_cpu_backend(), options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_NE(std::string(error.what()).find("12 boundary or crease edges"), std::string::npos)
        << error.what();
  }
}

TEST(Fit, WarnsOfSemiSharpCreases) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1, 2.5f}};
  std::vector<Warning> warnings;
  FitOptions options;
  options.callbacks.warning = [&](const Warning& w) { warnings.push_back(w); };
  (void)fit(mesh, *make_cpu_backend(), options);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "semi-sharp-creases");
  EXPECT_NE(warnings[0].message.find("edge 0-1"), std::string::npos) << warnings[0].message;
}

TEST(Fit, ACubeWithAllEdgesTaggedIsItsOwnSurface) {
  PolygonMesh mesh = test::cube();
  for (const auto& [a, b] : {std::pair{0, 1},
                             {1, 3},
                             {3, 2},
                             {2, 0},
                             {4, 5},
                             {5, 7},
                             {7, 6},
                             {6, 4},
                             {0, 4},
                             {1, 5},
                             {2, 6},
                             {3, 7}}) {
    mesh.creases.push_back({a, b, kInfiniteSharpness});
  }
  const Fit result = fit(mesh, *make_cpu_backend());
  EXPECT_EQ(result.interpolation.iterations, 0);
  EXPECT_EQ(result.corner_count, 8);
  const SurfaceMesh surface = evaluate(result.cage, *make_cpu_backend(), {.level = 4});
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const glm::dvec3& p = surface.positions[v];
    EXPECT_NEAR(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}), 1.0, 1e-12);
    // One of the planes through the point has this normal.
    const glm::dvec3 normal(surface.normals[v]);
    EXPECT_NEAR(glm::dot(normal, p), 1.0, 1e-6);
    EXPECT_NEAR(std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)}), 1.0, 1e-6);
  }
}

// What happens to a mesh that anybody made: warnings, numbers of the file, where it lies.

// Every face with corners of its own: nothing is joined before it is welded.
PolygonMesh with_faces_apart(const PolygonMesh& mesh) {
  PolygonMesh apart = mesh;
  apart.positions.clear();
  for (std::int32_t& v : apart.face_vertices) {
    apart.positions.push_back(mesh.positions[v]);
    v = static_cast<std::int32_t>(apart.positions.size()) - 1;
  }
  return apart;
}

PolygonMesh together(const PolygonMesh& a, const PolygonMesh& b) {
  PolygonMesh mesh = a;
  for (std::int32_t face = 0; face < b.face_count(); ++face) {
    for (const std::int32_t v : b.face(face)) mesh.face_vertices.push_back(v + a.vertex_count());
    mesh.face_offsets.push_back(static_cast<std::int32_t>(mesh.face_vertices.size()));
  }
  mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
  return mesh;
}

// Both methods have meshes of their own, each mended.
TEST(FitMesh, TellsAWarningOfBothMeshesOnce) {
  PolygonMesh mesh = test::jittered(test::icosphere(2), 0.3, 1);
  std::swap(mesh.face_vertices[1], mesh.face_vertices[2]);
  std::vector<Warning> heard;
  MeshFitOptions options;
  options.crease_degrees = 60;
  options.fit.callbacks.warning = [&](const Warning& warning) { heard.push_back(warning); };
  const FittedMesh fitted = fit_mesh(mesh, "ball", *make_cpu_backend(), options);
  ASSERT_EQ(fitted.options.method, InterpolationMethod::Fair);
  const auto mended = std::ranges::count_if(
      heard, [](const Warning& warning) { return warning.message.starts_with("ball: "); });
  EXPECT_EQ(mended, 1) << heard.front().message;
  ASSERT_EQ(fitted.warnings.size(), heard.size());
  for (std::size_t i = 0; i < heard.size(); ++i)
    EXPECT_EQ(fitted.warnings[i].message, heard[i].message);
}

TEST(MakeReady, NamesVerticesOfTheFileWhereItWelds) {
  PolygonMesh second = test::cube();
  for (glm::dvec3& p : second.positions) p += glm::dvec3(2);
  PolygonMesh first = test::cube();
  for (glm::dvec3& p : first.positions) p -= glm::dvec3(9);
  const PolygonMesh mesh = with_faces_apart(together(together(first, test::cube()), second));
  ReadyMesh ready = make_ready(PolygonMesh(mesh), {.weld = 1e-6});
  ASSERT_TRUE(ready.prepared);
  EXPECT_EQ(ready.mesh.vertex_count(), 24);
  ASSERT_EQ(ready.changes.size(), 1u);
  EXPECT_THAT(ready.changes[0].code, ::testing::StartsWith("non-manifold"));
  ASSERT_GE(ready.changes[0].first, 0);
  EXPECT_EQ(mesh.positions[ready.changes[0].first], glm::dvec3(1)) << "where the cubes touch";
  for (std::int32_t v = 0; v < 24; ++v)
    EXPECT_EQ(mesh.positions[ready.source_vertices[v]], ready.mesh.positions[v]);
}

// A cube of which each corner was bevelled by nothing: three vertices at its place and a triangle.
PolygonMesh bevelled_by_nothing(double length) {
  const PolygonMesh sharp = test::cube();
  PolygonMesh mesh;
  for (const std::int32_t v : sharp.face_vertices) {
    const auto i = static_cast<double>(mesh.positions.size());
    mesh.positions.push_back(sharp.positions[v] + length * glm::dvec3(std::sin(i), std::cos(i), 0));
  }
  const MeshTopology topology = usable_topology(sharp, "cube");
  std::vector<std::int32_t> corner(4);
  for (std::int32_t f = 0; f < sharp.face_count(); ++f) {
    for (int k = 0; k < 4; ++k) corner[k] = topology.first_corner(f) + k;
    mesh.add_face(corner);
  }
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
    const std::int32_t twin = topology.twin(c);
    if (twin > c) mesh.add_face(std::array{topology.next(c), c, topology.next(twin), twin});
  }
  for (std::int32_t v = 0; v < sharp.vertex_count(); ++v) {
    const auto around = topology.corners_at(v);
    mesh.add_face(std::array{around[0], around[1], around[2]});
  }
  return mesh;
}

TEST(MakeReady, MakesTheEndsOfEdgesWithoutLengthOne) {
  const PolygonMesh sharp = test::cube();
  for (const double length : {0.0, 1e-7}) {
    const PolygonMesh mesh = bevelled_by_nothing(length);
    const ReadyMesh ready = make_ready(PolygonMesh(mesh), {});
    ASSERT_EQ(ready.mesh.vertex_count(), 8) << length;
    EXPECT_EQ(ready.mesh.face_count(), 6) << length;
    EXPECT_EQ(ready.welded_count, 16) << length;
    ASSERT_FALSE(ready.changes.empty());
    EXPECT_EQ(ready.changes.front().code, "short-edges");
    EXPECT_EQ(ready.changes.front().count, 16);
    EXPECT_GE(ready.changes.front().first, 1);
    // Numbers are the file's.
    ASSERT_EQ(ready.source_vertices.size(), 8u);
    for (std::int32_t v = 0; v < 8; ++v)
      EXPECT_EQ(ready.mesh.positions[v], mesh.positions[ready.source_vertices[v]]);
    EXPECT_EQ(make_ready(PolygonMesh(mesh), {.repairs = false}).mesh.vertex_count(), 24);
    EXPECT_EQ(make_ready(PolygonMesh(mesh), {.stands_alone = false}).mesh.vertex_count(), 24);
  }
  // Bevelled by more it is as it was.
  EXPECT_EQ(make_ready(bevelled_by_nothing(1e-4), {}).mesh.vertex_count(), 24);
}

// A box in triangles, on one side around a point of an edge: there the triangulation of that side
// has a triangle without area. Its normal tells of no crease.
// A texture for both halves of a plate: along their border each has coordinates of its own.
TEST(MakeReady, CutsMirroredCharts) {
  PolygonMesh mesh = test::flat_grid(4, 2);
  mesh.face_uvs = mesh.face_vertices;
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x, p.y);
  const std::size_t given = mesh.uvs.size();
  EXPECT_EQ(make_ready(PolygonMesh(mesh), {}).mesh.uvs.size(), given);
  const double middle = (mesh.positions.front().x + mesh.positions.back().x) / 2;
  for (glm::dvec2& uv : mesh.uvs) uv.x = std::abs(uv.x - middle);
  EXPECT_EQ(make_ready(PolygonMesh(mesh), {}).mesh.uvs.size(), given + 3);
}

TEST(FitMesh, KeepsAnEdgeBesideAFlatTriangle) {
  PolygonMesh box;
  box.positions = test::cube().positions;
  for (glm::dvec3& p : box.positions) p.x *= 3;
  for (const auto& face : test::faces_of(test::cube())) {
    box.add_face(std::array{face[0], face[1], face[2]});
    box.add_face(std::array{face[0], face[2], face[3]});
  }
  // A triangle (a, b, c) becomes (a, b, m), (m, b, c), (a, m, c), the last one flat.
  const std::array corner{box.face_vertices[0], box.face_vertices[1], box.face_vertices[2]};
  const std::int32_t middle = box.vertex_count();
  const glm::dvec3 &a = box.positions[corner[0]], &b = box.positions[corner[1]];
  box.positions.push_back(0.75 * a + 0.25 * b);
  box.face_vertices[1] = middle;  // (a, m, c)
  box.add_face(std::array{middle, corner[1], corner[2]});
  box.add_face(std::array{corner[0], corner[1], middle});
  const ReadyMesh ready = make_ready(PolygonMesh(box), {});
  ASSERT_EQ(ready.changes.size(), 1u);
  EXPECT_EQ(ready.changes[0].code, "flat-triangles");
  EXPECT_EQ(ready.changes[0].first, 13);
  EXPECT_EQ(ready.mesh.face_count(), box.face_count());
  EXPECT_TRUE(make_ready(PolygonMesh(box), {.repairs = false}).changes.empty());
  const FittedMesh fitted = fit_mesh(box, "box", *make_cpu_backend());
  EXPECT_EQ(fitted.mesh.creases.size(), 13u);
  ASSERT_NE(fitted.chosen_quality(), nullptr);
  EXPECT_NEAR(fitted.chosen_quality()->rms_normal_deviation, 0, 1e-4);
}

TEST(MakeReady, LeavesNoTagWhereTagsAreIgnored) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1, kInfiniteSharpness}};
  mesh.corners = {{0, kInfiniteSharpness}};
  Preparation choice;
  choice.uses_tags = false;
  const ReadyMesh ready = make_ready(PolygonMesh(mesh), choice);
  EXPECT_TRUE(ready.mesh.creases.empty());
  EXPECT_TRUE(ready.mesh.corners.empty());
  choice.uses_tags = true;
  EXPECT_EQ(make_ready(std::move(mesh), choice).mesh.creases.size(), 1u);
}

TEST(FitExtras, SayTheLargestErrorAndWhetherItConverged) {
  Interpolation result;
  result.error = {3e-4, 1e-4};
  result.iterations = 17;
  for (const bool converged : {false, true}) {
    result.converged = converged;
    FileExtras extras = fit_extras({.tolerance = 2e-3}, "use", result);
    const auto value = [&](std::string_view key) {
      return std::ranges::find(extras, key, [](const auto& entry) { return entry.first; })->second;
    };
    EXPECT_EQ(std::get<double>(value("max_error")), 3e-4);
    EXPECT_EQ(std::get<double>(value("tolerance")), 2e-3);
    EXPECT_EQ(std::get<std::int64_t>(value("iterations")), 17);
    EXPECT_EQ(std::get<bool>(value("converged")), converged);
    EXPECT_EQ(std::get<std::string>(value("creases")), "use");
  }
}

// Surfaces and the cage take what the fit found, but for another pose or where it was not kept.
TEST(Fit, FindsOnceWhatIsSharp) {
  const auto backend = make_cpu_backend();
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    FitOptions options;
    options.method = method;
    options.sharp.boundary = BoundaryRule::EdgeAndCorner;
    PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(5), 0.2, 5);
    mesh.positions.push_back({7, 8, 9});  // of no face
    const Fit found = fit(mesh, *backend, options);
    const auto surface = fitted_surface(mesh, found, {.sharp = options.sharp});
    EXPECT_EQ(&surface->patches().features(), found.features.get());
    const UsedPart used = used_part(mesh, found.prepared);
    const SharpFeatures again = find_sharp_features(used.mesh, *used.prepared->topology,
                                                    used.mesh.positions, options.sharp);
    EXPECT_EQ(found.features->vertex_kinds, again.vertex_kinds);
    EXPECT_EQ(found.features->corner_sectors, again.corner_sectors);
    std::vector<glm::dvec3> pose = mesh.positions;
    for (glm::dvec3& p : pose) p.x *= -30;
    EXPECT_NE(&fitted_surface(mesh, found, {.sharp = options.sharp, .rest_positions = pose})
                   ->patches()
                   .features(),
              found.features.get());
    Fit restored = found;  // as from an archive
    restored.features = nullptr;
    const PolygonMesh cage = control_cage(mesh, found, options.sharp);
    EXPECT_EQ(cage.face_vertices, control_cage(mesh, restored, options.sharp).face_vertices);
    EXPECT_EQ(fitted_surface(mesh, restored, {.sharp = options.sharp})
                  ->patches()
                  .features()
                  .corner_sectors,
              again.corner_sectors);
  }
}

// check() refuses such a cage of the progressive method; one of the fair method has more vertices
// than the mesh and comes as it is.
TEST(VerifyCage, ConfirmsNothingThatIsNoNumber) {
  const PolygonMesh given = test::cube();
  FitOptions options;
  options.method = InterpolationMethod::Fair;
  const PolygonMesh cage =
      control_cage(given, fit(given, *make_cpu_backend(), options), options.sharp);
  const auto verified = [&](const PolygonMesh& other) {
    return verify_cage(other, given, {.fit = {.method = InterpolationMethod::Fair}});
  };
  EXPECT_TRUE(verified(cage).confirmed);
  for (std::int32_t v = 0; v < cage.vertex_count(); ++v) {
    PolygonMesh wrong = cage;
    wrong.positions[v].y = std::numeric_limits<double>::quiet_NaN();
    const Verification found = verified(wrong);
    EXPECT_FALSE(found.confirmed) << v;
    EXPECT_EQ(found.error.max, std::numeric_limits<double>::infinity()) << v;
  }
}

// The largest distance of a surface's boundary from the square from (0, 0) to (n, m).
double leaves_square(const FittedMesh& fitted, double n, double m) {
  double farthest = 0;
  for (const glm::dvec3& p : tessellate(fitted, {.chord_error = 1e-4}).positions)
    farthest = std::max({farthest, -p.x, -p.y, p.x - n, p.y - m});
  return farthest;
}

// The largest distance of a surface from the side of the cone with that height over the unit disc.
double leaves_cone(const FittedMesh& fitted, double height) {
  const double length = std::sqrt(1 + height * height);
  double farthest = 0;
  for (const glm::dvec3& p : tessellate(fitted, {.chord_error = 1e-4}).positions) {
    if (p.z == 0) continue;  // its base
    const double off = (std::sqrt(p.x * p.x + p.y * p.y) * height + p.z - height) / length;
    farthest = std::max(farthest, std::abs(off));
  }
  return farthest;
}

TEST(FitMesh, KeepsTheTipOfACone) {
  for (const bool is_closed : {false, true}) {
    PolygonMesh cone = test::cone(32, 1.5);
    if (is_closed) cone = test::with_base(cone, 32);
    const FittedMesh kept = fit_mesh(cone, "cone", *make_cpu_backend());
    EXPECT_EQ(kept.creases(), "auto");
    ASSERT_EQ(kept.mesh.corners.size(), 1u);
    EXPECT_EQ(kept.mesh.corners.front().vertex, 32);
    MeshFitOptions rounded;
    rounded.chooses_creases = false;
    const FittedMesh round = fit_mesh(cone, "cone", *make_cpu_backend(), rounded);
    // Between two of 32 points a chord leaves the circle by 0.0048 of its radius.
    EXPECT_LT(leaves_cone(kept, 1.5), 0.005);
    EXPECT_GT(leaves_cone(round, 1.5), 0.05);
  }
}

TEST(FitMesh, KeepsTheCornersOfAnOutline) {
  for (const bool is_wavy : {false, true}) {
    PolygonMesh sheet = test::flat_grid(6, 4);
    if (is_wavy)
      for (glm::dvec3& p : sheet.positions) p.z = 0.3 * std::sin(p.x) * std::cos(0.7 * p.y);
    FittedMesh kept = fit_mesh(sheet, "sheet", *make_cpu_backend());
    EXPECT_EQ(kept.mesh.corners.size(), 4u);
    EXPECT_EQ(kept.creases(), "auto");
    EXPECT_NE(kept.choice->reason.find("corners of its outline and tips are kept"),
              std::string::npos)
        << kept.choice->reason;
    MeshFitOptions rounded;
    rounded.chooses_creases = false;
    const FittedMesh round = fit_mesh(sheet, "sheet", *make_cpu_backend(), rounded);
    EXPECT_TRUE(round.mesh.corners.empty());
    EXPECT_LT(leaves_square(kept, 6, 4), 1e-6);
    EXPECT_GT(leaves_square(round, 6, 4), 1e-2) << "ears";
    // The cage's header has all that verify needs.
    const PolygonMesh cage = control_cage(kept.mesh, kept.fit, kept.options.sharp);
    VerifyOptions options{.fit = {.method = kept.options.method}, .cage_has_tags = false};
    options.fit.finds_features = kept.finds_features;
    options.found = &kept.found;
    EXPECT_TRUE(verify_cage(cage, sheet, options).confirmed);
    options.fit.finds_features = false;
    options.found = nullptr;
    if (kept.options.method == InterpolationMethod::Fair) {
      EXPECT_THROW((void)verify_cage(cage, sheet, options), Error) << "of other faces";
    } else {
      EXPECT_FALSE(verify_cage(cage, sheet, options).confirmed);
    }
  }
}

// Of a sheet beside one whose rim is wavy: its turns, of 22 degrees at most, are no corners.
TEST(FitMesh, LeavesOtherTurnsOfARimThatHasCornersRound) {
  PolygonMesh wavy = test::flat_grid(6, 4);
  for (std::size_t v = 0; v < wavy.positions.size(); ++v) {
    glm::dvec3& p = wavy.positions[v];
    const bool is_side = p.x == 0 || p.x == 6, is_end = p.y == 0 || p.y == 4;
    if (is_side && !is_end) p.x += static_cast<int>(p.y) % 2 ? 0.1 : -0.1;
    if (is_end && !is_side) p.y += static_cast<int>(p.x) % 2 ? 0.1 : -0.1;
    p.z = 5;
  }
  const PolygonMesh both = together(test::flat_grid(6, 4), wavy);
  const FittedMesh fitted = fit_mesh(both, "both", *make_cpu_backend());
  EXPECT_EQ(fitted.mesh.corners.size(), 8u);
}

TEST(StorageOrigin, IsTheCentreFromTenDiagonalsOn) {
  const glm::dvec3 way(0.6, 0, -0.8);
  for (const double diagonal : {1e-3, 1.0, 1e5})
    for (const double away : {0.0, 1.0, 9.99, 10.01, 50.0, 1e4}) {
      Placement placement;
      placement.diagonal = diagonal;
      placement.centre = away * diagonal * way;
      EXPECT_EQ(storage_origin(placement), away > 10 ? placement.centre : glm::dvec3(0))
          << diagonal << ", " << away;
    }
}

// Normals off by, at level 2 against those of the true sphere.
double normal_error(const FittedMesh& fitted, Backend& backend) {
  const SurfaceMesh surface =
      evaluate(fitted.mesh, fitted.fit, backend, fitted.evaluate_options(2));
  double sum = 0;
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const double cosine =
        glm::dot(glm::dvec3(surface.normals[v]), glm::normalize(surface.positions[v]));
    sum += std::pow(std::acos(std::min(cosine, 1.0)), 2);
  }
  return std::sqrt(sum / static_cast<double>(surface.positions.size()));
}

PolygonMesh noisy_sphere(double noise) {
  PolygonMesh mesh = test::icosphere(4);
  std::mt19937 random(9);
  std::normal_distribution<double> normal(0, noise * std::sqrt(12.0));
  for (glm::dvec3& p : mesh.positions) p *= 1 + normal(random);
  return mesh;
}

// By the limit points of the cage, against the given vertices.
TEST(Within, EveryVertexIsPassedWithinIt) {
  const auto backend = make_cpu_backend();
  const std::vector<test::NamedMesh> meshes = {
      {"sphere", noisy_sphere(0.002)},
      {"closed", test::random_closed_mesh(3)},
      {"open", test::random_open_mesh(4)},
      {"creased", test::with_random_creases(test::random_open_mesh(5), 0.2, 5)}};
  constexpr double kWithin = 0.004;
  int changed = 0;
  for (const auto& [name, mesh] : meshes) {
    for (const InterpolationMethod method :
         {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
      MeshFitOptions options;
      options.method = method;
      options.fit.within = kWithin;
      const FittedMesh fitted = fit_mesh(mesh, name, *backend, options);
      EXPECT_TRUE(fitted.fit.interpolation.converged) << name;
      ASSERT_TRUE(fitted.fit.within) << name;
      EXPECT_FALSE(fitted.fit.within->noise);
      EXPECT_LE(fitted.fit.within->left->bending, fitted.fit.within->exact->bending) << name;
      if (!fitted.fit.points.empty()) {
        EXPECT_GT(fitted.fit.within->distance.max, 1e-6) << name;
        ++changed;
      }

      VerifyOptions how;
      how.fit.method = method;
      how.tolerance = kWithin;
      const PolygonMesh cage = control_cage(fitted.mesh, fitted.fit, fitted.options.sharp);
      const Verification found = verify_cage(cage, mesh, how);
      EXPECT_TRUE(found.confirmed) << name << " " << found.error.max;
      EXPECT_NEAR(found.error.max, fitted.fit.within->distance.max, 2e-6) << name;
      EXPECT_NEAR(found.error.rms, fitted.fit.within->distance.rms, 2e-6) << name;
    }
  }
  EXPECT_GE(changed, 4);
}

TEST(Within, MeasuredNoiseMakesNormalsBetter) {
  const auto backend = make_cpu_backend();
  constexpr double kNoise = 0.001;
  MeshFitOptions options;
  const double exact = normal_error(fit_mesh(noisy_sphere(kNoise), "sphere", *backend), *backend);
  options.fit.within.reset();
  const FittedMesh fitted = fit_mesh(noisy_sphere(kNoise), "sphere", *backend, options);
  ASSERT_TRUE(fitted.fit.within && fitted.fit.within->noise);
  EXPECT_NEAR(*fitted.fit.within->noise, kNoise, 0.12 * kNoise);
  EXPECT_DOUBLE_EQ(fitted.fit.within->within, kNoiseBound * *fitted.fit.within->noise);
  EXPECT_LT(normal_error(fitted, *backend), 0.5 * exact);
}

struct Bent {
  double bending, folded, deeper_folded;
};

Bent bent(const FittedMesh& fitted) {
  const auto surface = fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options());
  const SurfaceQuality one = surface_quality(*surface->level(1), fitted.mesh, {}, {});
  const SurfaceQuality two = surface_quality(*surface->level(2), fitted.mesh, {}, {});
  return {one.bending, one.folded_area, two.folded_area};
}

// As a report measures it: what may leave its vertices bends and folds no more for it, whatever the
// method and the mesh.
TEST(Within, NothingBendsMoreForIt) {
  const auto backend = make_cpu_backend();
  std::vector<test::NamedMesh> meshes = {{"sphere", noisy_sphere(0.001)},
                                         {"torus", test::torus(24, 12, 2, 0.7)},
                                         {"ball", test::jittered(test::icosphere(2), 0.3, 4)},
                                         {"prism", test::prism(9)}};
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    meshes.push_back({"closed", test::random_closed_mesh(seed)});
    meshes.push_back({"dual", test::random_dual(40, seed)});
    meshes.push_back({"open", test::random_open_mesh(seed)});
    meshes.push_back(
        {"creased", test::with_random_creases(test::random_closed_mesh(seed + 5), 0.1, seed)});
  }
  int changed = 0, left = 0;
  for (const auto& [name, mesh] : meshes) {
    for (const std::optional<InterpolationMethod> method :
         {std::optional(InterpolationMethod::Progressive), std::optional(InterpolationMethod::Fair),
          std::optional<InterpolationMethod>()}) {
      MeshFitOptions options;
      options.method = method;
      options.refine = RefineChoice::Off;  // as it is where vertices may move
      const FittedMesh exact = fit_mesh(mesh, name, *backend, options);
      const Bent without = bent(exact);
      for (const double within : {1e-5, 1e-3, 1e-2}) {
        SCOPED_TRACE(name + " " + std::to_string(within));
        options.fit.within = within;
        const FittedMesh fitted = fit_mesh(mesh, name, *backend, options);
        const Bent with = bent(fitted);
        EXPECT_EQ(fitted.options.method, exact.options.method);
        EXPECT_LE(with.bending, without.bending * (1 + 1e-9));
        EXPECT_LE(with.folded, without.folded + 1e-12);
        EXPECT_LE(with.deeper_folded, without.deeper_folded + 1e-12);
        ASSERT_TRUE(fitted.fit.within && fitted.fit.within->left);
        EXPECT_NEAR(fitted.fit.within->left->bending, with.bending, 1e-9 * with.bending);
        EXPECT_LE(fitted.fit.within->distance.max, within);
        EXPECT_EQ(fitted.fit.points.empty(), fitted.fit.within->distance.max == 0);
        ++(fitted.fit.points.empty() ? left : changed);
      }
    }
  }
  EXPECT_GT(changed, left);
}

// What is not above the tolerance allows nothing.
TEST(Within, TheToleranceComesFirst) {
  const auto backend = make_cpu_backend();
  MeshFitOptions options;
  options.fit.within = 1e-6;
  const FittedMesh fitted = fit_mesh(noisy_sphere(0.001), "sphere", *backend, options);
  EXPECT_TRUE(fitted.fit.points.empty());
  EXPECT_EQ(fitted.fit.within->at_bound, 0);
}

}  // namespace
}  // namespace planish
