#include "planish/files/tiles/write_tiles.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/version.h"
#include "planish/core/visible_text.h"
#include "planish/files/tiles/curve_order.h"
#include "planish/files/tiles/tile_mesh.h"
#include "planish/files/tiles/tileset.h"
#include "planish/surface/doo_sabin_blocks.h"

namespace planish {
namespace {

namespace fs = std::filesystem;

// An estimate is no bound: finer levels were up to 1.1 times as far away on creased models.
constexpr double kErrorShare = 4.0 / 3.0;
// Of the box of the given vertices: the surface between them leaves it by less, as a rule.
constexpr double kReachShare = 1.0 + 1.0 / 16;

// The surface of a block leaves the reach of its grid.
struct OutOfReach {};

// A folder that goes with all it holds unless the set is complete.
class NewFolder {
 public:
  explicit NewFolder(fs::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    if (fs::exists(folder_, error) && !fs::is_empty(folder_, error)) {
      const fs::path folder_name = folder_;
      folder_.clear();
      throw Error(
          ErrorCode::UnwritableOutput,
          visible(folder_name) + ": exists and is not empty; tiles need a folder of their own");
    }
    make("");
  }
  ~NewFolder() {
    std::error_code ignored;
    if (!folder_.empty()) fs::remove_all(folder_, ignored);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  void make(const fs::path& inner) const {
    std::error_code error;
    const fs::path folder = inner.empty() ? folder_ : folder_ / inner;
    fs::create_directories(folder, error);
    if (error) {
      throw Error(ErrorCode::UnwritableOutput,
                  visible(folder) + ": cannot make the folder: " + error.message());
    }
  }
  void keep() { folder_.clear(); }
  [[nodiscard]] fs::path operator/(const fs::path& inner) const { return folder_ / inner; }

 private:
  fs::path folder_;
};

// The given vertices that faces name, in the surface's numbers.
std::vector<glm::dvec3> used_points(const DooSabinSurface& surface,
                                    std::span<const glm::dvec3> given) {
  std::vector<glm::dvec3> points;
  points.reserve(surface.used().vertices.size());
  for (const std::int32_t vertex : surface.used().vertices) points.push_back(given[vertex]);
  return points;
}

// A box of given vertices for each block.
std::vector<TileBox> block_boxes(const TilePlan& plan, const MeshTopology& topology,
                                 std::span<const glm::dvec3> points) {
  std::vector<TileBox> boxes(static_cast<std::size_t>(plan.block_count));
  parallel_for(plan.tiles.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const PlannedTile& tile = plan.tiles[t];
      if (tile.level > 1) continue;
      const auto faces = plan.faces_of(tile);
      const glm::dvec3 first = points[topology.face(faces.front()).front()];
      TileBox box{first, first};
      for (const std::int32_t face : faces)
        for (const std::int32_t vertex : topology.face(face)) box.add(points[vertex]);
      boxes[static_cast<std::size_t>(tile.block)] = box;
    }
  });
  return boxes;
}

double largest_of(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

class TilesWriter {
 public:
  TilesWriter(const DooSabinSurface& surface, const TilesOptions& options, const NewFolder& folder)
      : surface_(surface), options_(options), folder_(folder) {
    const std::vector<glm::dvec3> points = used_points(surface, options.given);
    // Level 1 has about four vertices for each of the mesh.
    plan_ = plan_tiles(surface.topology(), surface.hidden(), curve_order(points),
                       options.tile_vertices / 4, options.level);
    boxes_ = block_boxes(plan_, surface.topology(), points);
    for (std::size_t i = 0; i < plan_.tiles.size(); i += kTilesInFolder)
      folder.make(std::to_string(i / kTilesInFolder));
  }

  [[nodiscard]] bool is_empty() const { return plan_.tiles.empty(); }

  // Finest level first: the error of a tile shows on its children.
  void write_all() {
    double share = 1;
    while (!try_all(share * kReachShare)) share *= 2;
    // A volume holds its children's; those come behind their parents.
    for (std::size_t i = plan_.tiles.size(); i-- > 0;) {
      const std::int32_t parent = plan_.tiles[i].parent;
      if (parent >= 0) records_[static_cast<std::size_t>(parent)].box.add(records_[i].box);
    }
    warn_of(degenerate_, options_.gltf.callbacks);
  }

  [[nodiscard]] TilesFile result() const {
    TilesFile file;
    file.largest_distance = largest_distance_;
    file.row_count = row_count_;
    file.face_count = face_count_;
    for (int level = 1; level <= options_.level; ++level) {
      TileLevel& at = file.levels.emplace_back();
      at.level = level;
      for (std::size_t i = 0; i < plan_.tiles.size(); ++i) {
        if (plan_.tiles[i].level != level) continue;
        const TileRecord& record = records_[i];
        ++at.tiles;
        at.bytes += record.bytes;
        at.vertex_count += record.vertex_count;
        at.triangle_count += record.triangle_count;
        at.geometric_error = std::max(at.geometric_error, record.error);
      }
      file.byte_count += at.bytes;
    }
    return file;
  }

  [[nodiscard]] std::vector<TilesetText> documents(const TilesetOptions& options) const {
    return tileset_documents(plan_, records_, origins_, options);
  }

 private:
  bool try_all(double share) {
    records_.assign(plan_.tiles.size(), {});
    coarser_.assign(plan_.tiles.size(), 0);
    largest_distance_ = 0;
    degenerate_ = {};
    written_ = 0;
    double reach = 0, largest = 0;
    for (const TileBox& box : boxes_) {
      reach = std::max(reach, largest_of(box.half()));
      largest = std::max({largest, largest_of(box.lower), largest_of(box.upper)});
    }
    const TileGrid grid(share * reach, 2 * share * largest);
    origins_.clear();
    for (const TileBox& box : boxes_) origins_.push_back(grid.snap(box.centre()));
    try {
      for (int level = options_.level; level >= 1; --level) write_level(level, grid);
    } catch (const OutOfReach&) {
      return false;
    }
    return true;
  }

  void write_level(int level, const TileGrid& grid) {
    std::vector<std::size_t> tiles;
    for (std::size_t i = 0; i < plan_.tiles.size(); ++i)
      if (plan_.tiles[i].level == level) tiles.push_back(i);
    const DooSabinBlocks blocks(surface_, level, nullptr);
    if (level == options_.level) {
      row_count_ = blocks.info().row_count;
      face_count_ = blocks.info().face_count;
    }
    const TileSource source{blocks, surface_.topology(), plan_, grid};
    constexpr std::size_t kTilesAtOnce = 64;  // between two calls of callbacks
    const Callbacks& callbacks = options_.gltf.callbacks;
    for (std::size_t first = 0; first < tiles.size(); first += kTilesAtOnce) {
      callbacks.check_cancelled();
      const std::size_t count = std::min(kTilesAtOnce, tiles.size() - first);
      parallel_for(count, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) write_tile(source, tiles[first + i]);
      });
      written_ += count;
      callbacks.report("write",
                       static_cast<double>(written_) / static_cast<double>(plan_.tiles.size()));
    }
    for (const std::size_t tile : tiles) pass_error_up(tile);
  }

