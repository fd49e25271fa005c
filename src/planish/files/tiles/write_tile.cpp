#include "planish/files/tiles/write_tile.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <variant>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/version.h"
#include "planish/files/gltf/position_grid.h"

namespace planish {
namespace {

// An estimate is no bound: finer levels were up to 1.1 times as far away on creased models.
constexpr double kErrorShare = 4.0 / 3.0;
// Of the box of the given vertices: the surface between them leaves it by less, as a rule.
constexpr double kReachShare = 1.0 + 1.0 / 16;

// Whole numbers with a sign: of the filter that float positions are packed by, and of 16 bits.
constexpr int kPackedBits = 23, kShortBits = 15;

double largest_of(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

double distance_from_given(const TileSource& source, const TileMesh& made, const glm::dvec3& origin,
                           std::span<const glm::dvec3> given) {
  const std::vector<std::int32_t>& base = source.blocks.info().base_vertices;
  double largest = 0;
  for (std::size_t i = 0; i < made.rows.size(); ++i) {
    const auto row = static_cast<std::size_t>(made.rows[i]);
    if (row >= base.size()) break;  // rows ascend
    const glm::dvec3 read = origin + glm::dvec3(glm::vec3(made.mesh.positions[i]));
    const double distance = glm::length(read - given[base[row]]);
    largest = std::max(
        largest, std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity());
  }
  return largest;
}

std::vector<std::byte> glb_of(const TileMesh& made, const PlannedTile& tile, const TileGrid& grid,
                              const GltfOptions& options) {
  GltfOptions gltf;
  gltf.compression = options.compression;
  gltf.grid_step = grid.step();
  gltf.materials = options.materials;
  gltf.image_folder = kTileImages;
  gltf.name = options.name + " " + tile_name(tile);
  gltf.double_sided = options.double_sided;
  gltf.z_up = options.z_up;
  gltf.extras = {{"planish", std::string(PLANISH_VERSION)}, {"level", std::int64_t{tile.level}}};
  // A thread that waits here must not begin another tile.
  return oneapi::tbb::this_task_arena::isolate([&] { return encode_glb(made.mesh, gltf); });
}

std::string extras_of(const GltfOptions& options) {
  nlohmann::json json;
  for (const auto& [key, value] : options.extras)
    std::visit([&, &name = key](const auto& held) { json[name] = held; }, value);
  return json.is_null() ? "" : json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void TileReach::add(const TileBox& block) {
  reach = std::max(reach, largest_of(block.half()));
  largest = std::max({largest, largest_of(block.lower), largest_of(block.upper)});
}

TileGrid TileReach::grid(int doublings, const GltfOptions& options) const {
  const double share = std::ldexp(kReachShare, doublings);
  const double coarsest = coarsest_step(options.position_error);
  const auto of_bits = [&](int bits, double coarsest_of_bits) {
    return TileGrid(share * reach, 2 * share * largest, bits, coarsest_of_bits);
  };
  switch (options.compression) {
    case GltfCompression::Meshopt:
      return of_bits(kPackedBits, coarsest);
    case GltfCompression::Quantize:
      if (const TileGrid shorts = of_bits(kShortBits, 0); shorts.step() <= coarsest) return shorts;
      break;
    case GltfCompression::None:
      break;
  }
  return of_bits(TileGrid::kFloatBits, 0);
}

std::optional<WrittenTile> write_tile(const TileSource& source, const PlannedTile& tile,
                                      const TilePlace& place, const TilesOptions& options) {
  TileMesh made = make_tile(source, tile, place.origin);
  WrittenTile written;
  written.record.error = place.error;
  written.largest_distance = distance_from_given(
      source, made, place.origin, options.points.empty() ? options.given : options.points);
  // Those of a finer level are others, and its own once more.
  if (tile.level == options.level) written.degenerate = made.degenerate;
  if (tile.level > 1) written.coarser_error = kErrorShare * coarser_error(made.mesh);
  const double gap = tile.level == options.level ? written.coarser_error : place.error;
  if (options.skirts && gap > 0) add_skirts(source, tile, gap, made);
  TileRecord& record = written.record;
  record.box = box_of(made.mesh);
  if (std::max(largest_of(record.box.lower), largest_of(record.box.upper)) > source.grid.reach())
    return std::nullopt;
  OutputFile file(place.path);
  const std::vector<std::byte> bytes = glb_of(made, tile, source.grid, options.gltf);
  file.write(bytes);
  file.commit();
  record.bytes = bytes.size();
  record.vertex_count = made.mesh.positions.size();
  record.triangle_count = 2 * static_cast<std::uint64_t>(made.mesh.face_count());
  return written;
}

void pass_errors_up(std::span<const PlannedTile> tiles, int level, std::span<WrittenTile> written) {
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    if (tiles[i].level != level || tiles[i].parent < 0) continue;
    TileRecord& above = written[tiles[i].parent].record;
    above.error = std::max({above.error, written[i].coarser_error, written[i].record.error});
  }
}

void pass_boxes_up(std::span<const PlannedTile> tiles, std::span<WrittenTile> written) {
  // Children come behind their parents.
  for (std::size_t i = tiles.size(); i-- > 0;) {
    const std::int32_t parent = tiles[i].parent;
    if (parent >= 0) written[parent].record.box.add(written[i].record.box);
  }
}

TilesFile sum_of_tiles(std::span<const PlannedTile> tiles, std::span<const WrittenTile> written,
                       int level) {
  TilesFile file;
  for (int l = 1; l <= level; ++l) file.levels.emplace_back().level = l;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const TileRecord& record = written[i].record;
    TileLevel& at = file.levels[tiles[i].level - 1];
    ++at.tiles;
    at.bytes += record.bytes;
    at.vertex_count += record.vertex_count;
    at.triangle_count += record.triangle_count;
    at.geometric_error = std::max(at.geometric_error, record.error);
    file.byte_count += record.bytes;
    file.largest_distance = std::max(file.largest_distance, written[i].largest_distance);
    file.degenerate.add(written[i].degenerate);
  }
  return file;
}

void require_tiles_options(const TilesOptions& options) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, options.gltf.name + ": " + what);
  };
  if (options.level < 1) refuse("3D Tiles have levels from 1 on");
  if (options.tile_vertices < kLeastTileVertices) {
    refuse(formatted("tiles of {} vertices; {} are the least", options.tile_vertices,
                     kLeastTileVertices));
  }
}

std::vector<TilesetText> documents_of(const std::filesystem::path& path, const TilePlan& plan,
                                      std::span<const WrittenTile> written,
                                      std::span<const glm::dvec3> origins,
                                      const TilesOptions& options) {
  std::vector<TileRecord> records;
  records.reserve(written.size());
  for (const WrittenTile& tile : written) records.push_back(tile.record);
  return tileset_documents(plan, records, origins,
                           {.folder = tile_folder(path).filename().string(),
                            .z_up = options.gltf.z_up,
                            .extras = extras_of(options.gltf)});
}

}  // namespace planish
