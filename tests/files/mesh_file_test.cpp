#include "planish/files/mesh_file.h"
#include <set>
#include "planish/files/read_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <limits>
#include <random>

#include "files/read_bytes.h"
#include "mesh/test_meshes.h"
#include "planish/mesh/check.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr FileFormat kWritable[] = {FileFormat::Obj, FileFormat::Ply, FileFormat::Off};

// Positions of every magnitude, faces of 3 to 300 corners.
PolygonMesh random_mesh() {
  std::mt19937_64 random(11);
  PolygonMesh mesh;
  for (int i = 0; i < 400; ++i) {
    glm::dvec3 position;
    for (int axis = 0; axis < 3; ++axis) {
      double value = std::numeric_limits<double>::infinity();
      while (!std::isfinite(value)) value = std::bit_cast<double>(random());
      position[axis] = value;
    }
    mesh.positions.push_back(position);
  }
  mesh.positions[0] = {-0.0, 0.1, std::numeric_limits<double>::denorm_min()};
  for (const int size : {3, 4, 7, 300}) {
    std::vector<std::int32_t> face;
    for (int i = 0; i < size; ++i) face.push_back(static_cast<std::int32_t>(random() % 400));
    mesh.add_face(face);
  }
  return mesh;
}

bool same_bits(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) {
  // memcmp takes no null pointer, even for no bytes.
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

MeshFile round_trip(const PolygonMesh& mesh, FileFormat format,
                    const MeshWriteOptions& options = {}) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / ("mesh." + std::string(name_of(format)));
  write_mesh(path, format, mesh, options);
  return read_mesh(read_file(path), path.string(), format);
}

TEST(WriteMesh, IsReadBackBitByBit) {
  const MeshWriteOptions options{.header = {"planish weights=averaged", "planish tolerance=1e-06"}};
  for (const FileFormat format : kWritable) {
    SCOPED_TRACE(name_of(format));
    for (const PolygonMesh& mesh : {random_mesh(), test::cube(), PolygonMesh{}}) {
      const MeshFile again = round_trip(mesh, format, options);
      EXPECT_TRUE(same_bits(mesh.positions, again.mesh.positions));
      EXPECT_EQ(mesh.face_offsets, again.mesh.face_offsets);
      EXPECT_EQ(mesh.face_vertices, again.mesh.face_vertices);
      EXPECT_EQ(again.header, options.header);
    }
  }
}

// A cube with everything that a mesh can have.
PolygonMesh full_mesh() {
  PolygonMesh mesh = test::cube();
  for (int i = 0; i < 9; ++i) mesh.uvs.emplace_back(0.1 * i, 1e-3 / (i + 1));
  for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c)
    mesh.face_uvs.push_back(c % 5 == 0 ? -1 : static_cast<std::int32_t>(c % 9));
  for (int v = 0; v < mesh.vertex_count(); ++v)
    mesh.colors.emplace_back(v / 7.0f, 0.001f * v, 1.0f, v % 2 ? 1.0f : 0.3f);
  mesh.groups = {{"", ""}, {"left side", "red"}, {"left side", ""}, {"", "blue"}};
  mesh.face_groups = {0, 1, 2, 3, 0, 1};
  mesh.creases = {{0, 1, 2.5f}, {1, 3, 0.1f}, {3, 2}};
  mesh.corners = {{7}, {5, 1e-3f}};
  mesh.hole_faces = {4, 2};
  return mesh;
}

TEST(WriteMesh, KeepsEveryAttributeInObj) {
  const PolygonMesh mesh = full_mesh();
  const MeshFile file = round_trip(mesh, FileFormat::Obj);
  const PolygonMesh& again = file.mesh;
  EXPECT_EQ(file.warnings.size(), 0u);
  EXPECT_EQ(again.uvs, mesh.uvs);
  EXPECT_EQ(again.face_uvs, mesh.face_uvs);
  EXPECT_EQ(again.colors, mesh.colors);
  EXPECT_EQ(again.face_groups, mesh.face_groups);
  EXPECT_EQ(again.hole_faces, mesh.hole_faces);
  const auto tags_of = [](const PolygonMesh& of) {
    std::vector<std::tuple<int, int, float>> tags;
    for (const CreaseEdge& crease : of.creases)
      tags.emplace_back(crease.v0, crease.v1, crease.sharpness);
    for (const CornerVertex& corner : of.corners)
      tags.emplace_back(corner.vertex, -1, corner.sharpness);
    return tags;
  };
  EXPECT_EQ(tags_of(again), tags_of(mesh));
  const auto names = [](const PolygonMesh& of) {
    std::vector<std::pair<std::string, std::string>> groups;
    for (const FaceGroup& group : of.groups) groups.emplace_back(group.name, group.material);
    return groups;
  };
  EXPECT_EQ(names(again), names(mesh));
}

