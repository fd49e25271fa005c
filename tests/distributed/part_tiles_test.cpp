#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "distributed/rank_runs.h"
#include "planish/distributed/fit_distributed.h"
#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_tiles.h"
#include "planish/distributed/write_cage.h"
#include "planish/fair/fair_net.h"
#include "planish/files/mesh_file.h"
#include "planish/measure/figures.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "support/calls.h"
#include "support/files.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

namespace fs = std::filesystem;

struct TilesCase {
  std::string input;
  DistributedOptions options;
};

// The document, its tiles and the cage in a folder of their own.
DistributedFit fit_with_tiles(const Ranks& ranks, const TilesCase& job, const std::string& folder) {
  agree(ranks, [&] {
    if (ranks.rank != 0) return;
    fs::remove_all(shared_path(folder));
    fs::create_directory(shared_path(folder));
  });
  RankWatch watch(ranks.rank);
  DistributedOptions options = job.options;
  options.name = job.input;
  options.tiles = shared_path(folder + "/t.json");
  if (options.method == InterpolationMethod::Progressive)
    options.cage = shared_path(folder + ".ply");
  return fit_distributed(
      ranks, [&] { return read_slices(ranks, job.input); }, options, watch);
}

// What write_tiles() makes of the same cage on one machine.
class OneMachine {
 public:
  OneMachine(const TilesCase& job, const std::string& cage, const DistributedFit& fit)
      : job_(job), given_(read_mesh(job.input).mesh), cage_(given_) {
    EvaluateOptions options;
    options.weights = job.options.weights;
    options.sharp = job.options.sharp;
    options.rest_positions = given_.positions;
    if (is_fair()) {
      level_one_ = fair_points();
      surface_ = std::make_unique<DooSabinSurface>(given_, level_one_, options);
    } else {
      cage_.positions = read_mesh(cage).mesh.positions;
      surface_ = std::make_unique<DooSabinSurface>(cage_, options);
    }
    tiles_ = job.options.tiles_options;
    tiles_.given = given_.positions;
    tiles_.gltf.double_sided = false;
    for (std::int32_t e = 0; e < surface_->topology().edge_count(); ++e)
      tiles_.gltf.double_sided |= surface_->topology().is_boundary_edge(e);
    FitOptions fitted;
    fitted.method = job.options.method;
    fitted.weights = job.options.weights;
    fitted.solver = job.options.solver;
    fitted.tolerance = job.options.tolerance;
    fitted.sharp = job.options.sharp;
    Interpolation result;
    result.converged = fit.solution.converged;
    result.iterations = fit.solution.iterations;
    result.error = fit.solution.error;
    tiles_.gltf.extras = fit_extras(fitted, "use", result);
  }

  [[nodiscard]] TilesFile write(const std::string& folder) const {
    fs::remove_all(shared_path(folder));
    fs::create_directory(shared_path(folder));
    return write_tiles(shared_path(folder + "/t.json"), *surface_, tiles_);
  }
  [[nodiscard]] SurfaceQuality quality() const {
    const FoldedEdges folds = folded_edges(given_);
    return surface_quality(*surface_->level(1), given_, folds.is_beside, {});
  }

 private:
  [[nodiscard]] bool is_fair() const { return job_.options.method == InterpolationMethod::Fair; }
  [[nodiscard]] LevelOne fair_points() const {
    FitOptions options;
    options.method = InterpolationMethod::Fair;
    options.weights = job_.options.weights;
    options.sharp = job_.options.sharp;
    const auto backend = make_cpu_backend();
    return planish::fit(given_, *backend, options).fair->level_one;
  }

  const TilesCase& job_;
  PolygonMesh given_, cage_;
  LevelOne level_one_;
  std::unique_ptr<DooSabinSurface> surface_;
  TilesOptions tiles_;
};

