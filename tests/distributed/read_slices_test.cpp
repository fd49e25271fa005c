#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include "distributed/rank_runs.h"
#include "planish/distributed/read_slices.h"
#include "planish/distributed/write_cage.h"
#include "planish/files/mesh_file.h"
#include "support/calls.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

constexpr int kUnreadable = static_cast<int>(ErrorCode::UnreadableInput);

void expect_same(const PolygonMesh& a, const PolygonMesh& b, const std::string& what) {
  EXPECT_EQ(a.positions, b.positions) << what;
  EXPECT_EQ(a.face_offsets, b.face_offsets) << what;
  EXPECT_EQ(a.face_vertices, b.face_vertices) << what;
  ASSERT_EQ(a.creases.size(), b.creases.size()) << what;
  for (std::size_t i = 0; i < a.creases.size(); ++i) {
    EXPECT_EQ(a.creases[i].v0, b.creases[i].v0) << what;
    EXPECT_EQ(a.creases[i].v1, b.creases[i].v1) << what;
    EXPECT_EQ(a.creases[i].sharpness, b.creases[i].sharpness) << what;
  }
  ASSERT_EQ(a.corners.size(), b.corners.size()) << what;
  for (std::size_t i = 0; i < a.corners.size(); ++i)
    EXPECT_EQ(a.corners[i].vertex, b.corners[i].vertex) << what;
  expect_same_attributes(a, b, what);
}

TEST(ReadSlices, AFileThatBecomesShorterIsRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.obj";
  std::ofstream(path) << std::string(1000, '#');
  const RangeFile file(path.string());
  std::filesystem::resize_file(path, 400);
  EXPECT_EQ(file.read(100, 400).size(), 300u);
  EXPECT_EQ(message_of(ErrorCode::UnreadableInput, [&] { (void)file.read(300, 900); }),
            path.string() + ": became shorter while it was read, at byte 400");
}

// What ranks read is what one machine reads.
void expect_read_as_on_one(const std::string& path) {
  const PolygonMesh whole = read_mesh(path).mesh;
  for (const int count : kRankCounts)
    on_ranks(count, [&](const Ranks& ranks) {
      expect_same(gathered(ranks, read_slices(ranks, path)), whole,
                  path + " on " + std::to_string(count));
    });
}

TEST(ReadSlices, PlyOfAnyFacesIsReadAsOnOneRank) {
  expect_read_as_on_one(shared_file("mixed.ply", ply_of(mixed_torus(16, 8))));
  expect_read_as_on_one(shared_file("triangles.ply", ply_of(icosphere(2))));
  // Ranges shorter than one record: one face of 200 corners, and fewer faces than ranks.
  expect_read_as_on_one(shared_file("polygon.ply", ply_of(single_polygon(200))));
  expect_read_as_on_one(shared_file("prism.ply", ply_of(prism(100))));
  expect_read_as_on_one(shared_file("empty.ply", ply_of({})));
}

TEST(ReadSlices, PlyWithOtherPropertiesAndCountsIsReadAsOnOneRank) {
  const PolygonMesh mesh = mixed_torus(8, 4);
  std::string text =
      "ply\r\nformat binary_little_endian 1.0\r\nelement vertex " +
      std::to_string(mesh.vertex_count()) +
      "\r\nproperty uchar red\r\nproperty float z\r\nproperty double y\r\nproperty short x"
      "\r\nelement face " +
      std::to_string(mesh.face_count()) +
      "\r\nproperty float quality\r\nproperty list int uint vertex_index\r\nproperty uchar flag"
      "\r\nend_header\r\n";
  const auto put = [&](const auto& value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  for (const glm::dvec3& p : mesh.positions) {
    put(std::uint8_t{7});
    put(static_cast<float>(p.z));
    put(p.y);
    put(static_cast<std::int16_t>(1000 * p.x));
  }
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    put(0.5f);
    put(mesh.face_size(f));
    for (const std::int32_t v : mesh.face(f)) put(v);
    put(std::uint8_t{1});
  }
  expect_read_as_on_one(shared_file("other.ply", text));
}

