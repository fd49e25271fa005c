#include "planish/files/tiles/write_tiles.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/gltf_materials.h"
#include "planish/files/input_files.h"
#include "planish/files/tiles/curve_order.h"
#include "planish/files/tiles/tile_mesh.h"
#include "planish/files/tiles/tileset.h"
#include "planish/files/tiles/write_tile.h"
#include "planish/surface/doo_sabin_blocks.h"

namespace planish {
namespace {

namespace fs = std::filesystem;

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

// The given vertices that faces name, in the surface's numbers, along the curve through all given
// ones: those without faces keep their places in it, so that blocks do not depend on faces.
TilePlan plan_of(const DooSabinSurface& surface, const TilesOptions& options) {
  const RawVector<std::int32_t> order = curve_order(options.given);
  RawVector<std::int32_t> place_of_given(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    place_of_given[order[i]] = static_cast<std::int32_t>(i);
  const auto used = surface.used().vertices;
  RawVector<std::int32_t> places(used.size());
  for (std::size_t v = 0; v < used.size(); ++v) places[v] = place_of_given[used[v]];
  return plan_tiles(surface.topology(), surface.hidden(), places,
                    {.place_count = static_cast<std::int64_t>(order.size()),
                     // Level 1 has about four vertices for each of the mesh.
                     .block_vertices = options.tile_vertices / 4,
                     .level = options.level});
}

// Once for all tiles.
std::uint64_t write_images(const GltfMaterials& materials, const NewFolder& folder) {
  if (materials.images.empty()) return 0;
  folder.make(kImageFolder);
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < materials.images.size(); ++i) {
    OutputFile file(folder / kImageFolder / materials.image_name(i));
    file.write(materials.images[i].bytes);
    file.commit();
    bytes += materials.images[i].bytes.size();
  }
  return bytes;
}

class TilesWriter {
 public:
  TilesWriter(const DooSabinSurface& surface, const TilesOptions& options, const NewFolder& folder)
      : surface_(surface), options_(options), folder_(folder), plan_(plan_of(surface, options)) {
    boxes_.resize(static_cast<std::size_t>(plan_.block_count));
    const auto used = surface.used().vertices;
    parallel_each(plan_.tiles.size(), 1, [&](std::size_t t) {
      const PlannedTile& tile = plan_.tiles[t];
      if (tile.level > 1) return;
      boxes_[tile.block] = box_of_faces(
          surface.topology(), plan_.faces_of(tile),
          [&](std::int32_t vertex) -> const glm::dvec3& { return options.given[used[vertex]]; });
    });
    for (std::size_t i = 0; i < plan_.tiles.size(); i += kTilesInFolder)
      folder.make(std::to_string(i / kTilesInFolder));
  }

  [[nodiscard]] bool is_empty() const { return plan_.tiles.empty(); }

  void write_all() {
    RoundParts rounds(options_.gltf.callbacks, 0.9);  // mostly there is one
    int doublings = 0;
    while (!try_all(doublings, rounds.next())) ++doublings;
    pass_boxes_up(plan_.tiles, tiles_);
  }

  [[nodiscard]] TilesFile result() const {
    TilesFile file = sum_of_tiles(plan_.tiles, tiles_, options_.level);
    file.row_count = row_count_;
    file.face_count = face_count_;
    return file;
  }

  [[nodiscard]] std::vector<TilesetText> documents(const fs::path& path) const {
    return documents_of(path, plan_, tiles_, origins_, options_);
  }

 private:
  // Finest level first: the error of a tile shows on its children.
  bool try_all(int doublings, const Callbacks& callbacks) {
    tiles_.assign(plan_.tiles.size(), {});
    LoopProgress progress(callbacks, "write", 0, 1, std::ssize(plan_.tiles));
    TileReach reach;
    for (const TileBox& box : boxes_) reach.add(box);
    const TileGrid grid = reach.grid(doublings, options_.gltf);
    origins_.clear();
    for (const TileBox& box : boxes_) origins_.push_back(grid.snap(box.centre()));
    for (int level = options_.level; level >= 1; --level)
      if (!write_level(level, grid, progress)) return false;
    return true;
  }

  // False where a tile leaves the reach of the grid.
  bool write_level(int level, const TileGrid& grid, LoopProgress& progress) {
    std::vector<std::size_t> tiles;
    for (std::size_t i = 0; i < plan_.tiles.size(); ++i)
      if (plan_.tiles[i].level == level) tiles.push_back(i);
    const DooSabinBlocks blocks(surface_, level, nullptr);
    if (level == options_.level) {
      row_count_ = blocks.info().row_count;
      face_count_ = blocks.info().face_count;
    }
    const TileSource source{blocks, surface_.topology(), plan_, grid};
    std::atomic<bool> fits = true;
    parallel_for(tiles.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && fits; ++i) {
        if (!write_one_tile(source, tiles[i])) fits = false;
        progress.add();
      }
    });
    if (!fits) return false;
    pass_errors_up(plan_.tiles, level, tiles_);
    return true;
  }

  bool write_one_tile(const TileSource& source, std::size_t index) {
    const PlannedTile& tile = plan_.tiles[index];
    const std::optional<WrittenTile> written = write_tile(
        source, tile,
        {folder_ / tile_path(tile, index), origins_[tile.block], tiles_[index].record.error},
        options_);
    if (written) tiles_[index] = *written;
    return written.has_value();
  }

  const DooSabinSurface& surface_;
  const TilesOptions& options_;
  const NewFolder& folder_;
  TilePlan plan_;
  std::vector<TileBox> boxes_;       // of the given vertices of each block
  std::vector<glm::dvec3> origins_;  // of each block
  std::vector<WrittenTile> tiles_;
  std::int64_t row_count_ = 0, face_count_ = 0;
};

void require_options(const DooSabinSurface& surface, const TilesOptions& options) {
  require_tiles_options(options);
  // Four corners a face are numbered by int32.
  const double faces = std::ldexp(surface.topology().corner_count(), 2 * (options.level - 1));
  if (4 * faces > std::numeric_limits<std::int32_t>::max()) {
    throw Error(
        ErrorCode::OutOfMemory,
        formatted("{}: level {} has more corners than 32-bit indices reach; take fewer levels",
                  options.gltf.name, options.level));
  }
}

}  // namespace

fs::path tile_folder(const fs::path& document) { return fs::path(document).replace_extension(); }

TilesFile write_tiles(const fs::path& path, const DooSabinSurface& surface,
                      const TilesOptions& options) {
  require_options(surface, options);
  if (options.gltf.materials != nullptr)
    require_apart(options.gltf.materials->input, path, FileFormat::Tiles);
  const HostScope host(options.gltf.callbacks);
  NewFolder folder(tile_folder(path));
  TilesWriter writer(surface, options, folder);
  if (writer.is_empty())
    throw Error(ErrorCode::InvalidArgument,
                options.gltf.name + ": the surface has no face; 3D Tiles need one");
  writer.write_all();
  TilesFile written = writer.result();
  if (options.gltf.materials != nullptr)
    written.byte_count += write_images(*options.gltf.materials, folder);
  warn_of(written.degenerate, options.gltf.callbacks);
  for (const TilesetText& document : writer.documents(path)) {
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
  options.gltf.callbacks.report("write", 1);
  return written;
}

}  // namespace planish