void expect_same_figures(const PartTiles& tiles, const TilesFile& expected,
                         const SurfaceQuality& quality) {
  EXPECT_EQ(tiles.file.byte_count, expected.byte_count);
  EXPECT_EQ(tiles.file.row_count, expected.row_count);
  EXPECT_EQ(tiles.file.face_count, expected.face_count);
  EXPECT_EQ(tiles.file.largest_distance, expected.largest_distance);
  ASSERT_EQ(tiles.file.levels.size(), expected.levels.size());
  for (std::size_t i = 0; i < expected.levels.size(); ++i) {
    EXPECT_EQ(tiles.file.levels[i].tiles, expected.levels[i].tiles);
    EXPECT_EQ(tiles.file.levels[i].vertex_count, expected.levels[i].vertex_count);
    EXPECT_EQ(tiles.file.levels[i].geometric_error, expected.levels[i].geometric_error);
  }
  // Sums in another order.
  constexpr double kRounding = 1e-12;
  const auto near = [&](double got, double wanted) {
    EXPECT_NEAR(got, wanted, kRounding * std::max(1.0, wanted));
  };
  near(tiles.quality.folded_area, quality.folded_area);
  near(tiles.quality.folded_area_elsewhere, quality.folded_area_elsewhere);
  near(tiles.quality.rms_normal_deviation, quality.rms_normal_deviation);
  near(tiles.quality.bending, quality.bending);
  EXPECT_NEAR(tiles.quality.max_normal_deviation, quality.max_normal_deviation, 1e-6);
  ASSERT_EQ(tiles.folded_faces.size(), quality.folded_places.size());
  for (std::size_t i = 0; i < tiles.folded_faces.size(); ++i)
    EXPECT_EQ(tiles.folded_faces[i], quality.folded_places[i].face);
}

using Files = std::vector<std::pair<std::string, std::string>>;

void expect_same_files(const Files& got, const Files& expected, const std::string& what) {
  ASSERT_EQ(got.size(), expected.size()) << what;
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i].first, expected[i].first) << what;
    EXPECT_TRUE(got[i].second == expected[i].second) << what << ": " << got[i].first;
  }
}

void expect_tiles_of_one_machine(const TilesCase& job) {
  Files reference;
  DistributedFit fit;
  for (const int count : kRankCounts)
    on_ranks(count, [&](const Ranks& ranks) {
      fit = fit_with_tiles(ranks, job, "tiles");
      if (ranks.rank != 0) return;
      const Files files = files_below(shared_path("tiles"));
      const std::string what = job.input + " on " + std::to_string(count);
      if (reference.empty()) {
        reference = files;
        EXPECT_GT(files.size(), 2u);
        const OneMachine one(job, shared_path("tiles.ply"), fit);
        const TilesFile expected = one.write("expected");
        expect_same_files(files, files_below(shared_path("expected")), what + " and one machine");
        expect_same_figures(*fit.tiles, expected, one.quality());
      } else {
        expect_same_files(files, reference, what);
      }
    });
}

DistributedOptions tiles_of(int level, bool skirts = false) {
  DistributedOptions options;
  options.tiles_options.level = level;
  options.tiles_options.tile_vertices = kLeastTileVertices;
  options.tiles_options.skirts = skirts;
  options.tiles_options.gltf.name = "scene";
  return options;
}

// Closed, open, creased, with corners, darts, holes that are not shown, 3- to 64-gons.
class TiledScene : public testing::TestWithParam<const char*> {};

TEST_P(TiledScene, HasTheTilesOfOneMachineInTheSameBytesForEveryRankCount) {
  expect_tiles_of_one_machine(
      {std::string(PLANISH_SCENES) + "/" + GetParam() + ".obj", tiles_of(2)});
}

INSTANTIATE_TEST_SUITE_P(PartTiles, TiledScene,
                         testing::Values("bearing_block", "cube", "cube_with_windows", "goblet",
                                         "l_bracket", "mapped_cube", "mixed_polygons", "open_grid",
                                         "plate_with_holes", "pole64", "wavy_patch"),
                         [](const auto& scene) { return std::string(scene.param); });

