#include "distributed/rank_runs.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <thread>

#include "planish/files/mesh_file.h"
#include "support/files.h"

namespace planish::test {

namespace {

int world_rank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

}  // namespace

void on_ranks(int count, const std::function<void(const Ranks&)>& body) {
  int size = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  if (size < count) GTEST_SKIP() << "runs on " << size << " ranks, " << count << " are needed";
  MPI_Comm part = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, world_rank() < count ? 0 : MPI_UNDEFINED, world_rank(), &part);
  if (part != MPI_COMM_NULL) {
    body(Ranks(part));
    MPI_Comm_free(&part);
  }
  // A barrier that leaves the cores to those who work.
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(MPI_COMM_WORLD, &request);
  for (int done = 0; done == 0;) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done == 0) std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
}

const std::filesystem::path& shared_folder() {
  static const std::filesystem::path folder = [] {
    char name[256] = "";
    if (world_rank() == 0) {
      static const TemporaryFolder own;
      std::strncpy(name, own.path().c_str(), sizeof(name) - 1);
    }
    MPI_Bcast(name, sizeof(name), MPI_CHAR, 0, MPI_COMM_WORLD);
    return std::filesystem::path(name);
  }();
  return folder;
}

std::string shared_path(const std::string& name) { return (shared_folder() / name).string(); }

std::string shared_file(const std::string& name, const std::string& content) {
  const std::string path = shared_path(name);
  if (world_rank() == 0) {
    std::ofstream file(path, std::ios::binary);
    file.write(content.data(), static_cast<std::streamsize>(content.size()));
  }
  MPI_Barrier(MPI_COMM_WORLD);
  return path;
}

bool is_first_rank() { return world_rank() == 0; }

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Outcome outcome_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const AgreedError& error) {
    return {error.what(), static_cast<int>(error.code())};
  }
  return {};
}

PolygonMesh gathered(const Ranks& ranks, const MeshSlice& slice) {
  const auto all_of = [&]<class T>(const std::vector<T>& own) {
    RawVector<T> copies;
    for (int r = 0; r < ranks.size; ++r) copies.insert(copies.end(), own.begin(), own.end());
    const std::vector<std::int64_t> counts(ranks.size, static_cast<std::int64_t>(own.size()));
    return all_to_all<T>(ranks, copies, counts);
  };
  PolygonMesh mesh;
  const auto positions = all_of(slice.positions);
  mesh.positions.assign(positions.begin(), positions.end());
  std::vector<std::int64_t> sizes;
  for (std::int64_t f = 0; f < slice.face_count(); ++f)
    sizes.push_back(static_cast<std::int64_t>(slice.face(f).size()));
  for (const std::int64_t size : all_of(sizes))
    mesh.face_offsets.push_back(mesh.face_offsets.back() + static_cast<std::int32_t>(size));
  for (const std::int64_t v : all_of(slice.face_vertices))
    mesh.face_vertices.push_back(static_cast<std::int32_t>(v));
  for (const SliceCrease& c : all_of(slice.creases))
    mesh.creases.push_back(
        {static_cast<std::int32_t>(c.v0), static_cast<std::int32_t>(c.v1), c.sharpness});
  for (const SliceCorner& c : all_of(slice.corners))
    mesh.corners.push_back({static_cast<std::int32_t>(c.vertex), c.sharpness});
  const auto take = [](const auto& from, auto& to) { to.assign(from.begin(), from.end()); };
  take(all_of(slice.attributes.colors), mesh.colors);
  take(all_of(slice.attributes.uvs), mesh.uvs);
  take(all_of(slice.attributes.face_uvs), mesh.face_uvs);
  take(all_of(slice.attributes.face_groups), mesh.face_groups);
  mesh.groups = slice.attributes.groups;
  return mesh;
}

void expect_same_attributes(const PolygonMesh& a, const PolygonMesh& b, const std::string& what) {
  EXPECT_EQ(a.colors, b.colors) << what;
  EXPECT_EQ(a.uvs, b.uvs) << what;
  EXPECT_EQ(a.face_uvs, b.face_uvs) << what;
  EXPECT_EQ(a.face_groups, b.face_groups) << what;
  ASSERT_EQ(a.groups.size(), b.groups.size()) << what;
  for (std::size_t i = 0; i < a.groups.size(); ++i) {
    EXPECT_EQ(a.groups[i].name, b.groups[i].name) << what;
    EXPECT_EQ(a.groups[i].material, b.groups[i].material) << what;
  }
}

