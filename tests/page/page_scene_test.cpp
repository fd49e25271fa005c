#include "planish/job/page/page_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "page/page_reader.h"
#include "planish/measure/vertex_fields.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/calls.h"
#include "support/meshes.h"

namespace planish {
namespace {

struct SceneCase {
  std::string name;
  PolygonMesh mesh;
  Scheme scheme = Scheme::DooSabin;
};

PolygonMesh bumpy_grid() {
  return test::grid(5, 4, [](double x, double y) {
    return glm::dvec3(x, y, std::sin(1.3 * x) * std::cos(0.9 * y));
  });
}

std::vector<SceneCase> scene_cases() {
  std::vector<SceneCase> cases{{"prism", test::prism(5)},
                               {"cube", test::cube()},
                               {"open grid", bumpy_grid()},
                               {"icosphere", test::icosphere(1)},
                               {"loop", test::icosphere(1), Scheme::Loop},
                               {"catmull-clark", test::prism(6), Scheme::CatmullClark}};
  SceneCase creased{"creased", test::cube()};
  creased.mesh.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  cases.push_back(creased);
  SceneCase lone{"lone crease", test::cube()};
  lone.mesh.creases = {{0, 1}};
  cases.push_back(lone);
  SceneCase dart{"dart", bumpy_grid()};
  dart.mesh.creases = {{7, 8}, {8, 9}};
  cases.push_back(dart);
  SceneCase holes{"holes", bumpy_grid()};
  holes.mesh.hole_faces = {3, 8};
  cases.push_back(holes);
  SceneCase unused{"unused vertex", test::prism(4)};
  unused.mesh.positions.insert(unused.mesh.positions.begin() + 2, glm::dvec3(9, 9, 9));
  for (std::int32_t& v : unused.mesh.face_vertices) v += v >= 2 ? 1 : 0;
  cases.push_back(unused);
  return cases;
}

SurfaceMesh surface_of(const SceneCase& c, int level) {
  return evaluate(c.mesh, *make_cpu_backend(), {.level = level, .scheme = c.scheme});
}

PageScene scene_of(const SceneCase& c, const SurfaceMesh& surface) {
  return make_page_scene({surface, c.mesh, c.mesh, {}, 2.0, 1});
}

test::PageReader read(const PageScene& scene, int level) {
  const PagePayload payload = encode_scene(scene, level);
  return {nlohmann::json::parse(payload.head.dump()), payload.packed};
}

glm::dvec3 place(const nlohmann::json& box, const std::vector<std::int64_t>& values,
                 std::size_t i) {
  glm::dvec3 p;
  for (int k = 0; k < 3; ++k) {
    p[k] = box["low"][k].get<double>() +
           box["size"][k].get<double>() * static_cast<double>(values[3 * i + k]) / 65535;
  }
  return p;
}

glm::dvec3 direction(const std::vector<std::int64_t>& values, std::size_t i) {
  double x = static_cast<double>(values[2 * i]) / 32767.5 - 1;
  double y = static_cast<double>(values[2 * i + 1]) / 32767.5 - 1;
  const double z = 1 - std::abs(x) - std::abs(y), under = std::max(-z, 0.0);
  x -= std::copysign(under, x);
  y -= std::copysign(under, y);
  return glm::normalize(glm::dvec3(x, y, z));
}

// The same corners of the same faces as the surface's, in place and direction: everything that a
// viewer draws, after a way on which no index was stored.
void expect_read_back(const SceneCase& c, int level, const test::PageReader& reader) {
  const SurfaceMesh surface = surface_of(c, level);
  const auto positions = reader.values("position"), normals = reader.values("normal");
  const auto& faces = reader.levels().back().faces;
  ASSERT_EQ(faces.size(), static_cast<std::size_t>(surface.face_count()));
  ASSERT_EQ(positions.size(), 3 * static_cast<std::size_t>(reader.levels().back().count));
  const auto& box = reader.head()["box"];
  double step = 0;  // half of the grid's
  for (int k = 0; k < 3; ++k) step = std::hypot(step, box["size"][k].get<double>() / 65535 / 2);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto wanted = surface.face(static_cast<std::int64_t>(f));
    ASSERT_EQ(faces[f].size(), wanted.size()) << f;
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      const auto v = static_cast<std::size_t>(faces[f][k]);
      EXPECT_LE(glm::distance(place(box, positions, v), surface.positions[wanted[k]]), step * 1.001)
          << "face " << f;
      EXPECT_LT(glm::distance(direction(normals, v), glm::dvec3(surface.normals[wanted[k]])), 1e-4)
          << "face " << f;
    }
  }
}

