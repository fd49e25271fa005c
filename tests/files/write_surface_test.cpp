#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <span>

#include "files/read_bytes.h"
#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/files/write_surface.h"
#include "planish/surface/doo_sabin_surface.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

SurfaceMesh two_quads() {
  SurfaceMesh surface;
  surface.level = 1;
  surface.positions = {{0, 0, 0}, {1, 0, 0.1}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}};
  surface.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0.6f, 0, 0.8f}, {0, 1, 0}};
  surface.face_vertices = {0, 1, 2, 3, 1, 4, 5, 2};
  return surface;
}

std::string written_surface(FileFormat format, const SurfaceMesh& surface,
                            std::span<const NamedField> fields = {}) {
  const test::TemporaryFolder folder;
  write_surface(folder.path() / "surface", format, surface, {"planish level=1"}, fields);
  return test::content_of(folder.path() / "surface");
}

TEST(WriteSurface, PlyCarriesFieldsBehindEverythingElse) {
  const std::vector<float> values{1, 2, 3, 4, 5, -6.5f};
  const std::string text =
      written_surface(FileFormat::Ply, two_quads(), std::vector<NamedField>{{"error", values}});
  const std::size_t header = text.find("end_header\n") + 11;
  EXPECT_THAT(text, HasSubstr("property float nz\nproperty float error\nelement face 2\n"));
  constexpr std::size_t kVertex = 3 * 8 + 3 * 4 + 4;
  for (std::size_t v = 0; v < values.size(); ++v) {
    float value = 0;
    std::memcpy(&value, text.data() + header + (v + 1) * kVertex - 4, 4);
    EXPECT_EQ(value, values[v]);
  }
}

// Groups, seams, colours and more faces than a piece has.
TEST(WriteSurface, BlocksGiveTheBytesOfTheWhole) {
  PolygonMesh mesh = test::torus(12, 8);
  for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c)
    mesh.face_uvs.push_back(static_cast<std::int32_t>(c % mesh.positions.size()));
  mesh.uvs.assign(mesh.positions.size(), glm::dvec2(0.25, 0.75));
  mesh.colors.assign(mesh.positions.size(), glm::vec4(0.5f, 0.25f, 1, 1));
  mesh.groups = {{"a", "x"}, {"", "y"}, {"b", ""}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) mesh.face_groups.push_back(f / 7 % 3);
  const DooSabinSurface base(mesh, {});
  for (const int level : {0, 1, 5}) {
    const auto blocks = base.level(level);
    const SurfaceMesh surface = collect(*blocks, {});
    const std::vector<float> values(surface.positions.size(), 0.5f);
    const std::vector<NamedField> fields{{"error", values}};
    for (const FileFormat format :
         {FileFormat::Obj, FileFormat::Ply, FileFormat::Off, FileFormat::Stl, FileFormat::Usda}) {
      SCOPED_TRACE(std::string(name_of(format)) + " level " + std::to_string(level));
      const test::TemporaryFolder folder;
      write_surface(folder.path() / "a.whole", format, surface, {"a line"}, fields);
      RawVector<std::byte> observed;
      const std::uint64_t bytes =
          write_surface(folder.path() / "a.blocks", format, *blocks,
                        {.header = {"a line"},
                         .fields = fields,
                         .observe =
                             [&](std::span<const std::byte> some) {
                               observed.insert(observed.end(), some.begin(), some.end());
                             },
                         .callbacks = {}});
      const auto whole = read_file(folder.path() / "a.whole");
      EXPECT_TRUE(whole == read_file(folder.path() / "a.blocks"));
      EXPECT_TRUE(whole == observed);
      EXPECT_EQ(bytes, whole.size());
    }
  }
}

