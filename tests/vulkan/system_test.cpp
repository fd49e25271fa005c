#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "files/gltf/glb_bytes.h"
#include "planish/core/error.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/mesh/face_geometry.h"
#include "planish/pipeline/fit.h"
#include "planish/queries/limit_surface.h"
#include "planish/solve/backend.h"
#include "planish/solve/iteration.h"
#include "planish/surface/evaluate.h"
#include "planish/vulkan/embed.h"
#include "support/calls.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/device_cases.h"
#include "vulkan/embedding.h"

namespace planish::testing {
namespace {

// What a System says of its rest pose and of iterations, without a device.

using namespace vulkan;

// Errors before step 0, 1, ... of a pose.
std::vector<double> errors_of(const System& system, const PolygonMesh& pose) {
  std::vector<glm::dvec3> given;
  for (const std::int32_t v : system.used_vertices()) given.push_back(pose.positions[v]);
  const auto backend = make_cpu_backend();
  const auto solve = backend->make_solve(system.limit_masks());
  solve->begin(initial_residual(system.limit_masks(), given));
  std::vector<double> errors;
  for (const ErrorNorms& error :
       solve->run(chebyshev_steps(system.spectral_bound(), 80), -1).errors)
    errors.push_back(error.max);
  return errors;
}

TEST(System, CountsTheStepsOfItsRestPose) {
  for (std::uint32_t seed = 1; seed < 6; ++seed) {
    const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(seed), 0.1, seed);
    const System system(mesh);
    const std::vector<double> errors = errors_of(system, mesh);
    EXPECT_NEAR(system.rest_error(), errors[0], 1e-12);
    const std::uint32_t count = system.rest_iterations();
    ASSERT_GT(count, 0u);
    EXPECT_LE(errors[count], system.tolerance() * (1 + 1e-9)) << seed;
    EXPECT_GT(errors[count - 1], system.tolerance()) << seed;
  }
}

TEST(System, RefusesFacesThatIterationsCannotTake) {
  const PolygonMesh drum = test::prism(5000);
  EXPECT_THAT(test::message_of(ErrorCode::UnusableMesh, [&] { const System system(drum); }),
              ::testing::HasSubstr("the largest face, 0, has 5000 corners"));
  EXPECT_EQ(System(drum, {.method = InterpolationMethod::Fair}).given_count(), drum.vertex_count());
}

TEST(System, TellsWhatItsCopiesStandFor) {
  for (const int level : {0, 1, 2}) {
    const PolygonMesh mesh =
        with_unused(test::with_random_creases(test::random_closed_mesh(3), 0.2, 3), 0, {9, 9, 9});
    const System system(mesh, {.level = level});
    const auto copied = system.copied_vertices();
    ASSERT_EQ(copied.size(), static_cast<std::size_t>(system.vertex_count()));
    const SurfaceMesh surface = evaluate(mesh, *make_cpu_backend(), {.level = level});
    ASSERT_EQ(copied.size(), surface.positions.size());
    // Only copies lie where another vertex does.
    const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
      return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::map<glm::dvec3, std::int32_t, decltype(less)> first(less);
    std::size_t copies = 0, of_given = 0;
    for (std::size_t i = 0; i < copied.size(); ++i) {
      const auto [place, is_new] =
          first.try_emplace(surface.positions[i], static_cast<std::int32_t>(i));
      EXPECT_EQ(copied[i], place->second) << i;
      if (is_new) continue;
      ++copies;
      of_given += static_cast<std::size_t>(copied[i]) < system.used_vertices().size();
    }
    EXPECT_GT(of_given, 0u);
    if (level > 0) {
      EXPECT_GT(copies, of_given);
    }
  }
}

TEST(System, SufficientIterationsSuffice) {
  for (std::uint32_t seed = 1; seed < 8; ++seed)
    for (const bool closed : {true, false}) {
      const PolygonMesh mesh =
          closed ? test::random_closed_mesh(seed)
                 : test::with_random_creases(test::random_open_mesh(seed), 0.2, seed);
      for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
        const System system(mesh, {.level = 0, .weights = weights});
        for (int frame = 0; frame < 4; ++frame) {
          const std::vector<double> errors = errors_of(system, posed(mesh, frame));
          const std::uint32_t count = system.sufficient_iterations(errors[0]);
          ASSERT_LT(count, errors.size());
          EXPECT_LE(errors[count], system.tolerance()) << seed << " " << closed;
        }
        EXPECT_LE(system.rest_iterations(), system.sufficient_iterations(system.rest_error()));
      }
    }
}

