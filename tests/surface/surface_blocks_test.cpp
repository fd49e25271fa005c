#include "planish/surface/surface_blocks.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <opensubdiv/far/primvarRefiner.h>

#include <glm/geometric.hpp>
#include <set>

#include "conformance/catalogue.h"
#include "planish/backend/cpu_backend.h"
#include "planish/files/mesh_file.h"
#include "planish/patches/split_rows.h"
#include "planish/surface/doo_sabin_surface.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// Everything that can ride on a mesh, and holes.
PolygonMesh laden_mesh(std::uint32_t seed) {
  PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(seed), 0.1, seed);
  for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c) {
    // Some vertices are seams.
    const std::int32_t v = mesh.face_vertices[c];
    mesh.face_uvs.push_back(v % 5 == 0 ? static_cast<std::int32_t>(mesh.positions.size() + c) : v);
  }
  mesh.uvs.resize(mesh.positions.size() + mesh.face_vertices.size());
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i) {
    mesh.uvs[i] = {0.25 * static_cast<double>(i % 7), 0.125 * static_cast<double>(i % 11)};
  }
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    mesh.colors.emplace_back(0.1f * static_cast<float>(v % 10), 0.5f, 0.25f, 1.0f);
  }
  mesh.groups = {{"a", "red"}, {"b", "blue"}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    mesh.face_groups.push_back(f % 2);
    if (f % 6 == 1) mesh.hole_faces.push_back(f);
  }
  return mesh;
}

void expect_pieces_equal(const SurfaceBlocks& blocks, const SurfaceMesh& surface,
                         std::int64_t size) {
  const SurfaceInfo& info = blocks.info();
  ASSERT_EQ(info.row_count, static_cast<std::int64_t>(surface.positions.size()));
  ASSERT_EQ(info.face_count, surface.face_count());
  for (const RowRange range : ranges_of(info.row_count, size)) {
    std::vector<glm::dvec3> positions(static_cast<std::size_t>(range.count));
    std::vector<glm::vec3> normals(positions.size()), stored(positions.size());
    std::vector<glm::vec4> colors(positions.size());
    RowTarget target;
    target.positions = positions;
    target.normals = normals;
    target.stored = stored;
    target.colors = colors;
    (void)blocks.rows(range, target);
    for (std::int64_t i = 0; i < range.count; ++i) {
      ASSERT_EQ(positions[i], surface.positions[range.first + i]);
      ASSERT_EQ(normals[i], surface.normals[range.first + i]);
      ASSERT_EQ(stored[i], glm::vec3(positions[i]));
      ASSERT_EQ(colors[i], surface.colors[range.first + i]);
    }
  }
  for (const RowRange range : ranges_of(info.face_count, size)) {
    const std::int64_t first = info.first_corner(range.first);
    const auto count =
        static_cast<std::size_t>(info.first_corner(range.first + range.count) - first);
    std::vector<std::int32_t> rows(count), uvs(count), groups(range.count), ancestors(range.count);
    std::vector<glm::dvec3> positions(count);
    std::vector<glm::vec3> normals(count);
    blocks.face_vertices(range, rows);
    blocks.face_uvs(range, uvs);
    blocks.face_groups(range, groups);
    blocks.ancestors(range, ancestors);
    blocks.corners(range, positions, normals);
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(rows[i], surface.face_vertices[first + i]);
      ASSERT_EQ(uvs[i], surface.face_uvs[first + i]);
      // Seen from another corner the same sample is summed in another order.
      ASSERT_LT(glm::length(positions[i] - surface.positions[rows[i]]), 1e-14);
      ASSERT_LT(glm::length(normals[i] - surface.normals[rows[i]]), 1e-6f);
    }
    for (std::int64_t i = 0; i < range.count; ++i) {
      ASSERT_EQ(groups[i], surface.face_groups[range.first + i]);
      ASSERT_EQ(groups[i], ancestors[i] % 2);
      ASSERT_NE(ancestors[i] % 6, 1);  // holes
    }
  }
}

TEST(SurfaceBlocks, PiecesAreThoseOfTheWhole) {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const PolygonMesh mesh = laden_mesh(seed);
    const DooSabinSurface base(mesh, {});
    for (int level = 0; level <= 3; ++level) {
      SCOPED_TRACE(level);
      const auto blocks = base.level(level);
      const SurfaceMesh surface = collect(*blocks, {});
      for (const std::int64_t size : {97, 5000}) {
        expect_pieces_equal(*blocks, surface, size);
        expect_pieces_equal(*blocks_of(surface, mesh), surface, size);
      }
    }
  }
}

TEST(SurfaceBlocks, RowBlocksCoverAllRowsOnce) {
  const PolygonMesh mesh = laden_mesh(2);
  const DooSabinSurface base(mesh, {});
  for (int level = 0; level <= 4; ++level) {
    const auto blocks = base.level(level);
    for (const std::int64_t size : {1, 1000, 1 << 20}) {
      std::int64_t row = 0;
      for (const RowRange range : sorted(blocks->row_blocks(size))) {
        EXPECT_EQ(range.first, row);
        row += range.count;
      }
      EXPECT_EQ(row, blocks->info().row_count);
    }
  }
}