TEST(WriteSurface, TheFirstNumberThatIsNotFiniteIsNamed) {
  SurfaceMesh surface;
  surface.level = 1;
  surface.positions.assign(40000, glm::dvec3(1));
  surface.normals.assign(40000, glm::vec3(0, 0, 1));
  surface.face_vertices = {0, 1, 2, 3};
  surface.positions[39000].y = surface.positions[17001].x = std::nan("");
  const test::TemporaryFolder folder;
  for (const FileFormat format : {FileFormat::Obj, FileFormat::Ply, FileFormat::Off}) {
    try {
      write_surface(folder.path() / "s", format, surface);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.element(), 17001);
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  }
}

constexpr FileFormat kPolygonFormats[] = {FileFormat::Obj, FileFormat::Ply, FileFormat::Off,
                                          FileFormat::Stl, FileFormat::Usda};

std::string refusal(FileFormat format, const SurfaceMesh& surface,
                    std::span<const NamedField> fields = {}) {
  const test::TemporaryFolder folder;
  const std::string message = test::message_of(ErrorCode::InvalidArgument, [&] {
    write_surface(folder.path() / "s", format, surface, {}, fields);
  });
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  const std::string name = visible(folder.path() / "s") + ": ";
  return message.starts_with(name) ? message.substr(name.size()) : message;
}

TEST(WriteSurface, IndicesAndCountsThatDoNotFitAreRefused) {
  struct Row {
    const char* message;
    void (*spoil)(SurfaceMesh&);
  };
  for (const auto& [message, spoil] : {
           Row{"face corner 3 names vertex 6 of 6", [](auto& s) { s.face_vertices[3] = 6; }},
           Row{"face corner 7 names vertex -1 of 6", [](auto& s) { s.face_vertices[7] = -1; }},
           Row{"the number of quad corners is no multiple of 4",
               [](auto& s) { s.face_vertices.pop_back(), s.face_uvs.pop_back(); }},
           Row{"face 0 has 1 corner, at least 3 are needed",
               [](auto& s) {
                 s.face_offsets = {0, 1, 8};
               }},
           Row{"face 1 has 2 corners, at least 3 are needed",
               [](auto& s) {
                 s.face_offsets = {0, 6, 8};
               }},
           Row{"face 0 spans corners 0 to 9 of 8",
               [](auto& s) {
                 s.face_offsets = {0, 9, 8};
               }},
           Row{"the face offsets do not span the face corners",
               [](auto& s) {
                 s.face_offsets = {0, 4, 7};
               }},
           Row{"5 normals for 6 positions", [](auto& s) { s.normals.pop_back(); }},
           Row{"5 colours where 6 are needed, or none", [](auto& s) { s.colors.pop_back(); }},
           Row{"7 corners of the texture where 8 are needed, or none",
               [](auto& s) { s.face_uvs.pop_back(); }},
           Row{"the texture coordinate of corner 2 has number 2 of 2",
               [](auto& s) { s.face_uvs[2] = 2; }},
           Row{"1 groups of faces where 2 are needed, or none",
               [](auto& s) { s.face_groups.pop_back(); }},
           Row{"the group of face 1 has number 1 of 1", [](auto& s) { s.face_groups[1] = 1; }},
       }) {
    SurfaceMesh surface = two_quads();
    surface.uvs = {{0, 0}, {0.5, 0}};
    surface.face_uvs = {0, 1, 0, 1, 0, 1, 0, 1};
    surface.groups = {{"a", "x"}};
    surface.face_groups = {0, 0};
    surface.colors.assign(6, glm::vec4(1));
    spoil(surface);
    for (const FileFormat format : kPolygonFormats)
      EXPECT_EQ(refusal(format, surface), message) << name_of(format);
  }
}

