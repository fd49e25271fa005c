#include <gtest/gtest.h>

#include <map>
#include <span>
#include <string>

#include "make_scenes/scene_list.h"
#include "planish/core/error.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/check.h"

namespace planish::shapes {
namespace {

MeshFile read(const BadFile& bad) {
  const FileFormat format = *format_of(bad.file);
  const auto bytes = std::as_bytes(std::span(bad.bytes));
  return read_mesh(bytes, bad.file, format);
}

TEST(BadFiles, MalformedOnesAreRefusedByTheReaderNamingTheFile) {
  for (const BadFile& bad : bad_files()) {
    if (bad.exit_code != 3) continue;
    try {
      (void)read(bad);
      ADD_FAILURE() << bad.file << " was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::UnreadableInput) << bad.file;
      EXPECT_NE(std::string(error.what()).find(bad.file), std::string::npos) << error.what();
    }
  }
}

TEST(BadFiles, UnusableOnesAreReadAndHaveTheProblemTheyAreNamedFor) {
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
    if (bad.exit_code != 4) continue;
    const auto problems = check(read(bad).mesh);
    bool is_found = false;
    for (const MeshProblem& problem : problems) is_found |= problem.kind == kinds.at(bad.file);
    EXPECT_TRUE(is_found) << bad.file << " has " << problems.size() << " problems";
  }
}

TEST(BadFiles, TheLegalOnePasses) {
  for (const BadFile& bad : bad_files()) {
    if (bad.exit_code == 0) {
      EXPECT_TRUE(check(read(bad).mesh).empty()) << bad.file;
    }
  }
}

}  // namespace
}  // namespace planish::shapes