// Each corner of a mesh with texture coordinates of its own where `apart` says so.
PolygonMesh mapped(PolygonMesh mesh, const std::function<bool(std::int32_t face)>& apart) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (const std::int32_t v : mesh.face(f)) {
      const auto& p = mesh.positions[static_cast<std::size_t>(v)];
      const glm::dvec2 uv(p.x + (apart(f) ? 3.0 : 0.0), p.y + 0.3 * p.z);
      const auto known = std::ranges::find(mesh.uvs, uv);
      mesh.face_uvs.push_back(static_cast<std::int32_t>(known - mesh.uvs.begin()));
      if (known == mesh.uvs.end()) mesh.uvs.push_back(uv);
    }
  return mesh;
}

// A board of squares lies where the texture does, seams included, with triangles and holes too.
TEST(PageScene, TextureCoordinatesAreReadBack) {
  std::vector<SceneCase> cases;
  for (const SceneCase& c : scene_cases()) {
    cases.push_back(
        {c.name + " of one chart", mapped(c.mesh, [](std::int32_t) { return false; }), c.scheme});
    cases.push_back({c.name + " of charts",
                     mapped(c.mesh, [](std::int32_t f) { return f % 3 == 0; }), c.scheme});
  }
  for (const SceneCase& c : cases) {
    for (int level = 0; level <= 2; ++level) {
      SCOPED_TRACE(c.name + " level " + std::to_string(level));
      const SurfaceMesh surface = surface_of(c, level);
      const PagePayload payload = encode_scene(scene_of(c, surface), level);
      const test::PageReader reader(nlohmann::json::parse(payload.head.dump()), payload.packed,
                                    "uv_");
      const auto values = reader.values("uv");
      const auto& faces = reader.levels().back().faces;
      ASSERT_EQ(faces.size(), static_cast<std::size_t>(surface.face_count()));
      ASSERT_EQ(values.size(), 2 * static_cast<std::size_t>(reader.levels().back().count));
      const auto& box = reader.head()["uv_box"];
      std::size_t corner = 0;
      for (const auto& face : faces)
        for (const std::int64_t v : face) {
          const glm::dvec2 wanted =
              surface.uvs[static_cast<std::size_t>(surface.face_uvs[corner++])];
          for (int k = 0; k < 2; ++k) {
            const double size = box["size"][k].get<double>();
            const double made =
                box["low"][k].get<double>() +
                size *
                    static_cast<double>(
                        values[2 * static_cast<std::size_t>(v) + static_cast<std::size_t>(k)]) /
                    65535;
            ASSERT_NEAR(made, wanted[k], size / 65535) << corner;
          }
        }
    }
  }
}

TEST(PageScene, TexturesThatAreNotEverywhereAreLeftOut) {
  SceneCase c{"prism", mapped(test::prism(5), [](std::int32_t) { return false; })};
  c.mesh.face_uvs[2] = -1;
  const PagePayload payload = encode_scene(scene_of(c, surface_of(c, 1)), 1);
  EXPECT_FALSE(payload.head.contains("uv_box"));
  const SceneCase bare{"prism", test::prism(5)};
  EXPECT_FALSE(encode_scene(scene_of(bare, surface_of(bare, 1)), 1).head.contains("uv_box"));
}

TEST(PageScene, IsReadBackAsTheSurfaceOfEveryLevel) {
  for (const SceneCase& c : scene_cases()) {
    for (int level = 0; level <= 2; ++level) {
      SCOPED_TRACE(c.name + " level " + std::to_string(level));
      expect_read_back(c, level, read(scene_of(c, surface_of(c, level)), level));
    }
  }
}

TEST(PageScene, IsReadBackWherePackedInPieces) {
  const SceneCase c{"torus", test::torus(200, 100, 2, 1)};
  const test::PageReader reader = read(scene_of(c, surface_of(c, 1)), 1);
  ASSERT_GT(reader.head()["sections"].back()["offset"].get<std::size_t>(), std::size_t{1} << 20);
  expect_read_back(c, 1, reader);
}