TEST(PartTiles, DeepLevelsWithSkirtsAreThoseOfOneMachine) {
  const std::string creased =
      shared_file("creased_tiles.obj", obj_of(with_random_creases(random_open_mesh(3), 0.2, 3)));
  TilesCase job{creased, tiles_of(4, true)};
  job.options.weights = Weights::Averaged;
  job.options.sharp = {BoundaryRule::EdgeAndCorner, true};
  job.options.tiles_options.gltf.z_up = true;
  expect_tiles_of_one_machine(job);
  job.options.sharp = {BoundaryRule::Edge, false};
  job.options.tiles_options.level = 1;
  expect_tiles_of_one_machine(job);
}

TEST(PartTiles, FoldsAndUnusedVerticesAreThoseOfOneMachine) {
  PolygonMesh mesh = mixed_torus(24, 12);
  // A vertex that is pulled through the surface folds it.
  for (const std::size_t v : {30u, 100u, 200u}) mesh.positions[v] *= 0.7;
  mesh.positions.insert(mesh.positions.begin() + 40, {40, 50, 60});
  for (std::int32_t& v : mesh.face_vertices) v += v >= 40 ? 1 : 0;
  expect_tiles_of_one_machine({shared_file("folded.ply", ply_of(mesh)), tiles_of(2)});
}

// Closed; open with creases, corners and darts; with holes and folds.
TEST(PartTiles, FairSurfacesAreThoseOfOneMachine) {
  const std::string creased =
      shared_file("fair_tiles.obj", obj_of(with_random_creases(random_open_mesh(3), 0.2, 3)));
  PolygonMesh folded = mixed_torus(24, 12);
  for (const std::size_t v : {30u, 100u, 200u}) folded.positions[v] *= 0.7;
  for (const std::string& input : {creased, shared_file("fair_folded.ply", ply_of(folded)),
                                   std::string(PLANISH_SCENES) + "/cube_with_windows.obj"}) {
    TilesCase job{input, tiles_of(3, true)};
    job.options.method = InterpolationMethod::Fair;
    job.options.weights = input == creased ? Weights::Averaged : Weights::DooSabin;
    expect_tiles_of_one_machine(job);
  }
}

// Seams, shared and missing coordinates, colours, groups, holes, creases.
TEST(PartTiles, AttributesAreThoseOfOneMachine) {
  PolygonMesh mesh = laden_mesh(7);
  // A corner without a coordinate, faces without any, and one vt for corners far from each other.
  mesh.face_uvs[50] = -1;
  for (std::int32_t c = mesh.face_offsets[30]; c < mesh.face_offsets[33]; ++c)
    mesh.face_uvs[c] = -1;
  for (std::size_t c = 5; c < mesh.face_uvs.size(); c += 40) mesh.face_uvs[c] = 3;
  mesh.groups.push_back({});
  for (const std::size_t f : {0u, 40u, 41u}) mesh.face_groups[f] = 2;
  TilesCase job{written("laden.obj", FileFormat::Obj, mesh), tiles_of(3, true)};
  expect_tiles_of_one_machine(job);
  job.options.tiles_options.level = 1;
  expect_tiles_of_one_machine(job);
  job.options.method = InterpolationMethod::Fair;
  job.options.tiles_options.level = 2;
  expect_tiles_of_one_machine(job);
}

// Colours without texture coordinates, which are blended between vertices, too.
TEST(PartTiles, ColoursAloneAreThoseOfOneMachine) {
  PolygonMesh mesh = laden_mesh(8);
  mesh.uvs.clear();
  mesh.face_uvs.clear();
  ASSERT_FALSE(mesh.colors.empty());
  expect_tiles_of_one_machine({written("coloured.obj", FileFormat::Obj, mesh), tiles_of(3, true)});
}

TEST(PartTiles, AttributesOfUnusedVerticesAreThoseOfOneMachine) {
  PolygonMesh mesh = mixed_torus(24, 12);
  mesh.positions.insert(mesh.positions.begin() + 40, {4, 5, 6});
  for (std::int32_t& v : mesh.face_vertices) v += v >= 40 ? 1 : 0;
  expect_tiles_of_one_machine(
      {shared_file("mapped.ply", ply_with_attributes(mesh)), tiles_of(2, true)});
}