// Cut at every byte, and with every byte flipped: unreadable, or the mesh that one machine reads.
TEST(DamagedSlices, PlyIsRefusedOrReadAsOnOneRank) {
  const std::string sound = ply_of(prism(3));
  std::vector<std::string> damaged;
  for (std::size_t cut = 0; cut < sound.size(); ++cut) damaged.push_back(sound.substr(0, cut));
  for (std::size_t i = 0; i < sound.size(); ++i) {
    damaged.push_back(sound);
    damaged.back()[i] = static_cast<char>(damaged.back()[i] ^ (1 << i % 8));
  }
  const auto name_of_file = [](std::size_t d) { return "damaged" + std::to_string(d) + ".ply"; };
  if (is_first_rank())
    for (std::size_t d = 0; d < damaged.size(); ++d)
      std::ofstream(shared_path(name_of_file(d)), std::ios::binary) << damaged[d];
  (void)shared_file("all_are_there", "");
  int refused = 0, read = 0;
  on_ranks(3, [&](const Ranks& ranks) {
    for (std::size_t d = 0; d < damaged.size(); ++d) {
      const std::string path = shared_path(name_of_file(d));
      PolygonMesh mesh;
      const Outcome outcome = outcome_of([&] { mesh = gathered(ranks, read_slices(ranks, path)); });
      if (outcome.code >= 0) {
        ++refused;
        EXPECT_EQ(outcome.code, kUnreadable) << d << ": " << outcome.message;
        continue;
      }
      ++read;
      if (ranks.rank == 0) expect_same(mesh, read_mesh(path).mesh, std::to_string(d));
    }
  });
  if (is_first_rank()) {
    EXPECT_GT(refused, static_cast<int>(sound.size()));
    EXPECT_GT(read, 0);
  }
}

// What fuzzers found: the same mesh, or the same refusal.
TEST(DamagedSlices, TheCorpusIsRefusedOrReadAsOnOneRank) {
  for (const std::string format : {"obj", "ply", "cage"}) {
    std::vector<std::string> paths;
    for (const auto& entry : std::filesystem::directory_iterator(PLANISH_FUZZ_CORPUS "/" + format))
      paths.push_back(entry.path());
    std::ranges::sort(paths);
    ASSERT_FALSE(paths.empty());
    on_ranks(3, [&](const Ranks& ranks) {
      for (const std::string& path : paths) {
        PolygonMesh mesh;
        const Outcome outcome =
            outcome_of([&] { mesh = gathered(ranks, read_slices(ranks, path)); });
        if (ranks.rank != 0) continue;
        PolygonMesh whole;
        Outcome expected;
        try {
          whole = read_mesh(path, {.is_strict = true}).mesh;
        } catch (const Error& error) {
          expected = {error.what(), static_cast<int>(error.code())};
        }
        // Ranks carry no further properties of vertices, and do not refuse one that is no number.
        if (path.ends_with("/invisible_property.ply")) {
          EXPECT_NE(expected.message.find("vertex 1 of 3: re\\x1b is nan"), std::string::npos);
          EXPECT_EQ(outcome.message, "no error");
          EXPECT_EQ(mesh.vertex_count(), 3);
          continue;
        }
        EXPECT_EQ(outcome.code, expected.code) << path;
        EXPECT_EQ(outcome.message, expected.message) << path;
        expect_same(mesh, whole, path);
      }
    });
  }
}

TEST(ReadSlices, ObjOfAnyFormIsReadAsOnOneRank) {
  PolygonMesh tagged = mixed_torus(8, 4);
  tagged.creases = {{0, 4, 10.0f}, {4, 8, 2.5f}, {0, 4, 3.0f}};
  tagged.corners = {{5, 10.0f}, {0, 1.0f}};
  const std::string plain = obj_of(tagged);
  expect_read_as_on_one(shared_file("plain.obj", plain));
  std::string other;
  for (const char c : plain) other += c == '\n' ? "\r\n" : std::string(1, c);
  expect_read_as_on_one(shared_file("crlf.obj", other));
  expect_read_as_on_one(shared_file("open_end.obj", plain.substr(0, plain.size() - 1)));
  // Every blank a continued line.
  other.clear();
  for (const char c : plain) other += c == ' ' ? " \\\n" : std::string(1, c);
  expect_read_as_on_one(shared_file("continued.obj", other));
  other.clear();
  for (const char c : plain) other += c == '\n' ? '\r' : c;
  expect_read_as_on_one(shared_file("cr.obj", other));
  expect_read_as_on_one(shared_file("comments.obj", "# a path\\\n" + plain + "# end \\"));
}

TEST(ReadSlices, ObjThatCountsBackwardsIsReadAsOnOneRank) {
  std::string text;
  for (int i = 0; i < 40; ++i) {
    text += "v " + std::to_string(i) + " 0 0\nv " + std::to_string(i) + " 1 0\n";
    if (i > 0) text += "f -4 -2 -1 -3\nf 1 2 " + std::to_string(2 * i + 2) + "\n";
  }
  expect_read_as_on_one(shared_file("backwards.obj", text));
}