  void write_tile(const TileSource& source, std::size_t index) {
    const PlannedTile& tile = plan_.tiles[index];
    const glm::dvec3& origin = origins_[tile.block];
    TileMesh made = make_tile(source, tile, origin);
    measure(source, made, origin);
    if (tile.level > 1) coarser_[index] = kErrorShare * coarser_error(made.mesh);
    TileRecord& record = records_[index];
    const double gap = tile.level == options_.level ? coarser_[index] : record.error;
    if (options_.skirts && gap > 0) add_skirts(source, tile, gap, made);
    record.box = box_of(made.mesh);
    if (std::max(largest_of(record.box.lower), largest_of(record.box.upper)) > source.grid.reach())
      throw OutOfReach{};
    GltfOptions gltf;
    gltf.name = options_.gltf.name + " " + std::to_string(tile.block) + "-" +
                std::to_string(tile.level) + "-" + std::to_string(tile.quarter);
    gltf.double_sided = options_.gltf.double_sided;
    gltf.z_up = options_.gltf.z_up;
    gltf.extras = {{"planish", std::string(PLANISH_VERSION)}, {"level", std::int64_t{tile.level}}};
    OutputFile file(folder_ / tile_path(plan_, index));
    // A thread that waits here must not begin another tile.
    const std::vector<std::byte> bytes =
        oneapi::tbb::this_task_arena::isolate([&] { return encode_glb(made.mesh, gltf); });
    file.write(bytes);
    file.commit();
    record.bytes = bytes.size();
    record.vertex_count = made.mesh.positions.size();
    record.triangle_count = 2 * static_cast<std::uint64_t>(made.mesh.face_count());
  }

