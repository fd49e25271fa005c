// Colours, texture coordinates and groups over ranks, up to the cage; part_tiles_test has the rest.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numeric>
#include <sstream>

#include "distributed/rank_runs.h"
#include "planish/distributed/write_cage.h"
#include "planish/files/mesh_file.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

void expect_attributes_as_on_one(const std::string& path) {
  const PolygonMesh whole = read_mesh(path).mesh;
  for (const int count : kRankCounts)
    on_ranks(count, [&](const Ranks& ranks) {
      const PolygonMesh mesh = gathered(ranks, read_slices(ranks, path));
      const std::string what = path + " on " + std::to_string(count);
      EXPECT_EQ(mesh.face_vertices, whole.face_vertices) << what;
      expect_same_attributes(mesh, whole, what);
    });
}

// A strip of quads, each line of vertices followed by its face, counted backwards.
std::string strip(const std::function<std::string(int)>& before_face, bool some_colors = true) {
  std::ostringstream text;
  for (int i = 0; i < 60; ++i) {
    text << "v " << i << " 0 0" << (some_colors && i % 7 == 3 ? " 0.5 0.25 1" : "") << "\n";
    text << "v " << i << " 1 0\nvt " << i << " 0.5\n"
         << "vt " << i << " 0.75\n";
    if (i == 0) continue;
    text << before_face(i);
    if (i % 11 == 0) {
      text << "f -4 -2 -1 -3\n";
    } else {
      text << "f -4/-4 -2/-2 -1/" << 2 * i + 2 << " -3" << (i % 5 == 0 ? "" : "/-3") << "\n";
    }
  }
  return text.str();
}

TEST(Attributes, OfObjAreReadAsOnOneRank) {
  expect_attributes_as_on_one(written("all.obj", FileFormat::Obj, laden_mesh(3)));
  expect_attributes_as_on_one(shared_file("strip.obj", strip([](int i) {
                                            // Names hold on over ranks; an object ends a group, not
                                            // a material.
                                            if (i == 20) return std::string("usemtl red\n");
                                            if (i == 21) return std::string("g left part\n");
                                            if (i == 35) return std::string("o second\n");
                                            if (i == 50)
                                              return std::string(
                                                  "g left part\no first\ng left part\n");
                                            if (i == 55) return std::string("o\nusemtl\n");
                                            return std::string();
                                          })));
  // None of the coordinates is named; names without faces.
  expect_attributes_as_on_one(shared_file(
      "unnamed.obj", "vt 1 1\n" + obj_of(mixed_torus(8, 4)) + "g behind\nusemtl all\n"));
  expect_attributes_as_on_one(
      shared_file("object.obj", "o whole\n" + strip([](int) { return std::string(); }, false)));
}

// Ranges of more than one part each.
TEST(Attributes, OfALongObjAreReadAsOnOneRank) {
  PolygonMesh mesh = mixed_torus(200, 120);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) mesh.colors.emplace_back(v % 2, 1, 1, 1);
  mesh.face_uvs.assign(mesh.face_vertices.rbegin(), mesh.face_vertices.rend());
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x, p.y);
  mesh.groups = {{"a", ""}, {"", "b"}, {"", ""}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) mesh.face_groups.push_back(f / 100 % 3);
  const std::string path = written("long.obj", FileFormat::Obj, mesh);
  EXPECT_GT(std::filesystem::file_size(path), std::size_t{3} << 20);
  expect_attributes_as_on_one(path);
}

TEST(Attributes, OfPlyAreReadAsOnOneRank) {
  expect_attributes_as_on_one(shared_file("all.ply", ply_with_attributes(mixed_torus(16, 8))));
  // Text is read by the first rank.
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
          "property float z\nproperty float u\nproperty float v\nproperty float red\n"
          "property float green\nproperty float blue\nelement face 2\n"
          "property list uchar int vertex_index\nend_header\n";
  for (const char* corner : {"0 0", "1 0", "1 1", "0 1"})
    text << corner << " 0 " << corner << " 0.5 2 -1\n";
  text << "3 0 1 2\n3 0 2 3\n";
  expect_attributes_as_on_one(shared_file("text.ply", text.str()));
}

