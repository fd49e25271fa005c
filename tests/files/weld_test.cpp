#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <iterator>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "files/read_bytes.h"
#include "mesh/test_meshes.h"
#include "planish/files/mesh_file.h"
#include "planish/files/shared/weld.h"
#include "support/calls.h"

namespace planish {
namespace {

TEST(Weld, EqualsInsertingOneAfterAnother) {
  std::mt19937 random(11);
  for (const int distinct : {1, 7, 5000, 200000}) {
    std::vector<glm::dvec3> positions;
    for (int i = 0; i < 150000; ++i) {
      const int k = static_cast<int>(random() % static_cast<unsigned>(distinct));
      positions.emplace_back(k % 50, (k / 50) % 40 * 0.1, k % 3 == 0 ? -0.0 : k * 1e-7);
      if (k % 3 == 0 && random() % 2 == 0) positions.back().z = 0.0;
    }
    Welder welder;
    std::vector<std::int32_t> expected;
    for (const glm::dvec3& position : positions) expected.push_back(welder.insert(position));
    const WeldedPositions welded = weld(positions);
    EXPECT_EQ(std::vector<std::int32_t>(welded.indices.begin(), welded.indices.end()), expected);
    EXPECT_EQ(welded.positions, welder.take_positions());
  }
  EXPECT_TRUE(weld({}).positions.empty());
}

// A ring of revolution as programs make it: its last column stands where the first does, but for
// what rounding leaves of sin(2 pi).
TEST(Weld, ClosesWhatIsOpenByTheRemainderOfAZero) {
  constexpr int kAround = 12;
  std::vector<glm::dvec3> positions;
  for (const double height : {-1.0, 0.0, 1.0}) {
    for (int i = 0; i <= kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      positions.emplace_back(static_cast<float>(3 * std::cos(angle)), height,
                             static_cast<float>(3 * std::sin(angle)));
    }
  }
  ASSERT_NE(positions[0], positions[kAround]);
  const WeldedPositions welded = weld(positions);
  Welder welder;
  for (std::size_t i = 0; i < positions.size(); ++i)
    EXPECT_EQ(welder.insert(positions[i]), welded.indices[i]);
  EXPECT_EQ(welded.positions.size(), 3U * kAround);
  EXPECT_EQ(welded.positions[0], glm::dvec3(3, -1, 0));
  EXPECT_EQ(welder.take_positions(), welded.positions);
  // Small detail far away is none.
  const glm::dvec3 detail[] = {{1e6, 1e-6, 0}, {1e6, 2e-6, 0}, {0, 1e-300, 0}, {0, 2e-300, 0}};
  EXPECT_EQ(weld(detail).positions, std::vector<glm::dvec3>(std::begin(detail), std::end(detail)));
}

// Shapes whose sharp edges are known, in the three formats that have normals.

using Place = std::array<double, 3>;
using PlacePair = std::pair<Place, Place>;

constexpr int kSides = 12;  // of the cylinder

// Polygons with a normal at each corner.
struct Shape {
  std::vector<glm::dvec3> positions;
  std::vector<std::vector<int>> faces;
  std::vector<std::vector<glm::dvec3>> normals;  // as faces

  void add(const std::vector<int>& face, const std::function<glm::dvec3(int)>& normal_at) {
    faces.push_back(face);
    normals.emplace_back();
    for (const int vertex : face) normals.back().push_back(normal_at(vertex));
  }
};

Shape cube(bool is_flat) {
  const PolygonMesh mesh = test::cube();
  Shape shape{.positions = mesh.positions};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::vector<int> face(mesh.face(f).begin(), mesh.face(f).end());
    const auto& p = mesh.positions;
    const glm::dvec3 normal = glm::cross(p[face[1]] - p[face[0]], p[face[2]] - p[face[0]]);
    shape.add(face,
              [&](int v) { return is_flat ? normal : glm::normalize(p[v] - glm::dvec3(0.5)); });
  }
  return shape;
}

// Smooth around, flat at its ends.
Shape cylinder() {
  Shape shape;
  std::vector<int> top, bottom;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * 3.14159265358979 * i / kSides;
    for (const double z : {0.0, 1.0})
      shape.positions.emplace_back(std::cos(angle), std::sin(angle), z);
    bottom.insert(bottom.begin(), 2 * i);
    top.push_back(2 * i + 1);
  }
  const auto outward = [&](int v) {
    return glm::dvec3(shape.positions[v].x, shape.positions[v].y, 0);
  };
  for (int i = 0; i < kSides; ++i) {
    const int a = 2 * i, b = 2 * ((i + 1) % kSides);
    shape.add({a, b, b + 1, a + 1}, outward);
  }
  shape.add(top, [](int) { return glm::dvec3(0, 0, 1); });
  shape.add(bottom, [](int) { return glm::dvec3(0, 0, -1); });
  return shape;
}