// Both sides of a crease of one edge share its ends but not the normals at its middle.
TEST(PageScene, LoneCreasesAreCut) {
  const SceneCase c = scene_cases()[7];
  ASSERT_EQ(c.name, "lone crease");
  const test::PageReader reader = read(scene_of(c, surface_of(c, 2)), 2);
  EXPECT_EQ(reader.list("cuts0").size(), 1u);
  EXPECT_EQ(reader.list("cuts1").size(), 0u);  // its halves have ends of their own
}

// Coarser payloads of a fine surface hold its first vertices.
TEST(PageScene, LevelsAreBeginnings) {
  const SceneCase c{"prism", test::prism(5)};
  const PageScene scene = scene_of(c, surface_of(c, 2));
  const test::PageReader coarse = read(scene, 1), fine = read(scene, 2);
  EXPECT_EQ(coarse.levels().back().count, fine.levels()[1].count);
  EXPECT_EQ(coarse.levels()[1].faces, fine.levels()[1].faces);
  EXPECT_LT(coarse.values("normal").size(), fine.values("normal").size());
}

double value_of(const nlohmann::json& field, std::int64_t step) {
  const double limit = field["limit"].get<double>();
  if (field["kind"] == "share") return limit * static_cast<double>(step) / 255;
  if (field["kind"] == "signed") {
    const double root = static_cast<double>(step - 128) / 127;
    return limit * std::copysign(root * root, root);
  }
  const double top = field["name"] == "error" ? 65535 : 255;
  return limit * std::pow(static_cast<double>(step) / top, 2);
}

TEST(PageScene, FieldsAreReadBackWithinAStep) {
  for (const SceneCase& c : scene_cases()) {
    const SurfaceMesh surface = surface_of(c, 2);
    const PageScene scene = scene_of(c, surface);
    const test::PageReader reader = read(scene, 2);
    ASSERT_EQ(reader.head()["fields"].size(), scene.fields.size());
    for (std::size_t f = 0; f < scene.fields.size(); ++f) {
      const auto& field = reader.head()["fields"][f];
      const auto steps = reader.values(scene.fields[f].name);
      ASSERT_EQ(steps.size(), scene.fields[f].values.size());
      const double limit = field["limit"].get<double>();
      for (std::size_t i = 0; i < steps.size(); ++i) {
        const double wanted = std::clamp<double>(scene.fields[f].values[i], -limit, limit);
        // Steps are even in the root, so half of one is less than this everywhere.
        EXPECT_NEAR(value_of(field, steps[i]), wanted, limit / 120)
            << c.name << " " << scene.fields[f].name;
      }
    }
  }
}

TEST(PageScene, FieldsAreThoseOfTheLibrary) {
  const SceneCase c{"dart", scene_cases()[8].mesh};
  const SurfaceMesh surface = surface_of(c, 2);
  const PageScene scene = scene_of(c, surface);
  const VertexFields fields = vertex_fields(surface, c.mesh, 2.0);
  for (std::size_t i = 0; i < scene.order.rows.size(); ++i) {
    const std::int32_t row = scene.order.rows[i];
    if (i < scene.order.counts[0]) {
      EXPECT_EQ(scene.fields[0].values[i], fields.error[row]);
    }
    EXPECT_EQ(scene.fields[1].values[i], fields.normal_deviation[row]);
    EXPECT_EQ(scene.fields[2].values[i], fields.folded[row]);
    EXPECT_FLOAT_EQ(scene.fields[3].values[i], 2 * fields.curvatures.mean[row]);
    EXPECT_FLOAT_EQ(scene.fields[4].values[i], 4 * fields.curvatures.gaussian[row]);
  }
}

// A tall face over a short one, so that the surface folds.
TEST(PageScene, FoldsHaveTheirShareOfTheWholeArea) {
  PolygonMesh mesh = test::cube();
  mesh.positions[0] = glm::dvec3(3, 3, 3);
  const SceneCase c{"turned over", mesh};
  const SurfaceMesh surface = surface_of(c, 1);
  const std::vector<FoldedFace> folded = folded_faces(surface, mesh);
  ASSERT_FALSE(folded.empty());
  double whole = 0;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    whole += 0.5 * glm::length(glm::cross(surface.positions[face[2]] - surface.positions[face[0]],
                                          surface.positions[face[3]] - surface.positions[face[1]]));
  }
  const PageScene scene = scene_of(c, surface);
  EXPECT_EQ(scene.folded_faces, folded.size());
  ASSERT_FALSE(scene.folds.empty());
  EXPECT_NEAR(scene.folds[0].area, folded[0].area / whole, 1e-12);
}

