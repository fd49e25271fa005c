#include "planish/distributed/part_tiles.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/distributed/block_records.h"
#include "planish/distributed/block_surface.h"
#include "planish/distributed/sub_mesh.h"
#include "planish/files/tiles/tile_plan.h"
#include "planish/files/tiles/tileset.h"
#include "planish/files/tiles/write_tile.h"
#include "planish/mesh/folded_edges.h"
#include "planish/surface/block_quality.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {

namespace {

namespace fs = std::filesystem;

// A run of the rank's vertices, and the tiles of the faces that begin in it.
struct PlannedBlock {
  std::int32_t begin = 0, end = 0;  // owned vertices
  std::vector<PlannedTile> tiles;   // parents are places in here
  std::int64_t first_tile = 0;      // of the set's
  TileBox box;                      // of the given vertices of its faces
};

// What rank 0 has to know of a tile.
struct TileFact {
  PlannedTile tile;
  WrittenTile written;
  glm::dvec3 origin;
};

constexpr std::int32_t kInOtherBlock = std::numeric_limits<std::int32_t>::max();

class PartTilesWriter {
 public:
  PartTilesWriter(const Ranks& ranks, const fs::path& path, const MeshPart& part,
                  std::span<const glm::dvec3> cage, const PartTilesOptions& options)
      : ranks_(ranks), path_(path), part_(part), cage_(cage), options_(options), maker_(part) {}

  // The tiles of this rank's blocks, and where they stand among all.
  void plan() {
    std::int64_t tile_count = 0;
    agree(ranks_, [&] {
      require_tiles_options(options_.tiles);
      plan_blocks();
      for (const PlannedBlock& block : blocks_) tile_count += std::ssize(block.tiles);
    });
    std::int64_t first = sum_before(ranks_, tile_count);
    total_ = sum_over(ranks_, tile_count);
    block_total_ = sum_over(ranks_, std::ssize(blocks_));
    for (PlannedBlock& block : blocks_) {
      block.first_tile = first;
      first += std::ssize(block.tiles);
      reach_.add(block.box);
    }
    reach_.reach = max_over(ranks_, reach_.reach);
    reach_.largest = max_over(ranks_, reach_.largest);
    key_ = tiles_key(ranks_, part_, cage_, options_);
    find_limits();
    agree(ranks_, [&] {
      require_some();
      if (ranks_.rank != 0) return;
      keep_only_of(key_, tile_folder(path_), options_.records);
      make_folders();
    });
  }

  void write_all() {
    for (int doublings = 0;; ++doublings) {
      const TileGrid grid = reach_.grid(doublings, options_.tiles.gltf);
      bool fits = true;
      agree(ranks_, [&] { fits = try_all(grid, tiles_key_on_grid(key_, doublings)); });
      if (min_over(ranks_, std::int64_t{fits}) == 0) continue;
      for (const PlannedBlock& block : blocks_) origins_.push_back(origin_of(block, grid));
      return;
    }
  }

  // The documents, and the figures of all tiles.
  PartTiles finish() {
    PartTiles result;
    result.blocks = block_total_;
    result.resumed = sum_over(ranks_, resumed_.load());
    std::vector<BlockFigures> own;
    for (const WrittenBlock& block : written_) own.push_back(block.figures);
    const auto figures = gather<BlockFigures>(ranks_, own);
    const auto facts = gather<TileFact>(ranks_, tile_facts());
    agree(ranks_, [&] {
      if (ranks_.rank != 0) return;
      result.file = write_documents(facts);
      for (const BlockFigures& block : figures) {
        result.file.row_count += block.row_count;
        result.file.face_count += block.face_count;
      }
      result.quality = quality_of(figures, result.folded_faces);
    });
    return result;
  }

