#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <glm/geometric.hpp>
#include <set>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/mesh_file.h"
#include "planish/measure/figures.h"
#include "planish/mesh/face_geometry.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/kept_rows.h"
#include "planish/surface/mesh_blocks.h"
#include "planish/surface/surface_blocks.h"
#include "support/mesh_catalogue.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

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
      if (surface.level <= 1) {
        ASSERT_EQ(positions[i], surface.positions[rows[i]]);
        ASSERT_EQ(normals[i], surface.normals[rows[i]]);
      }
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
    const PolygonMesh mesh = test::laden_mesh(seed);
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

const glm::dvec3 kOrigin(0.5, -1, 2);

// What the pass sees, in order.
struct Visited {
  explicit Visited(const SurfaceBlocks& blocks)
      : positions(static_cast<std::size_t>(4 * blocks.info().face_count)),
        normals(positions.size()) {}

  std::unique_ptr<SurfaceBlocks> keep(const SurfaceBlocks& blocks,
                                      std::uint64_t row_bytes = std::uint64_t{1} << 30) {
    const auto visit = [&](RowRange faces, std::span<const glm::dvec3> at,
                           std::span<const glm::vec3> along) {
      std::copy(at.begin(), at.end(), positions.begin() + 4 * faces.first);
      std::copy(along.begin(), along.end(), normals.begin() + 4 * faces.first);
      face_count += faces.count;
    };
    return keep_rows(blocks, {.origin = kOrigin, .visit = visit, .row_bytes = row_bytes});
  }

  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
  std::atomic<std::int64_t> face_count{0};
};

void expect_kept(const SurfaceBlocks& blocks, const SurfaceBlocks& kept, const Visited& visited) {
  const SurfaceInfo& info = blocks.info();
  const auto rows = static_cast<std::size_t>(info.row_count);
  std::vector<glm::vec3> stored[2], normals[2];
  std::vector<glm::dvec3> positions[2];
  for (const int k : {0, 1}) {
    stored[k].resize(rows), normals[k].resize(rows), positions[k].resize(rows);
    RowTarget target;
    target.stored = stored[k];
    target.normals = normals[k];
    target.positions = positions[k];
    target.origin = kOrigin;
    (void)(k == 0 ? blocks : kept).rows({0, info.row_count}, target);
  }
  EXPECT_EQ(stored[0], stored[1]);
  EXPECT_EQ(normals[0], normals[1]);
  EXPECT_EQ(positions[0], positions[1]);
  if (info.level == 0) return;
  const auto faces = static_cast<std::size_t>(info.face_count);
  std::vector<std::uint8_t> cuts(faces);
  for (const RowRange range : ranges_of(info.face_count, 100))
    kept.cuts(range, std::span(cuts).subspan(static_cast<std::size_t>(range.first),
                                             static_cast<std::size_t>(range.count)));
  ASSERT_EQ(visited.positions.size(), 4 * faces);
  Visited wanted(blocks);
  blocks.corners({0, info.face_count}, wanted.positions, wanted.normals);
  for (std::size_t i = 0; i < 4 * faces; ++i) {
    ASSERT_LT(glm::length(visited.positions[i] - wanted.positions[i]), 1e-14);
    ASSERT_LT(glm::length(visited.normals[i] - wanted.normals[i]), 1e-6f);
  }
  for (std::size_t f = 0; f < faces; ++f) {
    const glm::dvec3* p = visited.positions.data() + 4 * f;
    ASSERT_EQ(cuts[f] != 0, is_cut_from_1(p[0], p[1], p[2], p[3]));
  }
}

TEST(SurfaceBlocks, KeptRowsAreThoseMadeAnew) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    PolygonMesh mesh = test::laden_mesh(seed);
    if (seed > 2) mesh.hole_faces.clear();
    const DooSabinSurface base(mesh, {});
    for (int level = 0; level <= 4; ++level) {
      for (const std::uint64_t row_bytes : {std::uint64_t{0}, std::uint64_t{1} << 30}) {
        SCOPED_TRACE(level);
        const auto blocks = base.level(level);
        Visited visited(*blocks);
        const auto kept = visited.keep(*blocks, row_bytes);
        EXPECT_EQ(visited.face_count, level == 0 ? 0 : blocks->info().face_count);
        expect_kept(*blocks, *kept, visited);
      }
    }
  }
}