std::string split_text_of(const glm::dvec3& v) {
  return " " + std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z);
}

std::string obj_text(const Shape& shape) {
  std::string text, faces;
  int normal_count = 0;
  for (const glm::dvec3& p : shape.positions) text += "v" + split_text_of(p) + "\n";
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    faces += "f";
    for (std::size_t k = 0; k < shape.faces[f].size(); ++k) {
      text += "vn" + split_text_of(shape.normals[f][k]) + "\n";
      faces += " " + std::to_string(shape.faces[f][k] + 1) + "//" + std::to_string(++normal_count);
    }
    faces += "\n";
  }
  return text + faces;
}

// A vertex for each corner: all that differ in normals are split, and more.
std::string ply_text(const Shape& shape) {
  std::string vertices, faces;
  int count = 0;
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    faces += std::to_string(shape.faces[f].size());
    for (std::size_t k = 0; k < shape.faces[f].size(); ++k) {
      vertices += split_text_of(shape.positions[shape.faces[f][k]]).substr(1) +
                  split_text_of(shape.normals[f][k]) + "\n";
      faces += " " + std::to_string(count++);
    }
    faces += "\n";
  }
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) +
         "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
         "property float ny\nproperty float nz\nelement face " +
         std::to_string(shape.faces.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n" + vertices + faces;
}

// Fans of triangles.
std::string glb_bytes(const Shape& shape, const std::string& nodes = "{\"mesh\":0}") {
  std::string positions, normals;
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    for (std::size_t k = 1; k + 1 < shape.faces[f].size(); ++k) {
      for (const std::size_t corner : {std::size_t{0}, k, k + 1}) {
        const glm::dvec3 &p = shape.positions[shape.faces[f][corner]],
                         &n = shape.normals[f][corner];
        positions += test::values<float>({p.x, p.y, p.z});
        normals += test::values<float>({n.x, n.y, n.z});
      }
    }
  }
  test::GlbParts parts;
  const std::size_t count = positions.size() / 12;
  parts.json["nodes"] = nlohmann::json::parse("[" + nodes + "]");
  parts.json["meshes"] = {{{"primitives",
                            {{{"attributes",
                               {{"POSITION", parts.add_accessor(positions, 5126, count, "VEC3")},
                                {"NORMAL", parts.add_accessor(normals, 5126, count, "VEC3")}}}}}}}};
  return parts.glb();
}

MeshFile read_split(const std::string& bytes, FileFormat format, bool creases = true) {
  FileBytes file = test::file_of(bytes, "shape");
  file.split_normals_crease = creases;
  return read_mesh(file, format);
}

PlacePair pair_of(const glm::dvec3& a, const glm::dvec3& b) {
  const auto rounded = [](const glm::dvec3& p) {
    Place place{};
    for (int axis = 0; axis < 3; ++axis) place[axis] = std::round(p[axis] * 1e4) / 1e4 + 0.0;
    return place;
  };
  const Place u = rounded(a), v = rounded(b);
  return {std::min(u, v), std::max(u, v)};
}

std::set<PlacePair> creases_of(const PolygonMesh& mesh) {
  std::set<PlacePair> places;
  for (const CreaseEdge& crease : mesh.creases)
    places.insert(pair_of(mesh.positions[crease.v0], mesh.positions[crease.v1]));
  EXPECT_EQ(places.size(), mesh.creases.size());
  return places;
}

// The edges that are sharp: those between faces for which `is_sharp` holds.
std::set<PlacePair> rims(const Shape& shape, std::size_t first_face) {
  std::set<PlacePair> places;
  for (std::size_t f = first_face; f < shape.faces.size(); ++f)
    for (std::size_t k = 0; k < shape.faces[f].size(); ++k)
      places.insert(pair_of(shape.positions[shape.faces[f][k]],
                            shape.positions[shape.faces[f][(k + 1) % shape.faces[f].size()]]));
  return places;
}

std::vector<std::pair<FileFormat, std::string>> in_all_formats(const Shape& shape) {
  return {{FileFormat::Obj, obj_text(shape)},
          {FileFormat::Ply, ply_text(shape)},
          {FileFormat::Glb, glb_bytes(shape)}};
}

TEST(SplitNormals, AllEdgesOfAFlatCubeAreSharp) {
  const Shape shape = cube(true);
  for (const auto& [format, bytes] : in_all_formats(shape)) {
    SCOPED_TRACE(name_of(format));
    const MeshFile file = read_split(bytes, format);
    EXPECT_EQ(file.mesh.vertex_count(), 8);
    EXPECT_EQ(file.mesh.creases.size(), 12u);
    EXPECT_EQ(creases_of(file.mesh), rims(shape, 0));
    for (const CreaseEdge& crease : file.mesh.creases)
      EXPECT_EQ(crease.sharpness, kInfiniteSharpness);
    EXPECT_TRUE(file.normals.empty());
    EXPECT_TRUE(read_split(bytes, format, false).mesh.creases.empty());
  }
}

