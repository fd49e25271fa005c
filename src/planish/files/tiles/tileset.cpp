// Based on: Open Geospatial Consortium, "3D Tiles Specification 1.1", OGC 22-025r4, 2023.
#include "planish/files/tiles/tileset.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/files/gltf/gltf_document.h"

namespace planish {
namespace {

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
    if (!is_tileset_entry(entry.path().filename().string())) return entry.path();
    if (entry.is_symlink(error)) return entry.path();
    if (!entry.is_directory(error)) continue;
    const auto is_known = entry.path().filename() == kImageFolder ? is_image_name : is_tile_name;
    for (const fs::directory_entry& file : fs::directory_iterator(entry.path(), error))
      if (!is_known(file.path().filename().string())) return file.path();
  }
  return {};
}

std::vector<TilesetText> tileset_documents(const TilePlan& plan, std::span<const TileRecord> tiles,
                                           std::span<const glm::dvec3> origins,
                                           const TilesetOptions& options) {
  return TilesetWriter(plan, tiles, origins, options).documents();
}

}  // namespace planish