TEST(WriteSurface, NormalsAndFieldsThatAreNotFiniteAreRefused) {
  SurfaceMesh surface = two_quads();
  std::vector<float> values{1, 2, 3, 4, 5, 6};
  std::vector<NamedField> fields{{"error", values}};
  surface.normals[4].z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(
      refusal(FileFormat::Ply, surface),
      "the normal of vertex 4 is not finite: (0.6, 0, nan); mend what made it, or leave it out");
  surface = two_quads();
  values[3] = std::numeric_limits<float>::infinity();
  for (const FileFormat format : {FileFormat::Ply, FileFormat::Usda})
    EXPECT_EQ(refusal(format, surface, fields),
              "error of vertex 3 is not finite: inf; mend what made it, or leave it out");
  fields[0].values = std::span(values).first(3);
  for (const FileFormat format : kPolygonFormats)
    EXPECT_EQ(refusal(format, surface, fields), "3 values of error for 6 positions");
  // float32, which USD's coordinates are, holds less than double.
  surface.uvs = {{0, 1e39}};
  surface.face_uvs.assign(8, 0);
  EXPECT_EQ(refusal(FileFormat::Usda, surface),
            "texture coordinate 0 has a coordinate that float32 cannot hold; bring it near 0 to 1");
}

TEST(WriteSurface, FieldsOfBlocksAreAsManyAsTheirRows) {
  const PolygonMesh mesh = test::torus(4, 4);
  const DooSabinSurface base(mesh, {});
  const std::vector<float> values(15, 0.5f);
  const std::vector<NamedField> fields{{"error", values}};
  const test::TemporaryFolder folder;
  EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                               [&] {
                                 write_surface(folder.path() / "s", FileFormat::Ply, *base.level(0),
                                               {.fields = fields, .callbacks = {}});
                               }),
              HasSubstr("s: 15 values of error for 16 positions"));
}

TEST(WriteSurface, ObjCarriesNormals) {
  EXPECT_EQ(written_surface(FileFormat::Obj, two_quads()),
            "# planish level=1\nv 0 0 0\nv 1 0 0.1\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n"
            "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0.6 0 0.8\nvn 0 1 0\n"
            "f 1//1 2//2 3//3 4//4\nf 2//2 5//5 6//6 3//3\n");
}

TEST(WriteSurface, ObjCarriesAttributes) {
  SurfaceMesh surface = two_quads();
  surface.uvs = {{0, 0}, {0.5, 0}, {0.5, 1}, {0, 1}, {2, 3}};
  surface.face_uvs = {0, 1, 2, 3, 4, 4, 4, 4};
  surface.colors.assign(6, glm::vec4(0, 1, 0, 1));
  surface.groups = {{"a", "x"}, {"a", "y"}};
  surface.face_groups = {0, 1};
  EXPECT_EQ(written_surface(FileFormat::Obj, surface),
            "# planish level=1\nmtllib surface.mtl\nv 0 0 0 0 1 0\nv 1 0 0.1 0 1 0\n"
            "v 1 1 0 0 1 0\nv 0 1 0 0 1 0\n"
            "v 2 0 0 0 1 0\nv 2 1 0 0 1 0\nvt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nvt 2 3\n"
            "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0.6 0 0.8\nvn 0 1 0\n"
            "g a\nusemtl x\nf 1/1/1 2/2/2 3/3/3 4/4/4\nusemtl y\nf 2/5/2 5/5/5 6/5/6 3/5/3\n");
}

TEST(WriteSurface, OffCarriesPositionsAndPolygonsOfLevelZero) {
  SurfaceMesh surface = two_quads();
  const std::string start =
      "OFF\n# planish level=1\n6 2 0\n0 0 0\n1 0 0.1\n1 1 0\n0 1 0\n2 0 0\n2 1 0\n";
  EXPECT_EQ(written_surface(FileFormat::Off, surface), start + "4 0 1 2 3\n4 1 4 5 2\n");
  surface.level = 0;
  surface.face_offsets = {0, 3, 8};
  EXPECT_EQ(written_surface(FileFormat::Off, surface), start + "3 0 1 2\n5 3 1 4 5 2\n");
}