TEST(System, NeedsNoIterationWithinItsTolerance) {
  const System system(test::icosphere(1));
  EXPECT_EQ(system.sufficient_iterations(0), 0u);
  EXPECT_EQ(system.sufficient_iterations(system.tolerance()), 0u);
  EXPECT_GT(system.sufficient_iterations(2 * system.tolerance()), 0u);
}

TEST(System, RefusesWhatItCannotBeMadeOf) {
  EXPECT_THROW(System(test::cube(), {.level = 7}), Error);
  EXPECT_THROW(System(test::cube(), {.tolerance = 0}), Error);
  PolygonMesh broken = test::cube();
  broken.face_vertices[0] = 99;
  EXPECT_NE(test::message_of(ErrorCode::UnusableMesh, [&] { const System system(broken); }),
            "no error");
}

// What a System shares with the files that `planish fit` writes of the same mesh: triangles, and
// which vertex is which. Without a device.

// All primitives of a GLB, vertices counted through them.
struct FileRows {
  explicit FileRows(const SurfaceMesh& surface) {
    const std::vector<std::byte> bytes = encode_glb(surface, {});
    glb.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    json = test::document_of(glb);
    for (const auto& primitive : json["meshes"][0]["primitives"]) {
      const auto base = static_cast<std::uint32_t>(positions.size());
      const auto& attributes = primitive["attributes"];
      append<glm::vec3>(attributes["POSITION"], positions);
      append<glm::vec2>(attributes.value("TEXCOORD_0", -1), uvs);
      uvs.resize(positions.size());
      const int indices = primitive["indices"];
      std::vector<std::uint32_t> wide;
      std::vector<std::uint16_t> narrow;
      if (json["accessors"][indices]["componentType"] == 5123)
        append<std::uint16_t>(indices, narrow);
      else
        append<std::uint32_t>(indices, wide);
      wide.insert(wide.end(), narrow.begin(), narrow.end());
      for (const std::uint32_t index : wide) triangles.push_back(base + index);
    }
  }

  std::vector<glm::vec3> positions;
  std::vector<glm::vec2> uvs;  // zeros where there are none
  std::vector<std::uint32_t> triangles;

 private:
  template <class Item>
  void append(int accessor, std::vector<Item>& items) const {
    if (accessor < 0) return;
    const auto& of = json["accessors"][accessor];
    const auto& view = json["bufferViews"][of["bufferView"].get<int>()];
    const std::size_t count = of["count"], begin = items.size();
    items.resize(begin + count);
    const std::size_t json_bytes = glb.find(std::string("BIN\0", 4)) + 4;
    std::memcpy(&items[begin], glb.data() + json_bytes + view.value("byteOffset", std::size_t{0}),
                count * sizeof(Item));
  }
  std::string glb;
  nlohmann::json json;
};

std::vector<std::uint32_t> through(const std::vector<std::int32_t>& map,
                                   std::span<const std::uint32_t> indices) {
  std::vector<std::uint32_t> result;
  for (const std::uint32_t index : indices)
    result.push_back(static_cast<std::uint32_t>(map[index]));
  return result;
}

// Two faces that are not convex, of which one is cut from the front alone on its longer diagonal.
PolygonMesh darts() {
  return test::make_mesh({{0, 0, 0}, {1, 0, -1}, {2, 0, 0}, {1, 0, -3}, {1, 0, 1}},
                         {{0, 1, 2, 3}, {0, 4, 2, 1}});
}
PolygonMesh concave_polygons() {
  return test::make_mesh({{0, 0, 0},
                          {3, 0, 0},
                          {3, 1, 0},
                          {1, 1, 0},
                          {1, 3, 0},
                          {0, 3, 0},
                          {0.5, -2, 0},
                          {1.5, -0.3, 0}},
                         {{0, 1, 2, 3, 4, 5}, {0, 6, 7, 1}});
}

TEST(FileTriangles, AreNotTurnedOverWhereFacesAreConcave) {
  for (const PolygonMesh& mesh : {darts(), concave_polygons()}) {
    const System system(mesh, {.level = 0});
    const auto triangles = system.triangles();
    std::size_t at = 0;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const glm::dvec3 face = area_vector(mesh.positions, mesh.face(f));
      double sum = 0;
      for (const std::size_t end = at + 3 * (mesh.face(f).size() - 2); at < end; at += 3) {
        const auto p = [&](std::size_t k) {
          return mesh.positions[system.used_vertices()[triangles[at + k]]];
        };
        const double area =
            0.5 * glm::dot(glm::cross(p(1) - p(0), p(2) - p(0)), glm::normalize(face));
        EXPECT_GT(area, 0) << "face " << f;
        sum += area;
      }
      EXPECT_NEAR(sum, glm::length(face), 1e-12) << "face " << f;
    }
    EXPECT_EQ(at, triangles.size());
  }
}