TEST(PartTiles, ARecordIsTakenOnlyOfTheSameJob) {
  const std::string input = shared_file("record.ply", ply_of(mixed_torus(24, 12)));
  on_ranks(2, [&](const Ranks& ranks) {
    const std::string path = shared_path("record");
    WrittenBlock block;
    block.tiles.resize(3);
    block.tiles[1].record.error = 0.25;
    block.figures.row_count = 77;
    const TilesKey key{1, 2};
    if (ranks.rank == 0) {
      write_record(path, key, block);
      const auto read = read_record(path, key, 3);
      ASSERT_TRUE(read);
      EXPECT_EQ(read->tiles[1].record.error, 0.25);
      EXPECT_EQ(read->figures.row_count, 77);
      EXPECT_FALSE(read_record(path, TilesKey{1, 3}, 3));
      EXPECT_FALSE(read_record(path, tiles_key_on_grid(key, 1), 3));
      EXPECT_FALSE(read_record(path, key, 2));
      fs::resize_file(path, fs::file_size(path) - 1);
      EXPECT_FALSE(read_record(path, key, 3));
      EXPECT_FALSE(read_record(path + "none", key, 3));
    }
  });
}

// The key of what tiles are made of, on so many ranks.
TilesKey key_on(int count, const std::string& input, const PartTilesOptions& options,
                double moved = 0) {
  TilesKey key{};
  on_ranks(count, [&](const Ranks& ranks) {
    MeshSlice slice = read_slices(ranks, input);
    CurveOrder order = order_along_curve(ranks, slice, 16);
    FaceStream ring = send_first_ring(ranks, slice, order);
    MeshPart part = make_part(ranks, std::move(ring), slice, std::move(order));
    std::vector<glm::dvec3> cage = part.positions;
    for (std::int32_t v = 0; v < part.owned_count(); ++v)
      if (part.file_ids[v] == 5) cage[v].x += moved;
    key = tiles_key(ranks, part, cage, options);
  });
  return key;
}