TEST(WriteSurface, PlyIsReadBackWithItsNormals) {
  const SurfaceMesh surface = two_quads();
  const std::string text = written_surface(FileFormat::Ply, surface);
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment planish level=1\nelement vertex 6\n"
      "property double x\nproperty double y\nproperty double z\nproperty float nx\n"
      "property float ny\nproperty float nz\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n";
  ASSERT_TRUE(text.starts_with(header)) << text;
  EXPECT_EQ(text.size(), header.size() + 6 * (3 * 8 + 3 * 4) + 2 * (1 + 4 * 4));
  const MeshFile file = read_mesh(test::bytes_of(text), "surface", FileFormat::Ply);
  EXPECT_EQ(file.mesh.positions, surface.positions);
  EXPECT_EQ(file.mesh.face_vertices, surface.face_vertices);
  EXPECT_THAT(file.mesh.face_offsets, ElementsAre(0, 4, 8));
  for (std::size_t v = 0; v < surface.normals.size(); ++v) {
    glm::vec3 normal;
    std::memcpy(&normal, text.data() + header.size() + v * 36 + 24, sizeof(normal));
    EXPECT_EQ(normal, surface.normals[v]);
  }
}

TEST(WriteSurface, StlIsReadBackAsTriangles) {
  const SurfaceMesh surface = two_quads();
  const std::string bytes = written_surface(FileFormat::Stl, surface);
  EXPECT_EQ(bytes.size(), 84u + 4 * 50);
  EXPECT_FALSE(bytes.starts_with("solid"));
  float normal[3];
  std::memcpy(normal, bytes.data() + 84, sizeof normal);
  EXPECT_NEAR(glm::length(glm::vec3(normal[0], normal[1], normal[2])), 1, 1e-6);
  const PolygonMesh mesh = read_mesh(test::bytes_of(bytes), "s", FileFormat::Stl).mesh;
  EXPECT_EQ(mesh.face_count(), 4);
  ASSERT_EQ(mesh.positions.size(), 6u);
  for (const glm::dvec3& position : mesh.positions) {
    EXPECT_TRUE(std::ranges::any_of(surface.positions, [&](const glm::dvec3& p) {
      return glm::dvec3(glm::vec3(p)) == position;
    }));
  }
}