TEST(PageScene, NamesVerticesAsTheFileDoes) {
  for (const SceneCase& c : scene_cases()) {
    const SurfaceMesh surface = surface_of(c, 1);
    std::vector<std::int32_t> names(c.mesh.positions.size());
    for (std::size_t v = 0; v < names.size(); ++v) names[v] = static_cast<std::int32_t>(100 + v);
    const PageScene scene = make_page_scene({surface, c.mesh, c.mesh, names, 2.0, 1});
    const test::PageReader reader = read(scene, 1);
    const auto read_names = reader.list("names");
    ASSERT_EQ(read_names.size(), static_cast<std::size_t>(reader.head()["base"]));
    // The surface's limit point of a vertex, found by its name.
    const SurfaceMesh limits = surface_of(c, 0);
    for (std::size_t i = 0; i < read_names.size(); ++i) {
      const auto vertex = static_cast<std::int32_t>(read_names[i] - 100);
      const auto at =
          std::ranges::find(limits.base_vertices, vertex) - limits.base_vertices.begin();
      EXPECT_LT(glm::distance(scene.positions[i], limits.positions[at]), 1e-12) << c.name;
    }
    EXPECT_EQ(read_names[reader.head()["worst"].get<std::size_t>()], 101) << c.name;
  }
}

TEST(PageScene, HoldsTheGivenPointsWhereTheSurfaceMissesThem) {
  const SceneCase c{"prism", test::prism(5)};
  const test::PageReader reader = read(scene_of(c, surface_of(c, 1)), 1);
  const auto given = reader.values("given");
  for (std::size_t v = 0; v < c.mesh.positions.size(); ++v) {
    EXPECT_LT(glm::distance(place(reader.head()["given_box"], given, v), c.mesh.positions[v]),
              1e-4);
  }
  const auto cage = reader.values("cage");
  EXPECT_LT(glm::distance(place(reader.head()["cage_box"], cage, 3), c.mesh.positions[3]), 1e-4);
  EXPECT_EQ(reader.list("cage_from").size(), 15u);  // edges of a prism
}

TEST(PageScene, CutsConcavePolygonsAsTheFilesDo) {
  PolygonMesh mesh;  // an arrow of five corners, whose fan would leave it
  mesh.positions = {{2, 1, 0}, {0, 2, 0}, {1, 1, 0}, {0, 0, 0}, {1.5, 0.5, 0}};
  mesh.add_face(std::array{0, 1, 2, 3, 4});
  const SurfaceMesh surface = evaluate(mesh, *make_cpu_backend(), {.level = 0});
  SurfaceMesh given = surface;
  given.positions = mesh.positions;
  const PageScene scene = make_page_scene({given, mesh, mesh, {}, 2.0, 0});
  const auto cut = read(scene, 0).list("triangles");
  ASSERT_EQ(cut.size(), 9u);
  double area = 0;
  for (std::size_t t = 0; t < 9; t += 3) {
    const glm::dvec3 a = mesh.positions[cut[t]], b = mesh.positions[cut[t + 1]],
                     c = mesh.positions[cut[t + 2]];
    const double part = glm::cross(b - a, c - a).z / 2;
    EXPECT_GE(part, 0);
    area += part;
  }
  EXPECT_NEAR(area, 1.25, 1e-12);  // of the arrow itself, by the shoelace formula
}

// Else numbers would stand for it that say something else.
TEST(PageScene, NumbersThatAreNotFiniteAreRefused) {
  const SceneCase c = scene_cases().front();
  for (const double wrong : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    const auto refused = [&](const auto& spoil) {
      SurfaceMesh surface = surface_of(c, 1);
      PolygonMesh cage = c.mesh;
      spoil(surface, cage);
      return test::message_of(ErrorCode::InvalidArgument, [&] {
        (void)make_page_scene({surface, c.mesh, cage, {}, 2.0, 1});
      });
    };
    EXPECT_NE(refused([&](auto& s, auto&) {
                s.positions[7].y = wrong;
              }).find("page: vertex 7 is not finite: ("),
              std::string::npos);
    EXPECT_NE(refused([&](auto& s, auto&) {
                s.normals[3].z = static_cast<float>(wrong);
              }).find("page: the normal of vertex 3 is not finite: ("),
              std::string::npos);
    EXPECT_NE(refused([&](auto&, auto& cage) {
                cage.positions[2].x = wrong;
              }).find("page: control point 2 is not finite: ("),
              std::string::npos);
  }
}

}  // namespace
}  // namespace planish