// The same triangles in the same order.
TEST(FileTriangles, AreThoseOfTheFile) {
  std::vector<PolygonMesh> meshes = textured_meshes();
  meshes.push_back(test::laden_mesh(5));
  meshes.back().face_groups.clear();
  meshes.push_back(test::relabelled(test::random_closed_mesh(4), 2).mesh);
  meshes.push_back(test::bipyramid(7));
  meshes.push_back(test::torus(48, 24, 2, 0.8));
  for (const InterpolationMethod method :
       {InterpolationMethod::Progressive, InterpolationMethod::Fair})
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      const PolygonMesh& mesh = meshes[i];
      const auto backend = make_cpu_backend();
      const Fit fitted = fit(mesh, *backend, {.method = method});
      for (const int level : {0, 1, 2, 3}) {
        SCOPED_TRACE("mesh " + std::to_string(i) + " at level " + std::to_string(level));
        const FileRows file(evaluate(mesh, fitted, *backend, {.level = level}));
        const System system(mesh,
                            {.level = level,
                             .method = method,
                             .textured = !mesh.face_uvs.empty(),
                             .fair_decisions = fitted.fair ? &fitted.fair->decisions : nullptr});
        EXPECT_EQ(through(system.file_vertices(), system.triangles()), file.triangles);
      }
    }
}

// The mesh itself is the cage. Where a primitive has vertices of its own, that of the first is
// told.
TEST(FileVertices, AreWhereTheFileHasThem) {
  std::vector<PolygonMesh> meshes = textured_meshes();
  for (const std::uint32_t seed : {1u, 2u, 3u, 4u}) meshes.push_back(test::laden_mesh(seed));
  for (std::size_t i = 0; i < meshes.size(); ++i)
    for (const int level : {0, 1, 2, 3})
      for (const bool textured : {true, false}) {
        SCOPED_TRACE("mesh " + std::to_string(i) + " at level " + std::to_string(level));
        const PolygonMesh& mesh = meshes[i];
        const PolygonMesh given = on_surface(mesh);
        const EvaluateOptions options{.level = level, .rest_positions = given.positions};
        const FileRows file(evaluate(mesh, *make_cpu_backend(), options));
        const System system(
            given, {.level = 1, .levels = {2, 3}, .textured = textured, .tolerance = 1e-9});
        const System own(given, {.level = level, .textured = textured, .tolerance = 1e-9});
        const std::vector<std::int32_t> map = own.file_vertices();
        const std::vector<glm::vec2> uvs = own.uvs();
        const std::vector<SurfacePlace> places = own.places();
        const DooSabinSurface surface(mesh, options);
        const LimitSurface limit(std::shared_ptr<const DooSabinSurface>(&surface, [](auto*) {}));
        ASSERT_EQ(std::ssize(map), own.vertex_count());
        std::set<std::int32_t> named;
        for (std::size_t k = 0; k < map.size(); ++k) {
          if (map[k] < 0) continue;
          named.insert(map[k]);
          const SurfacePoint point =
              limit.evaluate({static_cast<std::int32_t>(places[k].face), places[k].u, places[k].v});
          ASSERT_LT(glm::distance(point.position, glm::dvec3(file.positions[map[k]])), 1e-5) << k;
          if (textured) {
            ASSERT_LT(glm::distance(uvs[k], file.uvs[map[k]]), 1e-5F) << k;
          }
        }
        // Each vertex that triangles name has its own; textured ones of one primitive are all.
        for (const std::uint32_t vertex : own.triangles()) ASSERT_GE(map[vertex], 0);
        if (mesh.face_groups.empty() && textured) {
          EXPECT_EQ(named.size(), file.positions.size());
        }
        if (level == 0) continue;
        EXPECT_EQ(system.file_vertices(level), map);
        EXPECT_EQ(system.uvs(level), uvs);
      }
}

TEST(FileVertices, AreOfTheSystemsLevelsAlone) {
  const System system(test::cube(), {.level = 1, .levels = {2, 3}});
  EXPECT_EQ(system.places(1).size(), system.places().size());
  EXPECT_EQ(test::message_of(ErrorCode::InvalidArgument, [&] { (void)system.uvs(4); }),
            "level 4 is neither the System's level 1 nor one of its levels; give SystemOptions it");
}

}  // namespace
}  // namespace planish::testing
