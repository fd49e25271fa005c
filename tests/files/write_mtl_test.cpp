#include "planish/files/obj/material_library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiny_obj_loader.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "mesh/test_meshes.h"
#include "planish/core/output_file.h"
#include "planish/files/formats.h"
#include "planish/files/mesh_file.h"
#include "planish/files/obj/material_library.h"
#include "planish/files/read_file.h"
#include "support/temporary_folder.h"

namespace planish {
namespace {

PolygonMesh painted_cube() {
  PolygonMesh mesh = test::cube();
  mesh.groups = {{"lid", "red_wood"}, {"", "paint"}, {"walls", "tin"}, {"floor", "red_wood"}};
  mesh.face_groups = {0, 1, 2, 2, 3, 2};
  return mesh;
}

std::string text_of_file(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(WriteMtl, AnotherReaderFindsNamesAndColours) {
  const test::TemporaryFolder folder;
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, painted_cube());
  tinyobj::ObjReader reader;
  tinyobj::ObjReaderConfig config;
  config.triangulate = false;
  ASSERT_TRUE(reader.ParseFromFile((folder.path() / "a.obj").string(), config));
  EXPECT_TRUE(reader.Warning().empty()) << reader.Warning();
  const std::vector<tinyobj::material_t>& materials = reader.GetMaterials();
  ASSERT_EQ(materials.size(), 3u);
  EXPECT_EQ(materials[0].name, "red_wood");
  EXPECT_EQ(materials[2].name, "tin");
  EXPECT_NE(std::vector<double>(materials[0].diffuse, materials[0].diffuse + 3),
            std::vector<double>(materials[1].diffuse, materials[1].diffuse + 3));
  for (const tinyobj::material_t& material : materials)
    for (const double part : material.diffuse) {
      EXPECT_GE(part, 0.3);
      EXPECT_LE(part, 0.801);
    }
}

TEST(WriteMtl, IsWrittenOnlyWhereThereAreMaterials) {
  const test::TemporaryFolder folder;
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, test::cube());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "a.mtl"));
  EXPECT_EQ(text_of_file(folder.path() / "a.obj").find("mtllib"), std::string::npos);
  write_mesh(folder.path() / "a.ply", FileFormat::Ply, painted_cube());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "a.mtl"));
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, painted_cube());
  EXPECT_EQ(text_of_file(folder.path() / "a.mtl"),
            "newmtl red_wood\nKd 0.8 0.35 0.35\nnewmtl paint\nKd 0.35 0.48 0.8\nnewmtl tin\n"
            "Kd 0.61 0.8 0.35\n");
  EXPECT_TRUE(text_of_file(folder.path() / "a.obj").starts_with("mtllib a.mtl\n"));
}

TEST(WriteMtl, NamesAreThoseOfTheFaces) {
  const test::TemporaryFolder folder;
  PolygonMesh mesh = painted_cube();
  mesh.groups[0].material = "a #b\\";
  mesh.groups[3].material = "a _b_";
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, mesh);
  const std::string text = text_of_file(folder.path() / "a.mtl");
  EXPECT_NE(text.find("newmtl a _b_\n"), std::string::npos);
  EXPECT_EQ(text.find("newmtl a _b_\n"), text.rfind("newmtl a _b_\n"));
  EXPECT_NE(text_of_file(folder.path() / "a.obj").find("usemtl a _b_\n"), std::string::npos);
}

// Line ends of Unicode, which Python's readers split at, and overrides of the direction.
// The OBJ's own name, too: its MTL gets one that a line can hold.
TEST(WriteMtl, IsFoundWhateverTheObjIsCalled) {
  for (const char* name : {"a\nb.obj", "a #b.obj", "\ta.obj", "a b.obj", "plain.obj"}) {
    const test::TemporaryFolder folder;
    const std::filesystem::path obj = folder.path() / name;
    write_mesh(obj, FileFormat::Obj, painted_cube());
    const MaterialLibrary library(obj);
    EXPECT_TRUE(library.warnings().empty()) << library.warnings()[0].message;
    EXPECT_EQ(library.names(), (std::vector<std::string>{"paint", "red_wood", "tin"})) << name;
    EXPECT_TRUE(std::filesystem::exists(companion_of(obj, FileFormat::Obj)));
  }
}

// As the specification has it, and as programs write it.
TEST(MaterialLibraries, ALineNamesOneWithBlanksOrSeveral) {
  const test::TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) {
    OutputFile file(folder.path() / name);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
  };
  write("a.mtl", "newmtl a\nKd 1 0 0\n");
  write("b.mtl", "newmtl b\nKd 0 1 0\n");
  const auto read = [&](const std::string& line) {
    write("m.obj", line + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    return MaterialLibrary(folder.path() / "m.obj");
  };
  EXPECT_EQ(read("mtllib a.mtl b.mtl").names(), (std::vector<std::string>{"a", "b"}));
  EXPECT_TRUE(read("mtllib a.mtl b.mtl").warnings().empty());
  const MaterialLibrary one = read("mtllib a.mtl c.mtl");
  EXPECT_EQ(one.names(), (std::vector<std::string>{"a"}));
  ASSERT_EQ(one.warnings().size(), 1U);
  EXPECT_THAT(one.warnings()[0].message, testing::HasSubstr("c.mtl"));
  EXPECT_THAT(read("mtllib d.mtl e.mtl").warnings()[0].message, testing::HasSubstr("d.mtl e.mtl"));
  write("a.mtl b.mtl", "newmtl whole\nKd 0 0 1\n");
  EXPECT_EQ(read("mtllib a.mtl b.mtl").names(), (std::vector<std::string>{"whole"}));
}

TEST(WriteMtl, NamesEndNoLine) {
  const test::TemporaryFolder folder;
  PolygonMesh mesh = painted_cube();
  mesh.groups[0] = {"li\u2028d", "re\u2029d\u0085"};
  mesh.groups[1] = {"\u202etnorf", "pa\u2067int K\u00e4se"};
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, mesh);
  const std::string obj = text_of_file(folder.path() / "a.obj");
  for (const char* line :
       {"\ng li_d\n", "\nusemtl re_d_\n", "\ng _tnorf\n", "\nusemtl pa_int K\u00e4se\n"})
    EXPECT_NE(obj.find(line), std::string::npos) << line;
  const std::string mtl = text_of_file(folder.path() / "a.mtl");
  EXPECT_NE(mtl.find("newmtl re_d_\n"), std::string::npos);
  EXPECT_NE(mtl.find("newmtl pa_int K\u00e4se\n"), std::string::npos);
}

}  // namespace
}  // namespace planish