TEST(WriteSurface, UsdaCarriesEverything) {
  SurfaceMesh surface = two_quads();
  surface.uvs = {{0, 0}, {0.5, 0}, {0.5, 1}, {0, 1}};
  surface.face_uvs = {0, 1, 2, 3, 3, 2, 1, 0};
  surface.colors.assign(6, glm::vec4(0.5f, 0.25f, 1, 0.5f));
  surface.groups = {{"left side", "red"}, {"", ""}};
  surface.face_groups = {1, 0};
  const std::string text = written_surface(FileFormat::Usda, surface);
  for (const char* part :
       {"#usda 1.0\n(\n    defaultPrim = \"surface\"\n", "# planish level=1\n",
        "uniform token subdivisionScheme = \"none\"\n", "int[] faceVertexCounts = [4, 4]\n",
        "int[] faceVertexIndices = [0, 1, 2, 3, 1, 4, 5, 2]\n",
        "point3f[] points = [(0, 0, 0), (1, 0, 0.1), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)]",
        "(0.6, 0, 0.8), (0, 1, 0)] (\n        interpolation = \"vertex\"\n    )\n",
        "color3f[] primvars:displayColor = [(0.5, 0.25, 1),", "displayOpacity = [0.5, 0.5,",
        "texCoord2f[] primvars:st = [(0, 0), (0.5, 0), (0.5, 1), (0, 1)] (\n        "
        "interpolation = \"faceVarying\"",
        "int[] primvars:st:indices = [0, 1, 2, 3, 3, 2, 1, 0]\n",
        "def GeomSubset \"group_0_left_side\"", "int[] indices = [1]\n",
        "def GeomSubset \"group_1\"", "int[] indices = [0]\n"})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST(WriteSurface, UsdaOfBlocksSaysWhichAxisIsUp) {
  const PolygonMesh mesh = test::cube();
  const DooSabinSurface base(mesh, {});
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "a.usda";
  for (const bool is_z_up : {false, true}) {
    (void)write_surface(path, FileFormat::Usda, *base.level(1),
                        {.is_z_up = is_z_up, .callbacks = {}});
    EXPECT_EQ(test::content_of(path).find("upAxis = \"Z\"") != std::string::npos, is_z_up);
  }
}

TEST(WriteMesh, UsdaCagesSayHowTheyAreSubdivided) {
  const test::TemporaryFolder folder;
  PolygonMesh cube = test::cube();
  cube.creases = {{0, 1, 10.0f}, {1, 2, 2.5f}};
  cube.corners = {{3, 10.0f}};
  cube.hole_faces = {2};
  write_mesh(folder.path() / "c.usda", FileFormat::Usda, cube,
             {.header = {}, .subdivision = {"catmullClark", true}});
  const std::string text = test::content_of(folder.path() / "c.usda");
  for (const char* part :
       {"subdivisionScheme = \"catmullClark\"\n", "interpolateBoundary = \"edgeAndCorner\"\n",
        "creaseIndices = [0, 1, 1, 2]\n", "creaseLengths = [2, 2]\n",
        "creaseSharpnesses = [10, 2.5]\n", "cornerIndices = [3]\n", "cornerSharpnesses = [10]\n",
        "holeIndices = [2]\n"})
    EXPECT_THAT(text, HasSubstr(part));
  EXPECT_EQ(text.find("normals"), std::string::npos);
}

TEST(WriteSurface, FormatsOfFloatsRefuseWhatDoesNotFit) {
  SurfaceMesh surface = two_quads();
  surface.positions[4].x = 1e40;
  EXPECT_THROW((void)written_surface(FileFormat::Stl, surface), Error);
  EXPECT_THROW((void)written_surface(FileFormat::Usda, surface), Error);
  EXPECT_NO_THROW((void)written_surface(FileFormat::Ply, surface));
}

// Their counts do not fit into the byte that PLY's faces mostly have.
TEST(WriteSurface, LargePolygonsAreReadBack) {
  PolygonMesh mesh;
  std::vector<std::int32_t> large;
  for (std::int32_t i = 0; i < 300; ++i) {
    mesh.positions.emplace_back(std::cos(i * 0.02), std::sin(i * 0.02), 0);
    large.push_back(i);
  }
  mesh.positions.emplace_back(2, -1, 0);
  mesh.add_face(large);
  mesh.add_face(std::array{0, 299, 300});
  const DooSabinSurface surface(mesh, {});
  const test::TemporaryFolder folder;
  (void)write_surface(folder.path() / "a.ply", FileFormat::Ply, *surface.level(0), {});
  const PolygonMesh read = read_mesh(folder.path() / "a.ply").mesh;
  EXPECT_EQ(read.face_vertices, mesh.face_vertices);
  EXPECT_EQ(read.face_offsets, mesh.face_offsets);
}

// Numbers that are not finite, given to each writer: a named error, and no file.

using testing::AllOf;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(),
                 kInfinite = std::numeric_limits<double>::infinity();

SurfaceMesh mapped_quads() {
  SurfaceMesh surface = two_quads();
  surface.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}, {2, 1}};
  surface.face_uvs = surface.face_vertices;
  surface.colors.assign(6, glm::vec4(0.5f));
  return surface;
}

// What write(folder) is refused by; nothing is left.
std::string not_written(const std::function<void(const std::filesystem::path&)>& write) {
  const test::TemporaryFolder folder;
  const std::string message =
      test::message_of(ErrorCode::InvalidArgument, [&] { write(folder.path()); });
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  return message;
}