 private:
  void plan_blocks() {
    const std::int64_t size = options_.tiles.tile_vertices / 4;
    const std::int32_t owned = part_.owned_count();
    const auto block_count = static_cast<std::size_t>((owned + size - 1) / size);
    std::vector<RawVector<std::int32_t>> places(block_count);
    std::vector<TileBox> boxes(block_count);
    for (std::int32_t f = 0; f < part_.face_count(); ++f) {
      const auto named = part_.face(f);
      const std::int32_t first = part_.first_vertex(f);
      if (first >= owned || part_.is_hole(f)) continue;
      const auto b = static_cast<std::size_t>(first / size);
      const glm::dvec3& corner = part_.positions[named.front()];
      if (places[b].empty()) boxes[b] = {corner, corner};
      places[b].push_back(static_cast<std::int32_t>(first % size));
      for (const std::int32_t v : named) boxes[b].add(part_.positions[v]);
    }
    for (std::size_t b = 0; b < block_count; ++b) {
      if (places[b].empty()) continue;
      PlannedBlock& block = blocks_.emplace_back();
      block.begin = static_cast<std::int32_t>(static_cast<std::int64_t>(b) * size);
      block.end = static_cast<std::int32_t>(std::min<std::int64_t>(block.begin + size, owned));
      block.box = boxes[b];
      block.tiles = plan_of(block, std::move(places[b])).tiles;
    }
    written_.resize(blocks_.size());
  }

  // What rides on the surface goes by where that has the vertices of the faces around a vertex, and
  // around those a block does not have all faces; colours by those of the whole surface, too.
  void find_limits() {
    // Of a rank without faces too.
    const bool rides = !part_.attributes.face_uvs.empty() || !part_.attributes.colors.empty();
    if (max_over(ranks_, std::int64_t{rides}) == 0) return;
    glm::vec4 lowest(std::numeric_limits<float>::infinity()), highest(-lowest);
    const std::int32_t owned = part_.owned_count();
    agree(ranks_, [&] {
      limits_.resize(static_cast<std::size_t>(part_.vertex_count()));
      const auto size = static_cast<std::int32_t>(options_.tiles.tile_vertices / 4);
      for (std::int32_t begin = 0; begin < owned; begin += std::min(size, owned - begin)) {
        const std::int32_t end = begin + std::min(size, owned - begin);
        const SubMesh sub = maker_.make(begin, end, Rings::TwoTagged);
        if (sub.faces.empty()) continue;
        const BlockSurface block(part_, cage_, sub, options_);
        const auto limits = vertex_limits(block.surface().patches(), block.surface().state());
        for (std::size_t v = 0; v < limits.size(); ++v)
          if (sub.vertices[v] >= begin && sub.vertices[v] < end)
            limits_[sub.vertices[v]] = limits[v];
        for (const std::int32_t v : sub.mesh.face_vertices) {
          if (part_.attributes.colors.empty()) break;
          const glm::vec4& color = part_.attributes.colors[sub.vertices[v]];
          lowest = glm::min(lowest, color);
          highest = glm::max(highest, color);
        }
      }
    });
    for (int k = 0; k < 4; ++k) {
      lowest[k] = static_cast<float>(min_over(ranks_, double{lowest[k]}));
      highest[k] = static_cast<float>(max_over(ranks_, double{highest[k]}));
    }
    if (lowest.x <= highest.x) colors_ = {lowest, highest};
    const auto of_ghosts = fetch<glm::dvec3>(ranks_, part_.ghosts, part_.layout,
                                             [&](std::int64_t place) { return limits_[place]; });
    std::ranges::copy(of_ghosts, limits_.begin() + owned);
  }

  // With the block's number in the set.
  TilePlan plan_of(const PlannedBlock& block, RawVector<std::int32_t> face_places) const {
    const std::int64_t count = block.end - block.begin;
    TilePlan plan =
        plan_tiles(std::move(face_places),
                   {.place_count = count, .block_vertices = count, .level = options_.tiles.level});
    const std::int64_t number =
        (part_.layout[part_.rank] + block.begin) / (options_.tiles.tile_vertices / 4);
    for (PlannedTile& tile : plan.tiles) tile.block = static_cast<std::int32_t>(number);
    return plan;
  }

  void require_some() const {
    const std::string& name = options_.tiles.gltf.name;
    if (total_ == 0) {
      throw Error(ErrorCode::InvalidArgument,
                  name + ": the surface has no face; 3D Tiles need one");
    }
    if (total_ > std::numeric_limits<std::int32_t>::max()) {
      throw Error(
          ErrorCode::OutOfMemory,
          formatted("{}: {} tiles are more than 32 bits count; take larger ones (--tile-vertices)",
                    name, total_));
    }
  }