TEST(PartTiles, TheKeyIsTheSameForEveryRankCountAndOfAllThatTilesDependOn) {
  const std::string input =
      shared_file("keyed.obj", obj_of(with_random_creases(random_open_mesh(5), 0.2, 5)));
  const PartTilesOptions options;
  const TilesKey key = key_on(1, input, options);
  const TilesKey on_five = key_on(5, input, options);
  if (is_first_rank()) {
    EXPECT_EQ(on_five, key);
  }
  const TilesKey moved = key_on(2, input, options, 1e-15);
  PartTilesOptions other;
  other.tiles.skirts = true;
  const TilesKey with_skirts = key_on(2, input, other);
  PolygonMesh tagged = with_random_creases(random_open_mesh(5), 0.2, 5);
  std::vector<TilesKey> of_corners;
  for (const std::int32_t vertex : {3, 4}) {
    tagged.corners = {{vertex, 2.0f}};
    of_corners.push_back(key_on(2, shared_file("cornered.obj", obj_of(tagged)), options));
  }
  PolygonMesh laden = laden_mesh(5);
  const auto key_of_laden = [&](int count) {
    return key_on(count, written("key.obj", FileFormat::Obj, laden), options);
  };
  std::vector<TilesKey> keys{key_of_laden(3), key_of_laden(1)};
  laden.colors[17].g = 0.75f;
  keys.push_back(key_of_laden(3));
  laden.uvs[laden.face_uvs[40]].x += 0.5;
  keys.push_back(key_of_laden(3));
  laden.face_groups[5] = 0;
  keys.push_back(key_of_laden(3));
  laden.groups[1].material = "green";
  keys.push_back(key_of_laden(3));
  if (is_first_rank()) {
    EXPECT_EQ(keys[0], keys[1]);
    for (std::size_t i = 2; i < keys.size(); ++i) EXPECT_NE(keys[i], keys[i - 1]) << i;
    EXPECT_NE(moved, key);
    EXPECT_NE(with_skirts, key);
    EXPECT_NE(of_corners[0], of_corners[1]);
  }
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

TEST(StagedFile, AppearsWholeWithTheBytesOfAllRanks) {
  const std::string path = shared_file("staged.txt", "old");
  on_ranks(3, [&](const Ranks& ranks) {
    StagedFile file(ranks, path);
    const std::string own(4, static_cast<char>('a' + ranks.rank));
    file.write(4 * ranks.rank, bytes_of(own));
    file.close(12);
    EXPECT_EQ(content_of(path), "old");
    MPI_Barrier(ranks.comm);
    file.commit();
  });
  if (is_first_rank()) {
    EXPECT_EQ(content_of(path), "aaaabbbbcccc");
  }
}

TEST(StagedFile, TouchesNoOtherProgramsFile) {
  const std::string path = shared_path("beside.txt");
  // As browsers name what they have not yet downloaded whole.
  const std::string part = shared_file("beside.txt.part", "a stranger's");
  on_ranks(2, [&](const Ranks& ranks) {
    StagedFile file(ranks, path);
    file.write(2 * ranks.rank, bytes_of("xy"));
    file.close(4);
    file.commit();
  });
  if (!is_first_rank()) return;
  EXPECT_EQ(content_of(path), "xyxy");
  EXPECT_EQ(content_of(part), "a stranger's");
}

TEST(StagedFile, ReplacesALinkAndNotWhatItNames) {
  const std::string target = shared_file("target.txt", "mine");
  const std::string path = shared_path("link.txt");
  if (is_first_rank()) {
    fs::remove(path);
    fs::create_symlink(target, path);
  }
  on_ranks(2, [&](const Ranks& ranks) {
    StagedFile file(ranks, path);
    file.write(2 * ranks.rank, bytes_of("xy"));
    file.close(4);
    file.commit();
  });
  if (is_first_rank()) {
    EXPECT_EQ(content_of(target), "mine");
  }
}

// Whoever runs the job without --force keeps what comes to the output's place meanwhile.
TEST(StagedFile, LeavesWhatCameMeanwhile) {
  const std::string path = shared_path("came.txt");
  if (is_first_rank()) fs::remove(path);
  on_ranks(2, [&](const Ranks& ranks) {
    StagedFile file(ranks, path, /*replaces=*/false);
    file.write(2 * ranks.rank, bytes_of("xy"));
    file.close(4);
    if (ranks.rank == 0) std::ofstream(path) << "a stranger's";
    (void)message_of(ErrorCode::UnwritableOutput, [&] { file.commit(); });
  });
  if (is_first_rank()) {
    EXPECT_EQ(content_of(path), "a stranger's");
  }
}

TEST(StagedTileset, LeavesWhatCameMeanwhile) {
  const fs::path folder = shared_path("tiles_meanwhile");
  const fs::path document = folder / "t.json";
  for (const char* const strange : {"t.json", "t/mine.txt"}) {
    if (is_first_rank()) {
      fs::remove_all(folder);
      fs::create_directories(folder);
    }
    on_ranks(2, [&](const Ranks& ranks) {
      StagedTileset tiles(ranks, document, /*resume=*/false, /*replaces=*/false);
      if (ranks.rank == 0) {
        std::ofstream(tiles.document()) << "ours";
        fs::create_directories((folder / strange).parent_path());
        std::ofstream(folder / strange) << "a stranger's";
      }
      (void)message_of(ErrorCode::UnwritableOutput, [&] { tiles.commit(); });
    });
    if (!is_first_rank()) continue;
    EXPECT_EQ(content_of((folder / strange).string()), "a stranger's");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << strange;
  }
}

TEST(StagedFile, WithoutCommitNothingIsLeft) {
  const std::string path = shared_file("kept.txt", "old");
  const auto count = [&] {
    std::int64_t entries = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(path).parent_path()))
      entries += entry.path().filename().string().starts_with("kept.txt");
    return entries;
  };
  on_ranks(2, [&](const Ranks& ranks) {
    {
      StagedFile file(ranks, path);
      file.write(2 * ranks.rank, bytes_of("xy"));
    }
    MPI_Barrier(ranks.comm);
    EXPECT_EQ(count(), 1);
    EXPECT_EQ(content_of(path), "old");
  });
}

}  // namespace
}  // namespace planish::test