// Of quads, whose faces make the rows of vertices and edges along at level 2: with a hole, creases
// and a boundary.
TEST(SurfaceBlocks, RowsOfQuadsAreTheSameByFaces) {
  PolygonMesh creased = test::torus(9, 7, 1.0, 0.4);
  creased.creases = {{0, 1}, {1, 2}, {30, 37}};
  for (const PolygonMesh& mesh : {test::torus(40, 30, 1.0, 0.4), creased, test::flat_grid(7, 6)}) {
    const DooSabinSurface base(mesh, {});
    const auto blocks = base.level(2);
    EXPECT_TRUE(blocks->makes_face_rows());
    const auto count = static_cast<std::size_t>(blocks->info().row_count);
    std::vector<glm::dvec3> positions[2];
    std::vector<glm::vec3> normals[2];
    RowTarget target[2];
    for (const int k : {0, 1}) {
      positions[k].resize(count), normals[k].resize(count);
      target[k].positions = positions[k];
      target[k].normals = normals[k];
    }
    (void)blocks->rows({0, blocks->info().row_count}, target[0]);
    (void)make_all_rows(*blocks, target[1], {});
    EXPECT_EQ(positions[0], positions[1]);
    EXPECT_EQ(normals[0], normals[1]);
    Visited visited(*blocks);
    const auto kept = visited.keep(*blocks);
    expect_kept(*blocks, *kept, visited);
  }
}

// A vertex with two opposite faces alone has no tangents.
TEST(SurfaceBlocks, KeptRowsTellOfDegenerateNormalsOnce) {
  const PolygonMesh mesh =
      read_mesh(std::filesystem::path(PLANISH_SCENES) / "cube_with_windows.obj").mesh;
  PolygonMesh flat = mesh;
  for (glm::dvec3& p : flat.positions) p = {p.x + p.y + p.z, 0, 0};
  flat.hole_faces.clear();
  const DooSabinSurface base(flat, {});
  for (int level = 0; level <= 3; ++level) {
    SCOPED_TRACE(level);
    std::vector<std::int64_t> collected, told;
    const auto counting = [](std::vector<std::int64_t>& counts) {
      Callbacks callbacks;
      callbacks.warning = [&counts](const Warning& warning) { counts.push_back(warning.count); };
      return callbacks;
    };
    const auto blocks = base.level(level);
    (void)collect(*blocks, counting(collected));
    for (const std::uint64_t row_bytes : {std::uint64_t{0}, std::uint64_t{1} << 30}) {
      told.clear();
      (void)collect(*keep_rows(*blocks, {.row_bytes = row_bytes, .callbacks = counting(told)}),
                    counting(told));
      EXPECT_EQ(collected.size(), 1u);
      EXPECT_EQ(told, collected);
    }
  }
}

TEST(SurfaceBlocks, RowBlocksCoverAllRowsOnce) {
  const PolygonMesh mesh = test::laden_mesh(2);
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
  const PolygonMesh mesh = test::laden_mesh(4);
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

void expect_part_of(const SurfaceMesh& whole, const SurfaceBlocks& blocks, RowRange faces) {
  const FaceRangeBlocks part(blocks, faces);
  const SurfaceMesh made = collect(part, {});
  const std::span<const std::int32_t> rows = part.surface_rows();
  ASSERT_EQ(made.face_count(), faces.count);
  ASSERT_EQ(made.positions.size(), rows.size());
  ASSERT_TRUE(std::ranges::is_sorted(rows));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(made.positions[i], whole.positions[rows[i]]);
    ASSERT_EQ(made.normals[i], whole.normals[rows[i]]);
    ASSERT_EQ(made.colors[i], whole.colors[rows[i]]);
    const auto row = static_cast<std::size_t>(rows[i]);
    for (std::size_t k = 0; k < 2; ++k)
      for (const int first : {0, 4})
        ASSERT_EQ(made.attributes[k].four(i, first), whole.attributes[k].four(row, first));
    ASSERT_EQ(i < made.base_vertices.size(), row < whole.base_vertices.size());
    if (i < made.base_vertices.size()) {
      ASSERT_EQ(made.base_vertices[i], whole.base_vertices[row]);
    }
  }
  const std::int64_t first = blocks.info().first_corner(faces.first);
  std::vector<bool> is_named(rows.size(), false);
  for (std::size_t c = 0; c < made.face_vertices.size(); ++c) {
    const std::size_t there = static_cast<std::size_t>(first) + c;
    const std::int32_t row = made.face_vertices[c];
    is_named[row] = true;
    ASSERT_EQ(rows[row], whole.face_vertices[there]);
    ASSERT_EQ(made.uvs[made.face_uvs[c]], whole.uvs[whole.face_uvs[there]]);
  }
  EXPECT_TRUE(std::ranges::all_of(is_named, [](bool named) { return named; }));
  for (std::int64_t f = 0; f < faces.count; ++f)
    ASSERT_EQ(made.face_groups[f], whole.face_groups[faces.first + f]);
}