  void make_folders() const {
    std::error_code error;
    const auto make = [&](const fs::path& folder) {
      fs::create_directories(folder, error);
      if (error)
        throw Error(ErrorCode::UnwritableOutput,
                    folder.string() + ": cannot make the folder: " + error.message());
    };
    constexpr auto kInFolder = static_cast<std::int64_t>(kTilesInFolder);
    for (std::int64_t i = 0; i < total_; i += kInFolder)
      make(tile_folder(path_) / std::to_string(i / kInFolder));
    const std::int64_t blocks = part_.layout.back() / (options_.tiles.tile_vertices / 4) + 1;
    for (std::int64_t i = 0; i < blocks; i += kInFolder)
      make(record_path(options_.records, i).parent_path());
  }

  static glm::dvec3 origin_of(const PlannedBlock& block, const TileGrid& grid) {
    return grid.snap(block.box.centre());
  }

  // False where a tile leaves the reach of the grid. Sub meshes are made one after another, what is
  // in them side by side.
  bool try_all(const TileGrid& grid, const TilesKey& key) {
    const auto at_once =
        static_cast<std::size_t>(std::max(oneapi::tbb::this_task_arena::max_concurrency(), 1));
    std::atomic<bool> fits = true;
    resumed_ = 0;
    for (std::size_t first = 0; first < blocks_.size() && fits; first += at_once) {
      const std::size_t count = std::min(at_once, blocks_.size() - first);
      std::vector<std::optional<SubMesh>> meshes(count);
      for (std::size_t i = 0; i < count; ++i) {
        const PlannedBlock& block = blocks_[first + i];
        auto known = read_record(record_of(block), key, block.tiles.size());
        if (known && has_tiles(block)) {
          written_[first + i] = std::move(*known);
          ++resumed_;
        } else {
          meshes[i] = maker_.make(block.begin, block.end, Rings::Whole);
        }
      }
      parallel_each(count, 1, [&](std::size_t i) {
        if (meshes[i] && !write_block(first + i, *meshes[i], grid)) fits = false;
        meshes[i].reset();
        if (options_.after_block) options_.after_block();
      });
      for (std::size_t i = first; i < first + count && fits; ++i)
        write_record(record_of(blocks_[i]), key, written_[i]);
    }
    return fits;
  }

  [[nodiscard]] fs::path record_of(const PlannedBlock& block) const {
    return record_path(options_.records, block.tiles.front().block);
  }

  [[nodiscard]] fs::path path_of(const PlannedBlock& block, std::size_t tile) const {
    return tile_folder(path_) /
           tile_path(block.tiles[tile], static_cast<std::size_t>(block.first_tile) + tile);
  }

  [[nodiscard]] bool has_tiles(const PlannedBlock& block) const {
    std::error_code ignored;
    for (std::size_t t = 0; t < block.tiles.size(); ++t)
      if (!fs::exists(path_of(block, t), ignored)) return false;
    return true;
  }

  bool write_block(std::size_t index, const SubMesh& sub, const TileGrid& grid) {
    bool fits = true;
    // A thread that waits in here must not begin another block.
    oneapi::tbb::this_task_arena::isolate([&] { fits = write_levels(index, sub, grid); });
    return fits;
  }

  bool write_levels(std::size_t index, const SubMesh& sub, const TileGrid& grid) {
    const PlannedBlock& block = blocks_[index];
    const BlockSurface block_surface(part_, cage_, sub, options_, limits_, colors_);
    const DooSabinSurface& surface = block_surface.surface();
    const TilePlan plan = plan_of(block, places_of(block, sub));
    TilesOptions tiles = options_.tiles;
    tiles.given = sub.mesh.positions;
    std::vector<glm::dvec3> points;
    if (!options_.points.empty())
      for (const std::int32_t vertex : sub.vertices) points.push_back(options_.points[vertex]);
    tiles.points = points;
    WrittenBlock& written = written_[index];
    written = {std::vector<WrittenTile>(plan.tiles.size()), {}};
    for (int level = tiles.level; level >= 1; --level) {
      const DooSabinBlocks blocks(surface, level, nullptr);
      if (level == tiles.level) {
        written.figures.row_count = blocks.rows_of(sub.is_own);
        for (const std::int32_t face : plan.faces)
          written.figures.face_count += blocks.faces_of(face).count;
      }
      const TileSource source{blocks, surface.topology(), plan, grid};
      std::atomic<bool> fits = true;
      parallel_each(plan.tiles.size(), 1, [&](std::size_t t) {
        if (plan.tiles[t].level != level) return;
        const auto made = write_tile(
            source, plan.tiles[t],
            {path_of(block, t), origin_of(block, grid), written.tiles[t].record.error}, tiles);
        if (made) written.tiles[t] = *made;
        if (!made) fits = false;
      });
      if (!fits) return false;
      pass_errors_up(plan.tiles, level, written.tiles);
      if (level == 1) measure(source, sub, written.figures);
    }
    pass_boxes_up(plan.tiles, written.tiles);
    return true;
  }

