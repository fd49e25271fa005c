// Numbers that are not finite, given to each writer: a named error, and no file.
#include <gmock/gmock.h>

#include <array>
#include <filesystem>
#include <functional>
#include <limits>

#include "mesh/test_meshes.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/files/write_surface.h"
#include "support/expect_error.h"
#include "support/temporary_folder.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr std::array kSurfaceFormats{FileFormat::Obj, FileFormat::Ply, FileFormat::Off,
                                     FileFormat::Stl, FileFormat::Usda};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN(),
                 kInfinite = std::numeric_limits<double>::infinity();

SurfaceMesh mapped_quads() {
  SurfaceMesh surface;
  surface.level = 1;
  surface.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}};
  surface.normals.assign(6, {0, 0, 1});
  surface.face_vertices = {0, 1, 2, 3, 1, 4, 5, 2};
  surface.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}, {2, 1}};
  surface.face_uvs = surface.face_vertices;
  surface.colors.assign(6, glm::vec4(0.5f));
  return surface;
}

// What write(folder) is refused by; nothing is left.
std::string not_written(const std::function<void(const std::filesystem::path&)>& write) {
  const TemporaryFolder folder;
  const std::string message = message_of(ErrorCode::InvalidArgument, [&] { write(folder.path()); });
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  return message;
}

TEST(FiniteNumbers, OfSurfacesMadeAsTheyAreWritten) {
  for (const double wrong : {kNan, kInfinite, -kInfinite}) {
    for (const FileFormat format : kSurfaceFormats) {
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
  for (const double wrong : {kNan, kInfinite, -kInfinite}) {
    for (const GltfCompression compression :
         {GltfCompression::None, GltfCompression::Quantize, GltfCompression::Meshopt}) {
      for (const char* name : {"s.glb", "s.gltf"}) {
        for (const std::uint64_t buffer_bytes : {std::uint64_t{1} << 30, std::uint64_t{100}}) {
          const auto refused = [&](const auto& spoil) {
            SurfaceMesh surface = mapped_quads();
            GltfOptions options;
            options.name = name;
            options.compression = compression;
            options.position_error = 1e-4;
            options.buffer_bytes = buffer_bytes;
            spoil(surface, options);
            return not_written([&](const auto& folder) {
              write_gltf(folder / name, *blocks_of(surface, {}), options);
            });
          };
          EXPECT_THAT(refused([&](auto& s, auto&) { s.positions[4].y = wrong; }),
                      HasSubstr("vertex 4 has a coordinate that float32 cannot hold: ("));
          EXPECT_THAT(refused([&](auto& s, auto&) { s.normals[2].x = static_cast<float>(wrong); }),
                      HasSubstr("the normal of vertex 2 has length"));
          EXPECT_THAT(refused([&](auto& s, auto&) { s.colors[3].a = static_cast<float>(wrong); }),
                      HasSubstr("the colour of vertex 3 is not finite: ("));
          EXPECT_THAT(refused([&](auto& s, auto&) { s.uvs[5].x = wrong; }),
                      HasSubstr("texture coordinate 5 is not finite: ("));
          std::vector<float> values(6, 1.0f);
          values[1] = static_cast<float>(wrong);
          EXPECT_THAT(refused([&](auto&, auto& o) {
                        o.fields = {{"error", values}};
                      }),
                      HasSubstr("error of vertex 1 is not finite: "));
          EXPECT_THAT(refused([&](auto&, auto& o) {
                        GltfAttribute attribute;
                        attribute.name = "WEIGHT";
                        attribute.width = 1;
                        attribute.values = values;
                        o.attributes = {attribute};
                      }),
                      HasSubstr("WEIGHT of number 1 is not finite: "));
          std::vector<glm::dvec2> uvs(6);
          uvs[2].y = wrong;
          EXPECT_THAT(refused([&](auto&, auto& o) { o.further_uvs = {uvs}; }),
                      HasSubstr("further texture coordinate 2 is not finite: ("));
        }
      }
    }
  }
}

TEST(FiniteNumbers, OfCages) {
  for (const double wrong : {kNan, kInfinite}) {
    for (const FileFormat format :
         {FileFormat::Obj, FileFormat::Ply, FileFormat::Off, FileFormat::Usda}) {
      PolygonMesh mesh = cube();
      mesh.positions[3].z = wrong;
      EXPECT_THAT(
          not_written([&](const auto& folder) { write_mesh(folder / "cage.file", format, mesh); }),
          HasSubstr("cage.file: vertex 3 is not finite: ("));
    }
    PolygonMesh mesh = cube();
    mesh.creases = {{0, 1, std::numeric_limits<float>::quiet_NaN()}};
    EXPECT_THAT(not_written([&](const auto& folder) {
                  write_mesh(folder / "cage.obj", FileFormat::Obj, mesh);
                }),
                HasSubstr("crease 0 has sharpness nan"));
  }
}

}  // namespace
}  // namespace planish::test
