#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/core/json.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// One split of a page's surface: what its new vertices lie between, in their order.
struct PageSplit {
  /// Edges of the coarser level whose point is their own on this face's side although another face
  /// has an edge between the same vertices: a lone crease, whose two sides have their own normals.
  /// Places in the list of all corners, each the first of its edge; ascending.
  std::vector<std::int32_t> cuts;
  std::vector<std::int32_t> parent_offsets{0};  ///< one more than there are new vertices
  std::vector<std::int32_t> parents;            ///< vertices of the coarser level
};

/// The vertices of a tessellation in the order of a page, which stores no index above level 0: the
/// mesh's own vertices, their copies along sharp edges, then for each level one vertex a face and
/// one an edge, in the order in which a walk over the coarser level's faces meets them (with
/// triangles only the edges). A level's vertices are the first ones of the next.
struct PageOrder {
  std::vector<std::int32_t> rows;     ///< of each page vertex: its place in the surface
  std::vector<std::int32_t> sources;  ///< of each vertex of level 0: the mesh's vertex
  LevelFaces faces;                   ///< of level 0, in page vertices
  std::vector<PageSplit> splits;      ///< one for each level from 1 on
  std::vector<std::size_t> counts;    ///< vertices of each level
  bool triangles = false;             ///< of Loop
};

/// The order of a surface that was refined from `mesh`.
[[nodiscard]] PageOrder page_order(const SurfaceMesh& surface, const PolygonMesh& mesh);

/// The same of its texture coordinates, which every corner has: `rows` are places among them, and
/// seams are where sharp edges are else.
[[nodiscard]] PageOrder texture_order(const SurfaceMesh& surface, const PolygonMesh& mesh);

/// Numbers on their way into a page: whole numbers less what is expected of them, by bytes of equal
/// weight, deflated. Nothing but subtraction and a table is needed to read it, see viewer/data.js.
///
/// A section of `count` vectors of `components` numbers of `width` bytes holds for each component,
/// for each byte from the lowest, that byte of all numbers. A number is the difference from what is
/// expected, zigzagged: 0, -1, 1, -2, ... as 0, 1, 2, 3, ..., modulo 2^(8 width).
class PageCoder {
 public:
  /// Expected is the number before.
  void add_list(const std::string& name, std::span<const std::int32_t> values);
  /// `values`: one vector a vertex, unsigned and below 2^(8 width). Expected is the mean of the
  /// parents, rounded to nearest, halves up; on level 0 the value before. Vertices that `order` has
  /// more of are left out.
  void add_values(const std::string& name, std::span<const std::uint16_t> values, int width,
                  int components, const PageOrder& order);

  /// Where everything lies in the bytes: [{"name", "count", "width", "components", "offset"}, ...].
  [[nodiscard]] const nlohmann::ordered_json& sections() const { return sections_; }
  /// All sections as one raw deflate stream in base64.
  [[nodiscard]] std::string base64() const;

 private:
  void begin(const std::string& name, std::size_t count, int width, int components);
  void put(std::size_t plane, std::size_t count, std::size_t i, int width, std::int64_t difference);

  std::vector<std::uint8_t> bytes_;
  nlohmann::ordered_json sections_ = nlohmann::ordered_json::array();
};

/// Bytes in base64, padded.
[[nodiscard]] std::string base64_text(std::span<const std::uint8_t> bytes);

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