std::string written(const std::string& name, FileFormat format, const PolygonMesh& mesh) {
  const std::string path = shared_path(name);
  if (world_rank() == 0) write_mesh(path, format, mesh);
  MPI_Barrier(MPI_COMM_WORLD);
  return path;
}

std::string obj_of(const PolygonMesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  for (const glm::dvec3& p : mesh.positions)
    text << "v " << p.x << " " << p.y << " " << p.z << "\n";
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    text << "f";
    for (const std::int32_t v : mesh.face(f)) text << " " << v + 1;
    text << "\n";
  }
  for (const CreaseEdge& crease : mesh.creases)
    text << "t crease 2/1/0 " << crease.v0 << " " << crease.v1 << " " << crease.sharpness << "\n";
  for (const CornerVertex& corner : mesh.corners)
    text << "t corner 1/1/0 " << corner.vertex << " " << corner.sharpness << "\n";
  return text.str();
}

std::string ply_of(const PolygonMesh& mesh) {
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                     std::to_string(mesh.vertex_count()) +
                     "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                     std::to_string(mesh.face_count()) +
                     "\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](const auto& value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  for (const glm::dvec3& p : mesh.positions) put(p);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    put(static_cast<std::uint8_t>(mesh.face_size(f)));
    for (const std::int32_t v : mesh.face(f)) put(v);
  }
  return text;
}

std::string ply_with_attributes(const PolygonMesh& mesh) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex " +
      std::to_string(mesh.vertex_count()) +
      "\nproperty uchar red\nproperty uchar green\nproperty float s\nproperty double x"
      "\nproperty double y\nproperty double z\nproperty ushort blue\nproperty uchar alpha"
      "\nproperty float t\nproperty float nx\nelement face " +
      std::to_string(mesh.face_count()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](const auto& value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    put(static_cast<std::uint8_t>(v * 37));
    put(static_cast<std::uint8_t>(v * 11));
    put(0.125f * static_cast<float>(v % 19));
    put(mesh.positions[v]);
    put(static_cast<std::uint16_t>(v * 1001));
    put(static_cast<std::uint8_t>(255 - v % 3));
    put(0.1f * static_cast<float>(v % 23));
    put(std::numeric_limits<float>::quiet_NaN());
  }
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    put(static_cast<std::uint8_t>(mesh.face_size(f)));
    for (const std::int32_t v : mesh.face(f)) put(v);
  }
  return text;
}

PolygonMesh mixed_torus(int around, int across) {
  PolygonMesh mesh;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  const double turn = 2 * std::numbers::pi;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = turn * i / around, v = turn * j / across;
      const double edge = turn * 0.4 / std::max(around, across);
      const double ring = 1 + 0.4 * std::cos(v);
      mesh.positions.push_back({ring * std::cos(u) + edge * noise(random),
                                ring * std::sin(u) + edge * noise(random),
                                0.4 * std::sin(v) + edge * noise(random)});
    }
  const auto id = [&](int i, int j) { return i % around * across + j % across; };
  const auto add = [&](std::vector<std::int32_t> face) { mesh.add_face(face); };
  // Cells of 4 x 2 hold a hexagon, two triangles and five quads.
  for (int i = 0; i < around; i += 4)
    for (int j = 0; j < across; j += 2) {
      add({id(i, j), id(i + 1, j), id(i + 2, j), id(i + 2, j + 1), id(i + 1, j + 1), id(i, j + 1)});
      add({id(i + 2, j), id(i + 3, j), id(i + 3, j + 1), id(i + 2, j + 1)});
      add({id(i + 3, j), id(i + 4, j), id(i + 4, j + 1)});
      add({id(i + 3, j), id(i + 4, j + 1), id(i + 3, j + 1)});
      for (int k = 0; k < 4; ++k)
        add({id(i + k, j + 1), id(i + k + 1, j + 1), id(i + k + 1, j + 2), id(i + k, j + 2)});
    }
  return mesh;
}

}  // namespace planish::test