TEST(Attributes, OfAMeshAreScatteredWhole) {
  for (const bool has_names : {false, true}) {
    PolygonMesh mesh = laden_mesh(4);
    if (!has_names) mesh.groups = {}, mesh.face_groups = {};
    if (has_names) mesh.groups.push_back({std::string("a\0b", 3), ""});
    for (const int count : kRankCounts)
      on_ranks(count, [&](const Ranks& ranks) {
        const PolygonMesh own = ranks.rank == 0 ? mesh : PolygonMesh();
        expect_same_attributes(gathered(ranks, scatter_mesh(ranks, own)), mesh,
                               std::to_string(count));
      });
  }
}

TEST(Attributes, FaultsAreFoundOnWhateverRank) {
  const auto expect_refused = [](const std::string& path, const std::string& part) {
    for (const int count : {1, 3, 8})
      on_ranks(count, [&](const Ranks& ranks) {
        const Outcome outcome = outcome_of([&] { (void)read_slices(ranks, path); });
        EXPECT_EQ(outcome.code, static_cast<int>(ErrorCode::UnreadableInput)) << count;
        EXPECT_NE(outcome.message.find(part), std::string::npos) << outcome.message;
      });
  };
  const auto faulty = [](const std::string& line) {
    return shared_file("uv_fault.obj",
                       strip([&](int i) { return i == 30 ? line : std::string(); }));
  };
  expect_refused(faulty("f 1/1 2/121 3\n"), "face names texture coordinate 121 of 120");
  expect_refused(faulty("f 1/1 2/-90 3\n"), "face names texture coordinate -90, but only ");
  expect_refused(faulty("vt x\n"), "no finite number");
  std::string ply = ply_with_attributes(mixed_torus(8, 4));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::size_t body = ply.find("end_header\n") + 11;
  constexpr std::size_t kStride = 41, kS = 2;
  ply.replace(body + 20 * kStride + kS, 4, reinterpret_cast<const char*>(&nan), 4);
  expect_refused(shared_file("uv_fault.ply", ply), "vertex 20 of 32: s is nan");
}

TEST(Attributes, ColorsOutsideTheirRangeAreSpokenOf) {
  const std::string path = shared_file("bright.obj",
                                       "v 0 0 0 2 0 0\nv 1 0 0 -1 0 0\nv 0 1 0\n"
                                       "f 1 2 3\n");
  on_ranks(2, [&](const Ranks& ranks) {
    const MeshSlice slice = read_slices(ranks, path);
    ASSERT_EQ(slice.warnings.size(), 1u);
    EXPECT_EQ(slice.warnings[0].message, read_mesh(path).warnings[0].message);
  });
}

// The cage has the colours, as planish fit writes them.
TEST(Attributes, ColorsOfTheCageHaveTheBytesOfOneMachine) {
  for (const bool many_corners : {false, true}) {
    PolygonMesh mesh = mixed_torus(16, 8);
    if (many_corners) {
      mesh = {};
      for (int i = 0; i < 300; ++i)
        mesh.positions.emplace_back(std::cos(i / 48.0), std::sin(i / 48.0), 0);
      std::vector<std::int32_t> corners(300);
      std::iota(corners.begin(), corners.end(), 0);
      mesh.add_face(corners);
    }
    for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
      mesh.colors.emplace_back(0.01f * static_cast<float>(v % 100), 0.5f, 0.0f, 0.75f);
    const std::string expected = content_of(written("one.ply", FileFormat::Ply, mesh));
    for (const int count : kRankCounts) {
      on_ranks(count, [&](const Ranks& ranks) {
        const MeshSlice slice = scatter_mesh(ranks, mesh);
        StagedFile file(ranks, shared_path("cage.ply"));
        write_cage(ranks, slice.vertices, slice.face_total(), slice.positions,
                   encode_cage_faces(ranks, slice), {}, file);
        file.commit();
      });
      if (is_first_rank()) {
        EXPECT_TRUE(content_of(shared_path("cage.ply")) == expected) << count;
      }
    }
  }
}

}  // namespace
}  // namespace planish::test
