#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "make_scenes/models.h"
#include "make_scenes/scene_list.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/check.h"
#include "planish/mesh/statistics.h"

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

TEST(CommittedFiles, AreWhatTheGeneratorMakes) {
  for (const Scene& scene : scenes()) expect_same(kFolder / scene.file, scene_text(scene));
  for (const BadFile& bad : bad_files()) expect_same(kFolder / "bad" / bad.file, bad.bytes);
}

TEST(CommittedFiles, AreAllOnTheList) {
  std::set<std::string> made;
  for (const Scene& scene : scenes()) made.insert(scene.file);
  for (const BadFile& bad : bad_files()) made.insert("bad/" + bad.file);
  made.insert(kScanFile);
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
  EXPECT_NE(bytes_of(kFolder / "README.md").find("`" + std::string(kScanFile) + "`"),
            std::string::npos);
}

TEST(CommittedFiles, StandInTheReadme) {
  const std::string readme = bytes_of(kFolder / "README.md");
  for (const Scene& scene : scenes()) {
    EXPECT_NE(readme.find("`" + scene.file + "`"), std::string::npos) << scene.file;
  }
  for (const BadFile& bad : bad_files())
    EXPECT_NE(readme.find("`" + bad.file + "`"), std::string::npos) << bad.file;
}

}  // namespace
}  // namespace planish::shapes