  void measure(const TileSource& source, const SubMesh& sub, BlockFigures& figures) const {
    const std::vector<std::uint8_t> is_beside = folded_edges(sub.mesh, source.topology).is_beside;
    std::vector<std::int64_t> file_faces;
    for (const std::int32_t face : sub.faces) file_faces.push_back(part_.face_ids[face]);
    // The first tile of a block has all of its faces.
    const std::vector<RowRange> faces = faces_of_tile(source, source.plan.tiles.front());
    note_quality(quality_sums(source.blocks, faces, sub.mesh, is_beside), file_faces, figures);
  }

  [[nodiscard]] RawVector<std::int32_t> places_of(const PlannedBlock& block,
                                                  const SubMesh& sub) const {
    RawVector<std::int32_t> places(sub.faces.size());
    for (std::size_t f = 0; f < places.size(); ++f) {
      const std::int32_t first = part_.first_vertex(sub.faces[f]);
      places[f] = sub.is_own[f] != 0 ? first - block.begin : kInOtherBlock;
    }
    for (const std::int32_t hole : sub.mesh.hole_faces) places[hole] = -1;
    return places;
  }

  [[nodiscard]] std::vector<TileFact> tile_facts() const {
    std::vector<TileFact> facts;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      for (std::size_t t = 0; t < blocks_[b].tiles.size(); ++t) {
        TileFact fact{blocks_[b].tiles[t], written_[b].tiles[t], origins_[b]};
        if (fact.tile.parent >= 0)
          fact.tile.parent += static_cast<std::int32_t>(blocks_[b].first_tile);
        facts.push_back(fact);
      }
    }
    return facts;
  }

  TilesFile write_documents(std::span<const TileFact> facts) const {
    TilePlan plan;
    std::vector<WrittenTile> written;
    std::vector<glm::dvec3> origins(static_cast<std::size_t>(facts.back().tile.block) + 1);
    for (const TileFact& fact : facts) {
      plan.tiles.push_back(fact.tile);
      written.push_back(fact.written);
      origins[fact.tile.block] = fact.origin;
    }
    TilesFile file = sum_of_tiles(plan.tiles, written, options_.tiles.level);
    for (const TilesetText& document :
         documents_of(path_, plan, written, origins, options_.tiles)) {
      OutputFile out(document.path.empty() ? path_ : tile_folder(path_) / document.path);
      out.write(document.text);
      if (document.path.empty() && options_.tiles.gltf.observe)
        options_.tiles.gltf.observe(std::as_bytes(std::span(document.text)));
      out.commit();
      file.byte_count += document.text.size();
    }
    return file;
  }

  const Ranks& ranks_;
  const fs::path& path_;
  const MeshPart& part_;
  std::span<const glm::dvec3> cage_;
  const PartTilesOptions& options_;
  SubMeshMaker maker_;
  std::vector<PlannedBlock> blocks_;
  std::vector<WrittenBlock> written_;
  std::vector<glm::dvec3> origins_;
  std::vector<glm::dvec3> limits_;  // where anything rides: of the vertices here
  std::vector<glm::vec4> colors_;   // of all: the least and the largest numbers
  TileReach reach_;
  TilesKey key_{};
  std::int64_t total_ = 0, block_total_ = 0;
  std::atomic<std::int64_t> resumed_ = 0;
};

}  // namespace

PartTiles write_part_tiles(const Ranks& ranks, const fs::path& path, const MeshPart& part,
                           std::span<const glm::dvec3> cage, const PartTilesOptions& options) {
  PartTilesWriter writer(ranks, path, part, cage, options);
  writer.plan();
  writer.write_all();
  return writer.finish();
}

}  // namespace planish