TEST(ReadSlices, ObjFaultsAreFoundOnWhateverRank) {
  const std::string plain = obj_of(mixed_torus(16, 8));
  const auto refusal = [&](const std::string& text) {
    const std::string path = shared_file("fault.obj", text);
    // What a reader of the whole file says, with the line.
    const std::string whole = message_of(ErrorCode::UnreadableInput, [&] {
      (void)read_mesh(path, MeshReadOptions{.is_strict = true});
    });
    for (const int count : {1, 3, 8})
      on_ranks(count, [&](const Ranks& ranks) {
        const Outcome outcome = outcome_of([&] { (void)read_slices(ranks, path); });
        EXPECT_EQ(outcome.code, kUnreadable) << count << ": " << outcome.message;
        EXPECT_EQ(outcome.message, whole) << count;
      });
    return whole;
  };
  const auto expect_in = [&](const std::string& part, const std::string& message) {
    if (is_first_rank()) {
      EXPECT_NE(message.find(part), std::string::npos) << message;
    }
  };
  const std::size_t middle = plain.find('\n', plain.size() / 2) + 1;
  const auto with = [&](const std::string& line) {
    return plain.substr(0, middle) + line + plain.substr(middle);
  };
  expect_in("names vertex 4000 of 128", refusal(with("f 1 2 4000\n")));
  expect_in("face names vertex -400, but only ", refusal(with("f 1 2 -400\n")));
  expect_in("no v/vt/vn", refusal(with("f 1 2 x\n")));
  expect_in("no finite number", refusal(with("v 1 2 nan\n")));
  expect_in("names vertex 128 of 128", refusal(with("t crease 2/1/0 0 128 10\n")));
  expect_in("names face 999 of", refusal(with("t hole 1/0/0 999\n")));
}

// A mark before the text is no word of its first line.
TEST(ReadSlices, TextBehindAMarkIsReadAsOnOneRank) {
  const std::string mark = "\xEF\xBB\xBF";
  expect_read_as_on_one(shared_file("mark.obj", mark + obj_of(mixed_torus(8, 4))));
  expect_read_as_on_one(shared_file("mark.ply", mark + ply_of(mixed_torus(8, 4))));
  const std::string path = shared_file("wide.obj", std::string("v\0 \0001\0", 6));
  on_ranks(3, [&](const Ranks& ranks) {
    const Outcome outcome = outcome_of([&] { (void)read_slices(ranks, path); });
    EXPECT_EQ(outcome.code, kUnreadable);
    EXPECT_NE(outcome.message.find("is text of UTF-16; save it as UTF-8"), std::string::npos);
  });
}

TEST(RangeFile, AFileThatIsCutAfterOpeningIsNamed) {
  if (!is_first_rank()) return;
  const std::string path = shared_path("shrinking");
  std::ofstream(path, std::ios::binary) << std::string(1000, 'x');
  const RangeFile file(path);
  EXPECT_EQ(file.read(990, 2000).size(), 10u);
  std::filesystem::resize_file(path, 600);
  EXPECT_EQ(message_of(ErrorCode::UnreadableInput, [&] { (void)file.read(500, 1000); }),
            path + ": became shorter while it was read, at byte 600");
  EXPECT_EQ(file.read(500, 600).size(), 100u);
}

TEST(ReadSlices, OtherFormatsAreReadByTheFirstRank) {
  const std::string path = shared_path("cube.off");
  if (is_first_rank()) write_mesh(path, FileFormat::Off, cube());
  MPI_Barrier(MPI_COMM_WORLD);
  expect_read_as_on_one(path);
}

TEST(ReadSlices, WhatIsNoMeshIsRefusedByName) {
  on_ranks(3, [](const Ranks& ranks) {
    const auto refusal = [&](const std::string& name) {
      return outcome_of([&] { (void)read_slices(ranks, name); });
    };
    EXPECT_EQ(refusal("points.xyz").code, static_cast<int>(ErrorCode::InvalidArgument));
    EXPECT_EQ(refusal("mesh.doc").code, static_cast<int>(ErrorCode::InvalidArgument));
    EXPECT_EQ(refusal("/nowhere/at/all.ply").code, kUnreadable);
    EXPECT_EQ(refusal("/nowhere/at/all.obj").code, kUnreadable);
    EXPECT_EQ(refusal("/nowhere/at/all.off").code, kUnreadable);
  });
}

TEST(RecordChains, TheRightBeginningIsToldNotGuessed) {
  // Records of 1 to 3 bytes, whose first says how many follow: any byte could be a beginning.
  const std::vector<int> bytes{2, 1, 0, 0, 1, 2, 1, 1, 0, 2, 0, 0};
  const auto next = [&](std::int64_t place) {
    if (place >= static_cast<std::int64_t>(bytes.size())) return std::int64_t{-1};
    const std::int64_t behind = place + 1 + bytes[place];
    return behind <= static_cast<std::int64_t>(bytes.size()) ? behind : -1;
  };
  for (std::int64_t range = 1; range <= 9; ++range) {
    const RecordChains chains(range, std::min<std::int64_t>(3, range), next);
    for (std::int64_t start = 0; start < 3; ++start) {
      std::int64_t place = start;
      while (place >= 0 && place < range) place = next(place);
      EXPECT_EQ(chains.overhang(start), place < 0 ? -1 : place - range) << range << " " << start;
    }
  }
}

// Colours, texture coordinates and groups over ranks, up to the cage; part_tiles_test has the rest.

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