TEST(FaceRangeBlocks, HaveTheSurfacesBits) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const PolygonMesh mesh = test::laden_mesh(seed);
    const DooSabinSurface base(mesh, {});
    for (const int level : {0, 1, 2, 3}) {
      SCOPED_TRACE(level);
      const auto blocks = base.level(level);
      const SurfaceMesh whole = collect(*blocks, {});
      const std::int64_t count = blocks->info().face_count;
      for (const RowRange faces : {RowRange{0, count}, RowRange{count / 3, count / 2},
                                   RowRange{count - 1, 1}, RowRange{0, 1}})
        expect_part_of(whole, *blocks, faces);
    }
  }
}

TEST(FaceRangeBlocks, NumbersKnowTheirPlaces) {
  SubsetNumbers numbers(200);
  numbers.add(std::array<std::int32_t, 5>{199, 3, 64, 63, 3});
  numbers.add(std::array<std::int32_t, 2>{128, 0});
  numbers.finish();
  EXPECT_EQ(std::vector<std::int32_t>(numbers.all().begin(), numbers.all().end()),
            (std::vector<std::int32_t>{0, 3, 63, 64, 128, 199}));
  EXPECT_EQ(numbers.place_of(0), 0);
  EXPECT_EQ(numbers.place_of(64), 3);
  EXPECT_EQ(numbers.place_of(199), 5);
}

struct Numbered {
  explicit Numbered(const PolygonMesh& mesh)
      : topology(mesh),
        features(find_sharp_features(mesh, topology, mesh.positions, {})),
        patches(topology, features),
        numbering(patches, 1) {}
  MeshTopology topology;
  SharpFeatures features;
  PatchMesh patches;
  PatchNumbering numbering;
};

void expect_places_of_face(const Numbered& at, const SharedPoints& points, std::int32_t face) {
  EXPECT_EQ(points.rows()[points.centre()], at.numbering.face_row(face));
  const std::int32_t first = at.topology.first_corner(face);
  for (std::int32_t c = first; c < first + at.topology.face_size(face); ++c) {
    EXPECT_EQ(points.rows()[points.vertex(c)], at.numbering.vertex_row(c));
    EXPECT_EQ(points.rows()[points.midpoint(c)], at.numbering.edge_row(c));
  }
}

TEST(SharedPoints, AreListedOnceEach) {
  const Numbered at(test::torus(7, 5, 1.0, 0.4));
  SharedPoints points(at.topology, at.numbering, at.topology.corner_count());
  for (std::int32_t face = 0; face < at.topology.face_count(); ++face) {
    points.add_face(face);
    expect_places_of_face(at, points, face);
  }
  // A vertex, a centre and two midpoints for each of 35 quads. A vertex whose faces so far touch it
  // across the face's own corner only is listed again.
  std::vector<std::int32_t> rows(points.rows().begin(), points.rows().end());
  std::ranges::sort(rows);
  const auto twice = std::ranges::unique(rows);
  EXPECT_EQ(twice.begin() - rows.begin(), 4 * 35);
  EXPECT_LE(std::ssize(twice), 5 + 7);
}

TEST(SharedPoints, BeginAnewBehindAFaceThatIsLeftOut) {
  const Numbered at(test::torus(7, 5, 1.0, 0.4));
  SharedPoints points(at.topology, at.numbering, at.topology.corner_count());
  for (const std::int32_t face : {3, 4, 9, 10, 2}) {
    points.add_face(face);
    expect_places_of_face(at, points, face);
  }
}

// Figures of ranges that share points are those of each range by itself.
TEST(SharedPoints, DoNotChangeFigures) {
  const PolygonMesh mesh = test::torus(80, 60, 1.0, 0.4);
  const DooSabinSurface base(mesh, {});
  const auto blocks = base.level(1);
  BlockQuality alone(*blocks, mesh, {});
  ASSERT_GT(swept_pieces(blocks->info()).size(), 8u);
  for (const RowRange piece : swept_pieces(blocks->info())) {
    std::vector<glm::dvec3> positions(static_cast<std::size_t>(4 * piece.count));
    std::vector<glm::vec3> normals(positions.size());
    for (std::int64_t i = 0; i < piece.count; ++i) {
      const auto at = static_cast<std::size_t>(4 * i);
      blocks->corners({piece.first + i, 1}, std::span(positions).subspan(at, 4),
                      std::span(normals).subspan(at, 4));
    }
    alone.add(piece, positions, normals);
  }
  const SurfaceQuality wanted = alone.result(), made = surface_quality(*blocks, mesh, {}, {});
  EXPECT_EQ(made.max_normal_deviation, wanted.max_normal_deviation);
  EXPECT_EQ(made.rms_normal_deviation, wanted.rms_normal_deviation);
  EXPECT_EQ(made.bending, wanted.bending);
  EXPECT_EQ(made.folded_area, wanted.folded_area);
}

}  // namespace
}  // namespace planish