  void measure(const TileSource& source, const TileMesh& made, const glm::dvec3& origin) {
    const std::vector<std::int32_t>& base = source.blocks.info().base_vertices;
    double largest = 0;
    for (std::size_t i = 0; i < made.rows.size(); ++i) {
      const auto row = static_cast<std::size_t>(made.rows[i]);
      if (row >= base.size()) break;  // rows ascend
      const glm::dvec3 read = origin + glm::dvec3(glm::vec3(made.mesh.positions[i]));
      const double distance = glm::length(read - options_.given[base[row]]);
      largest = std::max(
          largest, std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity());
    }
    const std::lock_guard lock(mutex_);
    largest_distance_ = std::max(largest_distance_, largest);
    // Those of a finer level are others, and its own once more.
    if (source.blocks.info().level == options_.level) degenerate_.add(made.degenerate);
  }

  // An error is no smaller than those of children.
  void pass_error_up(std::size_t tile) {
    const std::int32_t parent = plan_.tiles[tile].parent;
    if (parent < 0) return;
    TileRecord& above = records_[static_cast<std::size_t>(parent)];
    above.error = std::max({above.error, coarser_[tile], records_[tile].error});
  }

  const DooSabinSurface& surface_;
  const TilesOptions& options_;
  const NewFolder& folder_;
  TilePlan plan_;
  std::vector<TileBox> boxes_;       // of the given vertices of each block
  std::vector<glm::dvec3> origins_;  // of each block
  std::vector<TileRecord> records_;
  std::vector<double> coarser_;  // of each tile: the error of the level before in its place
  std::size_t written_ = 0;
  std::int64_t row_count_ = 0, face_count_ = 0;
  std::mutex mutex_;
  double largest_distance_ = 0;
  DegenerateRows degenerate_;
};

void require_options(const DooSabinSurface& surface, const TilesOptions& options) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, options.gltf.name + ": " + what);
  };
  if (options.level < 1) refuse("3D Tiles have levels from 1 on");
  if (options.tile_vertices < kLeastTileVertices) {
    refuse("tiles of " + std::to_string(options.tile_vertices) + " vertices; " +
           std::to_string(kLeastTileVertices) + " are the least");
  }
  if (options.gltf.compression != GltfCompression::None)
    refuse("compressed tiles would not meet; take none");
  // Four corners a face are numbered by int32.
  const double faces = std::ldexp(surface.topology().corner_count(), 2 * (options.level - 1));
  if (4 * faces > std::numeric_limits<std::int32_t>::max()) {
    throw Error(ErrorCode::OutOfMemory,
                options.gltf.name + ": level " + std::to_string(options.level) +
                    " has more corners than 32-bit indices reach; take fewer levels");
  }
}

std::string extras_of(const GltfOptions& options) {
  nlohmann::json json;
  for (const auto& [key, value] : options.extras)
    std::visit([&, &name = key](const auto& held) { json[name] = held; }, value);
  return json.is_null() ? "" : json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

fs::path tile_folder(const fs::path& document) { return fs::path(document).replace_extension(); }

TilesFile write_tiles(const fs::path& path, const DooSabinSurface& surface,
                      const TilesOptions& options) {
  require_options(surface, options);
  NewFolder folder(tile_folder(path));
  TilesWriter writer(surface, options, folder);
  if (writer.is_empty())
    throw Error(ErrorCode::InvalidArgument,
                options.gltf.name + ": the surface has no face; 3D Tiles need one");
  writer.write_all();
  TilesFile written = writer.result();
  for (const TilesetText& document :
       writer.documents({.folder = tile_folder(path).filename().string(),
       .z_up = options.gltf.z_up,
       .extras = extras_of(options.gltf)})) {
    const bool is_group = !document.path.empty();
    OutputFile file(is_group ? folder / document.path : path);
    file.write(document.text);
    if (!is_group && options.gltf.observe)
      options.gltf.observe(std::as_bytes(std::span(document.text)));
    // The document comes last, when all that it names is there.
    file.commit();
    written.byte_count += document.text.size();
  }
  folder.keep();
  return written;
}

}  // namespace planish
