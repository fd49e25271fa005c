#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "planish/core/json.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// A tile of a set as a viewer meets it, with all transforms applied: in the frame of tiles, Z up.
struct ReadTile {
  int parent = -1;  ///< in the same list
  glm::dvec3 lower{0.0}, upper{0.0};
  double error = 0;
  glm::dvec3 origin{0.0};
  std::filesystem::path content;  ///< a .glb; empty: none
  int level = 0;                  ///< by the file's name; 0: no content

  [[nodiscard]] bool holds(const ReadTile& other) const;
};

struct ReadTileset {
  std::vector<nlohmann::json> documents;  ///< the set's own first
  std::vector<ReadTile> tiles;            ///< parents before children
};

[[nodiscard]] ReadTileset read_tileset(const std::filesystem::path& document);

/// The triangles of all tiles of a level, corners at equal places joined.
[[nodiscard]] PolygonMesh welded(const ReadTileset& set, int level);

/// A tile's triangles, corners not joined, in the frame of tiles; texture coordinates, if any, by
/// vertex.
[[nodiscard]] PolygonMesh triangles_of(const ReadTile& tile);

}  // namespace planish::test