TEST(SurfaceBlocks, BitsDoNotDependOnThreads) {
  const PolygonMesh mesh = laden_mesh(4);
  const auto surface_of = [&](int threads) {
    return evaluate(mesh, *make_cpu_backend({.thread_count = threads}), {.level = 4});
  };
  const SurfaceMesh one = surface_of(1), four = surface_of(4);
  EXPECT_EQ(one.positions, four.positions);
  EXPECT_EQ(one.normals, four.normals);
  EXPECT_EQ(one.face_vertices, four.face_vertices);
  EXPECT_EQ(one.uvs, four.uvs);
  EXPECT_EQ(one.face_uvs, four.face_uvs);
  EXPECT_EQ(one.colors, four.colors);
}

// OpenSubdiv's own linear interpolation, level by level.
struct Color {
  glm::dvec4 value{0.0};
  void Clear() { value = glm::dvec4(0.0); }
  void AddWithWeight(const Color& other, double weight) { value += weight * other.value; }
};

TEST(SurfaceBlocks, ColoursAreInterpolatedAsOpenSubdivDoes) {
  for (auto [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    mesh.colors.resize(mesh.positions.size());
    for (std::size_t v = 0; v < mesh.colors.size(); ++v) {
      mesh.colors[v] = {0.1f * static_cast<float>(v % 7), 0.2f * static_cast<float>(v % 3),
                        0.01f * static_cast<float>(v), 1.0f};
    }
    for (int level = 1; level <= 3; ++level) {
      QuadSplit split(mesh);
      split.refine(level);
      std::vector<Color> colors(mesh.colors.size());
      for (std::size_t v = 0; v < colors.size(); ++v) colors[v].value = glm::dvec4(mesh.colors[v]);
      const OpenSubdiv::Far::PrimvarRefinerReal<double> refiner(split.refiner());
      for (int l = 1; l <= level; ++l) {
        std::vector<Color> finer(static_cast<std::size_t>(split.level(l).GetNumVertices()));
        refiner.InterpolateVarying(l, colors, finer);
        colors = std::move(finer);
      }
      const DooSabinSurface base(mesh, {});
      const SurfaceMesh surface = collect(*base.level(level), {});
      const MeshTopology topology(mesh);
      const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
      const Subdivision subdivision(split, features, Weights::DooSabin);
      const LimitRows limits(subdivision, level, split.counts(level).vertices);
      const PatchMesh patches(topology, features);
      const auto order = limits_of_rows(topology, PatchNumbering(patches, level), split, limits);
      ASSERT_EQ(order.size(), surface.colors.size());
      for (std::size_t row = 0; row < order.size(); ++row) {
        const glm::dvec4 wanted = colors[limits.place(order[row]).vertex].value;
        ASSERT_LT(glm::length(glm::dvec4(surface.colors[row]) - wanted), 2e-7) << row;
      }
    }
  }
}

TEST(SurfaceBlocks, VerticesThatOnlyHolesNameAreLeftOut) {
  PolygonMesh mesh =
      read_mesh(std::filesystem::path(PLANISH_SCENES) / "cube_with_windows.obj").mesh;
  ASSERT_FALSE(mesh.hole_faces.empty());
  const auto surface_of = [&](int level, Scheme scheme) {
    return evaluate(mesh, *make_cpu_backend(), {.level = level, .scheme = scheme});
  };
  for (const Scheme scheme : {Scheme::DooSabin, Scheme::CatmullClark}) {
    for (int level = 0; level <= 2; ++level) {
      const SurfaceMesh surface = surface_of(level, scheme);
      const std::set<std::int32_t> named(surface.face_vertices.begin(),
                                         surface.face_vertices.end());
      EXPECT_EQ(named.size(), surface.positions.size()) << level;
      for (std::size_t i = 0; i < surface.base_vertices.size(); ++i) {
        EXPECT_LT(surface.base_vertices[i], mesh.vertex_count());
      }
    }
  }
  const std::size_t holed = surface_of(2, Scheme::DooSabin).positions.size();
  mesh.hole_faces.clear();
  const std::size_t whole = surface_of(2, Scheme::DooSabin).positions.size();
  EXPECT_EQ(whole, 866u);
  EXPECT_EQ(whole - holed, 54u);
}

TEST(SurfaceBlocks, PiecesAreTakenInOrder) {
  const std::vector<RowRange> ranges = ranges_of(1000, 7);
  std::vector<std::int64_t> taken;
  in_order<std::vector<std::int64_t>>(
      ranges,
      [](RowRange range, std::vector<std::int64_t>& piece) {
        piece.clear();
        for (std::int64_t i = 0; i < range.count; ++i) piece.push_back(range.first + i);
      },
      [&](RowRange, const std::vector<std::int64_t>& piece) {
        taken.insert(taken.end(), piece.begin(), piece.end());
      });
  ASSERT_EQ(taken.size(), 1000u);
  for (std::int64_t i = 0; i < 1000; ++i) EXPECT_EQ(taken[i], i);
}

}  // namespace
}  // namespace planish