TEST(SplitNormals, OnlyTheRimsOfACylinderAreSharp) {
  const Shape shape = cylinder();
  for (const auto& [format, bytes] : in_all_formats(shape)) {
    SCOPED_TRACE(name_of(format));
    const MeshFile file = read_split(bytes, format);
    EXPECT_EQ(file.mesh.vertex_count(), 2 * kSides);
    EXPECT_EQ(file.mesh.creases.size(), 2u * kSides);
    EXPECT_EQ(creases_of(file.mesh), rims(shape, kSides));
  }
}

TEST(SplitNormals, NoEdgeOfASmoothCubeIsSharp) {
  for (const auto& [format, bytes] : in_all_formats(cube(false)))
    EXPECT_TRUE(read_split(bytes, format).mesh.creases.empty());
}

// A quarter of a tube, mirrored and turned to a whole one.
TEST(SplitNormals, AreTurnedAndMirroredWithTheirNodes) {
  Shape quarter;
  const double half = std::sqrt(0.5);
  for (const double z : {0.0, 1.0})
    for (const glm::dvec2& p : {glm::dvec2(1, 0), glm::dvec2(half, half), glm::dvec2(0, 1)})
      quarter.positions.emplace_back(p, z);
  for (const int i : {0, 1})
    quarter.add({i, i + 1, i + 4, i + 3}, [&](int v) {
      return glm::dvec3(quarter.positions[v].x, quarter.positions[v].y, 0);
    });
  const std::string nodes = R"({"mesh":0},{"mesh":0,"scale":[-1,1,1]},)"
                            R"({"mesh":0,"rotation":[0,0,1,0]},{"mesh":0,"scale":[1,-1,1]})";
  const MeshFile file = read_split(glb_bytes(quarter, nodes), FileFormat::Glb);
  EXPECT_EQ(file.mesh.vertex_count(), 16);
  EXPECT_TRUE(file.mesh.creases.empty());
}

TEST(SplitNormals, TagsOfTheFileKeepTheirSharpness) {
  const MeshFile file =
      read_split(obj_text(cube(true)) + "t crease 2/1/0 1 0 2.5\n", FileFormat::Obj);
  ASSERT_EQ(file.mesh.creases.size(), 12u);
  EXPECT_EQ(file.mesh.creases.front().sharpness, 2.5f);
}

TEST(SplitNormals, RoundedNormalsAreNotSplit) {
  const auto with_tilt = [](double degrees) {
    const double tilt = std::sin(degrees * 3.14159265358979 / 180);
    return read_split("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn " + std::to_string(tilt) +
                          " 0 1\nf 1//1 2//-2 3//1\nf 1//2 3//2 4//-1\n",
                      FileFormat::Obj)
        .mesh.creases.size();
  };
  EXPECT_EQ(with_tilt(0.7), 0u);
  EXPECT_EQ(with_tilt(1.4), 1u);
}

TEST(SplitNormals, CornersWithoutANormalSayNothing) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn nan 0 0\n";
  for (const char* faces :
       {"f 1//1 2//1 3//1\nf 1/ 3/ 4/\n", "f 1//1 2//1 3//1\nf 1//2 3//2 4//2\n"})
    EXPECT_TRUE(read_split(square + faces, FileFormat::Obj).mesh.creases.empty());
}

TEST(SplitNormals, WeldingKeepsTagsAndTheFirstColour) {
  MeshFile file;
  file.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  file.mesh.add_face(std::vector<std::int32_t>{0, 1, 2});
  file.mesh.add_face(std::vector<std::int32_t>{3, 4, 2});
  file.mesh.creases = {{2, 3, 4.0f}, {1, 3, 1.0f}};
  file.mesh.corners = {{4, 3.0f}};
  file.mesh.colors.assign(5, glm::vec4(0.5f));
  file.mesh.colors[3] = glm::vec4(1.0f);
  weld_repeated_vertices(file);
  EXPECT_EQ(file.welded_vertex_count, 1);
  EXPECT_THAT(file.mesh.face_vertices, testing::ElementsAre(0, 1, 2, 1, 3, 2));
  ASSERT_EQ(file.mesh.creases.size(), 1u);
  EXPECT_EQ(file.mesh.creases[0].v1, 1);
  EXPECT_EQ(file.mesh.corners[0].vertex, 3);
  EXPECT_EQ(file.mesh.colors[1], glm::vec4(0.5f));
}

}  // namespace
}  // namespace planish