std::vector<glm::dvec2> corner_uvs(const PolygonMesh& mesh) {
  std::vector<glm::dvec2> values;
  for (const std::int32_t uv : mesh.face_uvs)
    values.push_back(uv < 0 ? glm::dvec2(-7) : glm::dvec2(glm::vec2(mesh.uvs[uv])));
  return values;
}

std::string ply_header(const PolygonMesh& mesh) {
  const test::TemporaryFolder folder;
  write_mesh(folder.path() / "a.ply", FileFormat::Ply, mesh);
  const std::string text = test::content_of(folder.path() / "a.ply");
  return text.substr(0, text.find("end_header"));
}

// Blender knows coordinates of vertices alone.
TEST(WriteMesh, PlyHasTextureCoordinatesOfVerticesWhereThereIsNoSeam) {
  PolygonMesh mesh = test::cube();
  for (int v = 0; v < 8; ++v) mesh.uvs.emplace_back(0.1 * v, 1 - 0.01 * v);
  mesh.face_uvs = mesh.face_vertices;
  mesh.uvs.push_back(mesh.uvs[3]);  // another number for the same place
  *std::ranges::find(mesh.face_uvs, 3) = 8;
  EXPECT_THAT(ply_header(mesh), HasSubstr("property float s\nproperty float t\nelement face"));
  EXPECT_THAT(ply_header(mesh), testing::Not(HasSubstr("texcoord")));
  const PolygonMesh again = round_trip(mesh, FileFormat::Ply).mesh;
  EXPECT_EQ(corner_uvs(again), corner_uvs(mesh));
  EXPECT_EQ(again.uvs.size(), 8u);
  EXPECT_EQ(again.positions, mesh.positions);
}

TEST(WriteMesh, PlyHasTextureCoordinatesOfFacesBesideSeams) {
  PolygonMesh mesh = test::cube();
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.25, 0.125}};
  for (int c = 0; c < 24; ++c) mesh.face_uvs.push_back(c % 4);
  mesh.face_uvs[7] = 4;
  EXPECT_THAT(ply_header(mesh), HasSubstr("property list uchar float texcoord\n"));
  EXPECT_THAT(ply_header(mesh), testing::Not(HasSubstr("property float s")));
  PolygonMesh again = round_trip(mesh, FileFormat::Ply).mesh;
  EXPECT_EQ(corner_uvs(again), corner_uvs(mesh));
  EXPECT_EQ(again.positions.size(), 8u);
  EXPECT_TRUE(check(again).empty());
  // Corners of a vertex share what is equal.
  std::set<std::array<double, 3>> distinct;
  for (std::size_t c = 0; c < 24; ++c) {
    const glm::dvec2 uv = mesh.uvs[mesh.face_uvs[c]];
    distinct.insert({double(mesh.face_vertices[c]), uv.x, uv.y});
  }
  EXPECT_EQ(again.uvs.size(), distinct.size());
  // A face that lacks one has none.
  mesh.face_uvs[5] = -1;
  again = round_trip(mesh, FileFormat::Ply).mesh;
  std::vector<glm::dvec2> expected = corner_uvs(mesh);
  for (int c = 4; c < 8; ++c) expected[c] = glm::dvec2(-7);
  EXPECT_EQ(corner_uvs(again), expected);
}

// Counts are bytes as long as they fit, of corners and of the numbers that those have.
TEST(WriteMesh, PlyFacesOfAnySize) {
  for (const int size : {127, 128, 255, 256, 257}) {
    SCOPED_TRACE(size);
    PolygonMesh mesh = test::mesh_of(size, {{0, 1, 2}});
    std::vector<std::int32_t> face(size);
    for (int i = 0; i < size; ++i) face[i] = size - 1 - i;
    mesh.add_face(face);
    for (int c = 0; c < size + 3; ++c) {
      mesh.uvs.emplace_back(c, -c);
      mesh.face_uvs.push_back(c);
    }
    const std::string header = ply_header(mesh);
    EXPECT_THAT(header, HasSubstr(size <= 255 ? "list uchar int vertex" : "list int int vertex"));
    EXPECT_THAT(header, HasSubstr(size <= 127 ? "list uchar float tex" : "list int float tex"));
    const PolygonMesh again = round_trip(mesh, FileFormat::Ply).mesh;
    EXPECT_EQ(again.face_offsets, mesh.face_offsets);
    EXPECT_EQ(again.face_vertices, mesh.face_vertices);
    EXPECT_EQ(corner_uvs(again), corner_uvs(mesh));
  }
}