TEST(FiniteNumbers, OfSurfacesMadeAsTheyAreWritten) {
  for (const double wrong : {kNan, kInfinite, -kInfinite}) {
    for (const FileFormat format : kPolygonFormats) {
      const auto refused = [&](const auto& spoil) {
        SurfaceMesh surface = mapped_quads();
        spoil(surface);
        return not_written([&](const auto& folder) {
          write_surface(folder / "s.file", format, *blocks_of(surface, {}), {});
        });
      };
      EXPECT_THAT(refused([&](auto& s) { s.positions[4].y = wrong; }),
                  AllOf(HasSubstr("s.file: vertex 4 is not finite: ("), HasSubstr("; mend what")));
      if (format == FileFormat::Off || format == FileFormat::Stl) continue;
      EXPECT_THAT(refused([&](auto& s) { s.normals[2].x = static_cast<float>(wrong); }),
                  HasSubstr("the normal of vertex 2 is not finite: ("));
      EXPECT_THAT(refused([&](auto& s) { s.colors[3].a = static_cast<float>(wrong); }),
                  HasSubstr("the colour of vertex 3 is not finite: ("));
      EXPECT_THAT(refused([&](auto& s) { s.uvs[5].x = wrong; }),
                  HasSubstr("texture coordinate 5 is not finite"));
    }
  }
}

TEST(FiniteNumbers, OfGltf) {
  struct Row {
    const char* message;
    std::function<void(SurfaceMesh&, GltfOptions&)> spoil;
  };
  for (const double wrong : {kNan, kInfinite, -kInfinite}) {
    const auto narrow = static_cast<float>(wrong);
    const std::vector<float> values{1, narrow, 1, 1, 1, 1};
    std::vector<glm::dvec2> uvs(6);
    uvs[2].y = wrong;
    const std::vector<Row> rows{
        {"vertex 4 has a coordinate that float32 cannot hold: (",
         [&](auto& s, auto&) { s.positions[4].y = wrong; }},
        {"the normal of vertex 2 has length", [&](auto& s, auto&) { s.normals[2].x = narrow; }},
        {"the colour of vertex 3 is not finite: (",
         [&](auto& s, auto&) { s.colors[3].a = narrow; }},
        {"texture coordinate 5 is not finite: (", [&](auto& s, auto&) { s.uvs[5].x = wrong; }},
        {"error of vertex 1 is not finite: ",
         [&](auto&, auto& o) {
           o.fields = {{"error", values}};
         }},
        {"WEIGHT of number 1 is not finite: ",
         [&](auto&, auto& o) {
           o.attributes = {{.name = "WEIGHT", .width = 1, .values = values}};
         }},
        {"further texture coordinate 2 is not finite: (",
         [&](auto&, auto& o) { o.further_uvs = {uvs}; }}};
    for (const GltfCompression compression :
         {GltfCompression::None, GltfCompression::Quantize, GltfCompression::Meshopt}) {
      for (const char* name : {"s.glb", "s.gltf"}) {
        for (const std::uint64_t buffer_bytes : {std::uint64_t{1} << 30, std::uint64_t{100}}) {
          for (const auto& [message, spoil] : rows) {
            SurfaceMesh surface = mapped_quads();
            GltfOptions options;
            options.name = name;
            options.compression = compression;
            options.position_error = 1e-4;
            options.buffer_bytes = buffer_bytes;
            spoil(surface, options);
            EXPECT_THAT(not_written([&](const auto& folder) {
                          write_gltf(folder / name, *blocks_of(surface, {}), options);
                        }),
                        HasSubstr(message));
          }
        }
      }
    }
  }
}

TEST(FiniteNumbers, OfCages) {
  for (const double wrong : {kNan, kInfinite}) {
    for (const FileFormat format :
         {FileFormat::Obj, FileFormat::Ply, FileFormat::Off, FileFormat::Usda}) {
      PolygonMesh mesh = test::cube();
      mesh.positions[3].z = wrong;
      EXPECT_THAT(
          not_written([&](auto& folder) { write_mesh(folder / "cage.file", format, mesh); }),
          HasSubstr("cage.file: vertex 3 is not finite: ("));
    }
    PolygonMesh mesh = test::cube();
    mesh.creases = {{0, 1, std::numeric_limits<float>::quiet_NaN()}};
    EXPECT_THAT(not_written([&](const auto& folder) {
                  write_mesh(folder / "cage.obj", FileFormat::Obj, mesh);
                }),
                HasSubstr("crease 0 has sharpness nan"));
  }
}

}  // namespace
}  // namespace planish
