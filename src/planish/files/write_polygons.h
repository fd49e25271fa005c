#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/formats.h"
#include "planish/measure/vertex_fields.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// How a format that knows subdivision surfaces (USD) is to draw a cage.
struct CageSubdivision {
  std::string_view scheme = "none";  ///< "catmullClark", "loop"; "none" draws the polygons
  bool has_sharp_boundary_corners = false;
};

/// USD's word for what its boundary is.
[[nodiscard]] inline std::string_view boundary_of(const CageSubdivision& subdivision) {
  return subdivision.has_sharp_boundary_corners ? "edgeAndCorner" : "edgeOnly";
}

/// As files have it: what is infinite is as sharp as everything from 10 on.
[[nodiscard]] inline float written_sharpness(float sharpness) {
  return std::isfinite(sharpness) ? sharpness : kInfiniteSharpness;
}

/// Gets the bytes of a file in order while they are written: for a digest.
using ByteObserver = std::function<void(std::span<const std::byte>)>;

/// What the writers see of a polygon mesh or a tessellated surface.
struct PolygonView {
  std::span<const glm::dvec3> positions;
  std::span<const glm::vec3> normals;          ///< empty, or one per position
  std::span<const std::int32_t> face_offsets;  ///< empty: every face has four corners
  std::span<const std::int32_t> face_vertices;
  std::span<const CreaseEdge> creases;
  std::span<const CornerVertex> corners;
  std::span<const glm::dvec2> uvs;
  std::span<const std::int32_t> face_uvs;  ///< empty, or one per corner; -1: none there
  std::span<const glm::vec4> colors;       ///< empty, or one per position; linear RGBA
  std::span<const FaceGroup> groups;
  std::span<const std::int32_t> face_groups;  ///< empty, or one per face
  std::span<const std::int32_t> hole_faces;
  std::span<const NamedField> fields;   ///< one value per position each; PLY and USD only
  CageSubdivision subdivision;          ///< USD only
  bool is_z_up = false;                 ///< USD only, which says so
  std::span<const std::string> header;  ///< comment lines, without the comment sign

  [[nodiscard]] std::size_t face_count() const {
    return face_offsets.empty() ? face_vertices.size() / 4 : face_offsets.size() - 1;
  }
  [[nodiscard]] std::span<const std::int32_t> face(std::size_t index) const {
    if (face_offsets.empty()) return face_vertices.subspan(4 * index, 4);
    return face_vertices.subspan(face_offsets[index],
                                 face_offsets[index + 1] - face_offsets[index]);
  }
};

/// What is known of a file of polygons before any of them is made.
struct PolygonTotals {
  std::int64_t row_count = 0, uv_count = 0, face_count = 0, corner_count = 0;
  std::size_t largest_face = 0;
  bool has_normals = false, has_colors = false, has_uvs = false, has_groups = false;
  std::vector<std::string> materials;  ///< without repetitions, in the order of the groups
};

/// The materials that groups name.
[[nodiscard]] std::vector<std::string> materials_of(std::span<const FaceGroup> groups);

/// Parts of a file, in their order. A format has some of them, each vertex and face for itself, so
/// that pieces of a part are made on several threads.
enum class PolygonPart : std::uint8_t {
  Head,       ///< the view holds what belongs to no vertex or face alone: header, names of fields
  Positions,  ///< with colours
  Vertices,   ///< all of them
  Uvs,
  Normals,
  Faces,
  Tail,       ///< creases, corners, holes
  Colors,     ///< of all vertices, alone
  Fields,     ///< likewise
  Triangles,  ///< that faces are cut into, as glTF has them: the view has three positions each
};

/// Some of a part.
struct PolygonPiece {
  PolygonPart part = PolygonPart::Head;
  const PolygonTotals& totals;
  PolygonView view;  ///< of the piece, offsets from its own first corner
  FaceGroup before;  ///< that of the face before the first
};

/// Polygons that are written, in pieces that any thread may ask for.
class PolygonSource {
 public:
  virtual ~PolygonSource() = default;
  [[nodiscard]] virtual const PolygonTotals& totals() const = 0;
  /// Head and Tail have one range.
  [[nodiscard]] virtual std::vector<RowRange> ranges(PolygonPart part) const = 0;
  /// Called before a part is visited, by one thread.
  virtual void prepare(PolygonPart /*part*/) const {}
  /// Calls use(piece) with a range of a part.
  virtual void visit(PolygonPart part, RowRange range,
                     const std::function<void(const PolygonPiece&)>& use) const = 0;
  /// Called when all is written and nothing is in place yet: where it throws, there is no file.
  virtual void finish() const {}
};

class MaterialLibrary;
struct GltfMaterials;
struct UsdMaterials;

/// Materials that a file has from another; null: none.
struct GivenMaterials {
  const MaterialLibrary* library = nullptr;  ///< of OBJ
  std::filesystem::path folder;              ///< where the file will stand
  const GltfMaterials* gltf = nullptr;       ///< of USD, that write_surface() makes `usd` of
  const UsdMaterials* usd = nullptr;
};

/// Writes the polygons through OutputFile as the format's own writer does (writers.h,
/// writers.h, writers.h), formatted on all threads; the same bytes whatever their
/// number. `observe`, if any, gets all bytes in order. Returns their number. OBJ with materials
/// gets an .mtl beside it (obj/material_library.h), put in place before it when both are written.
/// Throws Error{UnwritableOutput}; Error{InvalidArgument} for formats that are not written, for
/// indices and counts that do not fit each other, faces of fewer than 3 corners, numbers that are
/// not finite and header lines that hold a line break.
std::uint64_t write_polygons(const std::filesystem::path& path, FileFormat format,
                             const PolygonView& view, const ByteObserver& observe = {},
                             const GivenMaterials& materials = {});
/// The same of polygons that are made as they are written.
std::uint64_t write_polygons(const std::filesystem::path& path, FileFormat format,
                             const PolygonSource& source, std::span<const std::string> header,
                             const ByteObserver& observe = {},
                             const GivenMaterials& materials = {});

}  // namespace planish