TEST(ReadMesh, TextureListsOfPlyThatDoNotFitAreLeftOut) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 3\nproperty list uchar int vertex_indices\n"
      "property list uchar float texcoord\nproperty int flags\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
      "3 0 1 2 6 0 0 1 0 0 1 9\n3 0 2 3 0 9\n3 0 3 1 4 0 0 1 0 9\n";
  const MeshFile file = read_mesh(test::bytes_of(text), "a.ply", FileFormat::Ply);
  EXPECT_THAT(file.mesh.face_uvs, ElementsAre(0, 1, 2, -1, -1, -1, -1, -1, -1));
  EXPECT_EQ(file.mesh.uvs, (std::vector<glm::dvec2>{{0, 0}, {1, 0}, {0, 1}}));
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_EQ(file.warnings[0].count, 1);
  EXPECT_EQ(file.warnings[0].first, 2);
}

TEST(WriteMesh, WritesTheTextExpected) {
  const test::TemporaryFolder folder;
  PolygonMesh mesh = test::mesh_of(3, {{0, 1, 2}});
  mesh.positions[2] = {0.1, -1e30, 3};
  mesh.creases = {{0, 1}};
  const auto text_of = [&](FileFormat format) {
    write_mesh(folder.path() / "mesh", format, mesh, {.header = {"hello"}});
    return test::content_of(folder.path() / "mesh");
  };
  EXPECT_EQ(text_of(FileFormat::Obj),
            "# hello\nv 0 0 0\nv 1 1 1\nv 0.1 -1e+30 3\nf 1 2 3\nt crease 2/1/0 0 1 10\n");
  mesh.colors = {{1, 0, 0, 1}, {0, 0, 0, 0.5f}, {1, 1, 1, 1}};
  mesh.uvs = {{0.5, 1}};
  mesh.face_uvs = {0, -1, 0};
  mesh.groups = {{"a", "b"}};
  mesh.face_groups = {0};
  mesh.hole_faces = {0};
  EXPECT_EQ(text_of(FileFormat::Obj),
            "# hello\nmtllib mesh.mtl\nv 0 0 0 1 0 0\nv 1 1 1 0 0 0 0.5\nv 0.1 -1e+30 3 1 1 1\n"
            "vt 0.5 1\ng a\nusemtl b\nf 1/1 2 3/1\nt crease 2/1/0 0 1 10\nt hole 1/0/0 0\n");
  EXPECT_EQ(text_of(FileFormat::Off), "OFF\n# hello\n3 1 0\n0 0 0\n1 1 1\n0.1 -1e+30 3\n3 0 1 2\n");
}

TEST(WriteMesh, RefusesWhatCouldNotBeReadBack) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "a.obj";
  PolygonMesh flat = test::cube(), open = test::cube();
  flat.uvs = {{0, std::numeric_limits<double>::infinity()}};
  open.positions[4].y = std::numeric_limits<double>::quiet_NaN();
  struct Row {
    FileFormat format;
    PolygonMesh mesh;
    std::vector<std::string> header;
    std::string message;
  };
  for (const Row& row : std::vector<Row>{
           {FileFormat::Xyz,
            test::cube(),
            {},
            "polygons are written as .obj, .ply, .off or .usda, not as .xyz"},
           {FileFormat::Obj, test::cube(), {"a\nv 1 2 3"}, "a header line holds a line break"},
           {FileFormat::Obj,
            flat,
            {},
            "texture coordinate 0 is not finite: (0, inf); mend what made it, or leave it out"},
           {FileFormat::Obj,
            open,
            {},
            "vertex 4 is not finite: (0, nan, 1); mend what made it, or leave it out"}})
    EXPECT_EQ(
        test::message_of(ErrorCode::InvalidArgument,
                         [&] { write_mesh(path, row.format, row.mesh, {.header = row.header}); }),
        path.string() + ": " + row.message);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(WriteMesh, NamesAFolderThatIsMissing) {
  EXPECT_THAT(test::message_of(ErrorCode::UnwritableOutput,
                               [] { write_mesh("/no/such/a.obj", FileFormat::Obj, test::cube()); }),
              HasSubstr("/no/such/a.obj: cannot create: No such file or directory"));
}

