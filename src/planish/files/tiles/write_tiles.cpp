#include "planish/files/tiles/write_tiles.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/materials.h"
#include "planish/files/mesh_file.h"
#include "planish/files/tiles/tile.h"
#include "planish/surface/doo_sabin_blocks.h"

namespace planish {
namespace {

// Based on: Open Geospatial Consortium, "3D Tiles Specification 1.1", OGC 22-025r4, 2023.

using nlohmann::ordered_json;

// A model's frame as that of tiles, Z up. Viewers turn the content of tiles, glTF, from Y up: what
// stands in the file as (x, y, z) they show at (x, -z, y).
struct TileFrame {
  bool z_up;

  [[nodiscard]] glm::dvec3 point(const glm::dvec3& p) const {
    // Adding zero turns -0 into 0.
    return (z_up ? p : glm::dvec3(p.x, -p.z, p.y)) + glm::dvec3(0.0);
  }
  [[nodiscard]] glm::dvec3 size(const glm::dvec3& p) const {
    return z_up ? p : glm::dvec3(p.x, p.z, p.y);
  }
};

class TilesetWriter {
 public:
  TilesetWriter(const TilePlan& plan, std::span<const TileRecord> tiles,
                std::span<const glm::dvec3> origins, const TilesetOptions& options)
      : plan_(plan), tiles_(tiles), origins_(origins), options_(options), frame_{options.z_up} {
    children_.resize(plan.tiles.size());
    for (std::size_t i = 0; i < plan.tiles.size(); ++i) {
      const std::int32_t parent = plan.tiles[i].parent;
      (parent < 0 ? blocks_ : children_[parent]).push_back(i);
    }
  }

  std::vector<TilesetText> documents() const {
    std::vector<TilesetText> documents;
    if (blocks_.size() <= kBlocksInDocument) {
      documents.push_back({"", text_of(node_of(blocks_, encode_uri(options_.folder) + "/"))});
      return documents;
    }
    Node root;
    for (std::size_t first = 0; first < blocks_.size(); first += kBlocksInDocument) {
      const std::size_t count = std::min(kBlocksInDocument, blocks_.size() - first);
      const Node group = node_of(std::span(blocks_).subspan(first, count), "");
      const std::string path = formatted("group-{}.json", first / kBlocksInDocument);
      documents.push_back({path, text_of(group)});
      // A tile that names a document may have no children.
      ordered_json link{{"boundingVolume", volume_of(group.box)}, {"geometricError", group.error}};
      link["content"] = {{"uri", encode_uri(options_.folder) + "/" + path}};
      root.add(group.box, group.error, std::move(link));
    }
    root.finish();
    documents.push_back({"", text_of(root)});
    return documents;
  }

 private:
  // A tile without content.
  struct Node {
    TileBox box;
    double error = 0;
    ordered_json children = ordered_json::array();

    void add(const TileBox& child, double child_error, ordered_json&& made) {
      if (children.empty()) box = child;
      box.add(child);
      error = std::max(error, child_error);
      children.push_back(std::move(made));
    }
    // Nothing at all is as wrong as the model is large.
    void finish() { error = std::max(error, 2 * glm::length(box.half())); }
  };

  [[nodiscard]] Node node_of(std::span<const std::size_t> blocks, const std::string& folder) const {
    Node node;
    for (const std::size_t tile : blocks) {
      const glm::dvec3& origin = origins_[plan_.tiles[tile].block];
      ordered_json made = tile_json(tile, folder);
      const glm::dvec3 at = frame_.point(origin);
      made["transform"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, at.x, at.y, at.z, 1};
      const TileBox box{tiles_[tile].box.lower + origin, tiles_[tile].box.upper + origin};
      node.add(box, tiles_[tile].error, std::move(made));
    }
    node.finish();
    return node;
  }

  [[nodiscard]] ordered_json tile_json(std::size_t tile, const std::string& folder) const {
    ordered_json made{{"boundingVolume", volume_of(tiles_[tile].box)},
                      {"geometricError", tiles_[tile].error}};
    made["content"] = {{"uri", folder + tile_path(plan_.tiles[tile], tile)}};
    for (const std::size_t child : children_[tile])
      made["children"].push_back(tile_json(child, folder));
    return made;
  }

  [[nodiscard]] ordered_json volume_of(const TileBox& box) const {
    const glm::dvec3 centre = frame_.point(box.centre()), half = frame_.size(box.half());
    return {{"box", {centre.x, centre.y, centre.z, half.x, 0, 0, 0, half.y, 0, 0, 0, half.z}}};
  }

  [[nodiscard]] std::string text_of(const Node& node) const {
    ordered_json made;
    made["asset"] = {{"version", "1.1"}};
    if (!options_.extras.empty()) made["asset"]["extras"] = ordered_json::parse(options_.extras);
    made["geometricError"] = node.error;
    made["root"] = {{"boundingVolume", volume_of(node.box)},
                    {"geometricError", node.error},
                    {"refine", "REPLACE"},
                    {"children", node.children}};
    return made.dump() + "\n";
  }

  const TilePlan& plan_;
  std::span<const TileRecord> tiles_;
  std::span<const glm::dvec3> origins_;
  const TilesetOptions& options_;
  TileFrame frame_;
  std::vector<std::size_t> blocks_;                 // their tiles of level 1
  std::vector<std::vector<std::size_t>> children_;  // by tile
};

// Takes a number off the front; false where there is none.
bool take_number(std::string_view& text) {
  const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  text.remove_prefix(digits);
  return digits > 0;
}

bool take(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

}  // namespace

std::string tile_name(const PlannedTile& tile) {
  return formatted("{}-{}-{}", tile.block, tile.level, tile.quarter);
}

std::string tile_path(const PlannedTile& tile, std::size_t index) {
  return formatted("{}/{}.glb", index / kTilesInFolder, tile_name(tile));
}

bool is_tileset_entry(std::string_view name) {
  if (name == kImageFolder) return true;
  const bool is_document = take(name, "group-");
  return take_number(name) && (!is_document || take(name, ".json")) && name.empty();
}

bool is_tile_name(std::string_view name) {
  return take_number(name) && take(name, "-") && take_number(name) && take(name, "-") &&
         take_number(name) && name == ".glb";
}

bool is_image_name(std::string_view name) {
  return take_number(name) && take(name, ".") && !name.empty() &&
         std::ranges::all_of(
             name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; });
}

std::filesystem::path foreign_in_tiles(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (!is_tileset_entry(utf8(entry.path().filename()))) return entry.path();
    if (entry.is_symlink(error)) return entry.path();
    if (!entry.is_directory(error)) continue;
    const auto is_known = entry.path().filename() == kImageFolder ? is_image_name : is_tile_name;
    for (const fs::directory_entry& file : fs::directory_iterator(entry.path(), error))
      if (!is_known(utf8(file.path().filename()))) return file.path();
  }
  return {};
}

std::vector<TilesetText> tileset_documents(const TilePlan& plan, std::span<const TileRecord> tiles,
                                           std::span<const glm::dvec3> origins,
                                           const TilesetOptions& options) {
  return TilesetWriter(plan, tiles, origins, options).documents();
}

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
