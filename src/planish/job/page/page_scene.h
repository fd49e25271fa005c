#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/core/json.h"
#include "planish/job/page/page_order.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// How a map is coloured.
enum class FieldKind { Amount, Signed, Share };

/// A figure of every vertex, as a page shows it.
struct PageField {
  std::string name;   ///< for scripts and links
  std::string label;  ///< for people
  std::string unit;
  FieldKind kind = FieldKind::Amount;
  std::vector<float> values;     ///< in page order
  double limit = 1;              ///< what is stored of the values: up to here, by magnitude
  double largest = 0, most = 0;  ///< by magnitude; most: of 99 % of the vertices
};

/// A place to look at: part of the surface that is folded.
struct PageFold {
  glm::dvec3 position, direction;  ///< direction: away from the face that the surface should follow
  double size = 0;                 ///< of the mesh there
  double area = 0;                 ///< share of the surface's area
  std::int32_t face = 0;           ///< the mesh's
};

/// What a page draws of one job, in page order.
struct PageScene {
  PageOrder order;
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
  /// Texture coordinates in an order of their own; empty: not every corner has one.
  std::vector<glm::dvec2> uvs;
  PageOrder uv_order;
  std::vector<PageField> fields;
  std::vector<PageFold> folds;
  std::size_t folded_faces = 0;  ///< of which `folds` names the largest
  PolygonMesh cage;
  /// Vertices of the mesh in the numbering of its file.
  std::vector<std::int32_t> file_vertices;
  /// The given points of level 0 where the surface misses them by more than a page can show.
  std::vector<glm::dvec3> given;
  double diagonal = 1;
  std::int32_t worst = -1;  ///< the page's vertex that is farthest off
};

struct PageSceneInput {
  const SurfaceMesh& surface;
  const PolygonMesh& mesh;
  const PolygonMesh& cage;
  std::span<const std::int32_t> file_vertices;  ///< of the mesh's vertices; empty: the same
  double diagonal = 1;
  std::int64_t worst_vertex = -1;          ///< of the mesh
  const DooSabinSurface* exact = nullptr;  ///< what was tessellated, for curvature
};

/// Throws Error{InvalidArgument} for positions, normals and control points that are not finite.
[[nodiscard]] PageScene make_page_scene(const PageSceneInput& input);

/// A job's scene as it stands in a page, down to one of its levels.
struct PagePayload {
  int level = 0;
  nlohmann::ordered_json head;  ///< what the viewer must know beside the numbers
  std::string packed;           ///< base64
};

[[nodiscard]] PagePayload encode_scene(const PageScene& scene, int level);

}  // namespace planish