TEST(ReadFile, NamesTheReason) {
  EXPECT_EQ(test::message_of(ErrorCode::UnreadableInput, [] { (void)read_file("/no/such"); }),
            "/no/such: cannot read: No such file or directory");
  EXPECT_EQ(test::message_of(ErrorCode::UnreadableInput, [] { (void)read_file("/tmp"); }),
            "/tmp: cannot read: Is a directory");
}

TEST(ReadFile, ReadsFilesOfUnknownSize) {
  EXPECT_GT(read_file("/proc/self/maps").size(), 100u);
  EXPECT_EQ(read_file("/dev/null").size(), 0u);
}

TEST(ReadMesh, RefusesFormatsOfPointsAndUnknownExtensions) {
  EXPECT_EQ(test::message_of(ErrorCode::InvalidArgument,
                             [] { (void)read_mesh({}, "a.xyz", FileFormat::Xyz); }),
            "a.xyz: .xyz holds points, and a polygon mesh is wanted; read_points() and "
            "reconstruct() make one of them");
  EXPECT_EQ(test::message_of(ErrorCode::InvalidArgument, [] { (void)read_mesh("a.blend"); }),
            "a.blend: the extension \".blend\" names no format of meshes that is read "
            "(glb, gltf, obj, ply, off, stl)");
}

TEST(Formats, StandAtTheirPlaceWithNamesOfTheirOwn) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < formats().size(); ++i) {
    const FileFormat format = formats()[i].format;
    EXPECT_EQ(static_cast<std::size_t>(format), i);
    EXPECT_TRUE(names.insert(name_of(format)).second) << name_of(format);
    EXPECT_EQ(format_of("x." + std::string(name_of(format))), format);
    EXPECT_FALSE(formats()[i].title.empty());
  }
  EXPECT_EQ(format_of("a/b.OBJ"), FileFormat::Obj);
  EXPECT_EQ(format_of("b.c.gltf"), FileFormat::Gltf);
  EXPECT_EQ(format_of("x.STP"), FileFormat::Step);
  for (const char* name : {"x.", "obj", "b.blend"}) EXPECT_EQ(format_of(name), std::nullopt);
}

TEST(Formats, AreListedByUse) {
  EXPECT_EQ(names_of(FormatUse::ReadMesh), "glb, gltf, obj, ply, off, stl");
  EXPECT_EQ(names_of(FormatUse::ReadPoints), "glb, gltf, obj, ply, off, xyz, pts, pcd, las, ptx");
  EXPECT_EQ(extensions_of(FormatUse::WriteSurface),
            ".glb .gltf .obj .ply .off .stl .usda .json .step");
  EXPECT_EQ(extensions_in_words(FormatUse::WriteMesh), ".obj, .ply, .off or .usda");
  EXPECT_TRUE(holds_points_only(FileFormat::Pcd));
  EXPECT_FALSE(holds_points_only(FileFormat::Ply));
}

// Real files, where a folder with them is named.
TEST(ReadMesh, ReadsRealFiles) {
  const char* folder = std::getenv("PLANISH_TEST_DATA");
  if (!folder) GTEST_SKIP() << "PLANISH_TEST_DATA names no folder";
  const std::filesystem::path base(folder);
  const std::tuple<const char*, int, int> files[] = {{"rocker-arm.obj", 10044, 20088},
                                                     {"spot.obj", 2930, 5856},
                                                     {"suzanne.obj", 507, 500},
                                                     {"stanford-bunny.obj", 35947, 69451},
                                                     {"rocker-arm_uniform_81920.ply", 81920, 0}};
  for (const auto& [name, vertices, faces] : files) {
    const MeshFile file = read_mesh(read_file(base / name), name, *format_of(name));
    EXPECT_EQ(file.mesh.vertex_count(), vertices) << name;
    EXPECT_EQ(file.mesh.face_count(), faces) << name;
    EXPECT_EQ(check(file.mesh).empty(), faces > 0) << name;
  }
}

}  // namespace
}  // namespace planish
