// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.7 (meshes) and 4 (GLB).
#include "planish/files/gltf/read_gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/files/gltf/glb_parts.h"
#include "planish/files/gltf/gltf_accessor.h"
#include "planish/files/gltf/gltf_nodes.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/json_place.h"
#include "planish/files/shared/attribute_collector.h"
#include "planish/files/shared/weld.h"

namespace planish {
namespace {

// A few bytes of nodes can place any number of triangles; more than these could not be handled by
// what follows anyway.
constexpr std::int64_t kMaxCorners = std::int64_t{1} << 28;
constexpr std::int64_t kMaxPrimitives = std::int64_t{1} << 20;

// Extensions that change nothing about the triangles, or are read; any other that a file requires
// is refused.
constexpr std::array<std::string_view, 6> kHarmlessExtensions = {
    "KHR_materials_", "KHR_texture_",          "EXT_texture_",
    "KHR_lights_",    "KHR_mesh_quantization", "EXT_meshopt_compression"};

bool is_finite(const glm::dvec3& position) {
  return std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z);
}

class SceneReader {
 public:
  SceneReader(JsonPlace root, GltfSource& source) : root_(std::move(root)), source_(source) {}

  MeshFile read(FileFormat format) {
    require_version();
    for (const GltfInstance& instance : gltf_instances(root_)) read_instance(instance);
    file_.format = format;
    triangles_.finish(welder_, file_);
    if (file_.mesh.face_count() == 0 && !points_.empty()) {
      file_.mesh.positions = std::move(points_);
    } else {
      file_.dropped_element_count += point_primitive_count_;
    }
    attributes_.finish(std::move(uvs_), file_.mesh);
    if (deformed_count_ > 0)
      file_.warnings.push_back({.code = "ignored-deformation",
                                .message = "skins and morph targets are ignored; the shape at "
                                           "rest is read",
                                .count = deformed_count_});
    return std::move(file_);
  }

 private:
  void require_version();
  void read_instance(const GltfInstance& instance);
  void read_primitive(const JsonPlace& primitive, const GltfInstance& instance);
  void read_point_primitive(const JsonPlace& primitive, const GltfInstance& instance);
  void read_attributes(const JsonPlace& primitive, std::int64_t vertex_count);
  void color_vertices(const JsonPlace& attribute, const std::vector<std::int32_t>& vertices,
                      const std::vector<std::int32_t>& corners);
  void add_triangles(const JsonPlace& primitive, std::int64_t mode,
                     const std::vector<std::int32_t>& vertices,
                     const std::vector<std::int32_t>& corners, bool mirrored);
  std::int32_t welded(const GltfAccessor& positions, std::int64_t vertex,
                      const JsonPlace& primitive, const GltfInstance& instance);

  JsonPlace root_;
  GltfSource& source_;
  Welder welder_;
  TriangleCollector triangles_;
  AttributeCollector attributes_;
  std::vector<glm::dvec3> points_;  // of primitives of points
  std::vector<glm::dvec2> uvs_;
  std::int64_t first_uv_ = -1;  // of the current primitive; -1: it has none
  MeshFile file_;
  std::int64_t deformed_count_ = 0, point_primitive_count_ = 0, primitive_count_ = 0,
               corner_count_ = 0;
  // By vertex of the current primitive: its welded vertex, valid where the stamp is the current.
  std::vector<std::int32_t> welded_vertices_;
  std::vector<std::int64_t> stamps_;
  std::int64_t stamp_ = 0;
};

void SceneReader::require_version() {
  const JsonPlace version = root_["asset"]["version"];
  if (!version.text().starts_with("2.")) version.fail(quote(version.text()) + " is not 2.x");
  const auto required = root_.find("extensionsRequired");
  for (std::int64_t i = 0; required && i < required->array_size(); ++i) {
    const std::string& extension = (*required)[i].text();
    const bool harmless = std::ranges::any_of(
        kHarmlessExtensions, [&](std::string_view known) { return extension.starts_with(known); });
    if (!harmless)
      (*required)[i].fail(quote(extension) + " cannot be read; save the file without it");
  }
}

void SceneReader::read_instance(const GltfInstance& instance) {
  const JsonPlace mesh = root_["meshes"][instance.mesh];
  if (root_["nodes"][instance.node].find("skin")) ++deformed_count_;
  const JsonPlace primitives = mesh["primitives"];
  for (std::int64_t i = 0; i < primitives.array_size(); ++i) {
    if (++primitive_count_ > kMaxPrimitives)
      primitives.fail("the scene places more than " + std::to_string(kMaxPrimitives) +
                      " primitives");
    read_primitive(primitives[i], instance);
  }
}

void SceneReader::read_primitive(const JsonPlace& primitive, const GltfInstance& instance) {
  constexpr std::int64_t kPoints = 0, kTriangles = 4, kFan = 6;
  const std::int64_t mode = primitive.integer_or("mode", kTriangles);
  if (mode > kFan) primitive["mode"].fail(std::to_string(mode) + " is no mode of primitives");
  const auto position = primitive["attributes"].find("POSITION");
  if (mode == kPoints && position) return read_point_primitive(primitive, instance);
  if (mode < kTriangles || !position) {
    ++file_.dropped_element_count;
    return;
  }
  if (primitive.find("targets")) ++deformed_count_;
  const GltfAccessor positions(root_, position->integer(), GltfAccessor::Use::Positions, source_);
  std::optional<GltfAccessor> indices;
  if (const auto place = primitive.find("indices"))
    indices.emplace(root_, place->integer(), GltfAccessor::Use::Indices, source_);

  const std::int64_t count = indices ? indices->count() : positions.count();
  corner_count_ += count * (mode == kTriangles ? 1 : 3);
  if (corner_count_ > kMaxCorners)
    primitive.fail("the scene has more than " + std::to_string(kMaxCorners) + " triangle corners");
  if (stamps_.size() < static_cast<std::size_t>(positions.count())) {
    stamps_.resize(static_cast<std::size_t>(positions.count()), 0);
    welded_vertices_.resize(stamps_.size());
  }
  ++stamp_;
  read_attributes(primitive, positions.count());
  // By corner: the primitive's vertex, and what it is welded to.
  std::vector<std::int32_t> corners(static_cast<std::size_t>(count));
  std::vector<std::int32_t> vertices(corners.size());
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t vertex = indices ? indices->index(i) : i;
    if (vertex >= positions.count())
      primitive["indices"].fail("entry " + std::to_string(i) + " names vertex " +
                                std::to_string(vertex) + " of " +
                                std::to_string(positions.count()));
    corners[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(vertex);
    vertices[static_cast<std::size_t>(i)] = welded(positions, vertex, primitive, instance);
  }
  if (const auto color = primitive["attributes"].find("COLOR_0"))
    color_vertices(*color, vertices, corners);
  add_triangles(primitive, mode, vertices, corners,
                glm::determinant(glm::dmat3(instance.to_world)) < 0);
}

// Texture coordinates are appended for the whole primitive; OBJ's v runs upwards, glTF's down.
void SceneReader::read_attributes(const JsonPlace& primitive, std::int64_t vertex_count) {
  FaceGroup group;
  if (const auto material = primitive.find("material")) {
    const JsonPlace place = root_["materials"][material->integer()];
    if (const auto name = place.find("name")) group.material = name->text();
  }
  if (const auto extras = primitive.find("extras"); extras && extras->is_object()) {
    if (const auto name = extras->find("group"); name && name->is_text()) group.name = name->text();
  }
  attributes_.use_group(std::move(group));

  first_uv_ = -1;
  const auto attribute = primitive["attributes"].find("TEXCOORD_0");
  if (!attribute) return;
  const GltfAccessor uvs(root_, attribute->integer(), GltfAccessor::Use::TextureCoordinates,
                         source_);
  if (uvs.count() != vertex_count)
    attribute->fail(std::to_string(uvs.count()) + " texture coordinates for " +
                    std::to_string(vertex_count) + " vertices");
  if (static_cast<std::int64_t>(uvs_.size()) + vertex_count > kMaxCorners)
    attribute->fail("the scene has more than " + std::to_string(kMaxCorners) +
                    " texture coordinates");
  first_uv_ = static_cast<std::int64_t>(uvs_.size());
  for (std::int64_t i = 0; i < vertex_count; ++i) {
    const glm::dvec2 uv = uvs.texture_coordinate(i);
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y))
      attribute->fail("the texture coordinate of vertex " + std::to_string(i) + " is not finite");
    uvs_.emplace_back(uv.x, 1.0 - uv.y);
  }
}

void SceneReader::color_vertices(const JsonPlace& attribute,
                                 const std::vector<std::int32_t>& vertices,
                                 const std::vector<std::int32_t>& corners) {
  const GltfAccessor colors(root_, attribute.integer(), GltfAccessor::Use::Colors, source_);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i] >= colors.count())
      attribute.fail("there is no colour for vertex " + std::to_string(corners[i]));
    const glm::vec4 color = colors.color(corners[i]);
    // Negated, so that NaN fails too.
    const bool in_range = color.r >= 0 && color.g >= 0 && color.b >= 0 && color.a >= 0 &&
                          color.r <= 1 && color.g <= 1 && color.b <= 1 && color.a <= 1;
    if (!in_range)
      attribute.fail("the colour of vertex " + std::to_string(corners[i]) +
                     " is not within 0 and 1");
    attributes_.color_vertex(vertices[i], color);
  }
}

// A vertex in the world.
glm::dvec3 placed(const GltfAccessor& positions, std::int64_t vertex, const JsonPlace& primitive,
                  const GltfInstance& instance) {
  const glm::dvec3 stored = positions.position(vertex);
  const glm::dvec3 position(instance.to_world * glm::dvec4(stored, 1.0));
  if (!is_finite(position)) {
    const glm::dvec3& shown = is_finite(stored) ? position : stored;
    primitive["attributes"]["POSITION"].fail("vertex " + std::to_string(vertex) + " is at (" +
                                             shortest(shown.x) + ", " + shortest(shown.y) + ", " +
                                             shortest(shown.z) + ")");
  }
  return position;
}

// All vertices: indices would only leave some out, or name some twice.
void SceneReader::read_point_primitive(const JsonPlace& primitive, const GltfInstance& instance) {
  const GltfAccessor positions(root_, primitive["attributes"]["POSITION"].integer(),
                               GltfAccessor::Use::Positions, source_);
  ++point_primitive_count_;
  corner_count_ += positions.count();
  if (corner_count_ > kMaxCorners)
    primitive.fail("the scene has more than " + std::to_string(kMaxCorners) +
                   " triangle corners and points");
  for (std::int64_t i = 0; i < positions.count(); ++i)
    points_.push_back(placed(positions, i, primitive, instance));
}

std::int32_t SceneReader::welded(const GltfAccessor& positions, std::int64_t vertex,
                                 const JsonPlace& primitive, const GltfInstance& instance) {
  const auto slot = static_cast<std::size_t>(vertex);
  if (stamps_[slot] != stamp_) {
    stamps_[slot] = stamp_;
    welded_vertices_[slot] = welder_.insert(placed(positions, vertex, primitive, instance));
  }
  return welded_vertices_[slot];
}

void SceneReader::add_triangles(const JsonPlace& primitive, std::int64_t mode,
                                const std::vector<std::int32_t>& vertices,
                                const std::vector<std::int32_t>& corners, bool mirrored) {
  constexpr std::int64_t kTriangles = 4, kStrip = 5;
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    // A mirror turns front faces into back faces.
    if (mirrored) std::swap(b, c);
    if (!triangles_.add(vertices[a], vertices[b], vertices[c])) return;
    for (const std::size_t corner : {a, b, c}) {
      attributes_.add_corner(
          first_uv_ < 0 ? -1 : static_cast<std::int32_t>(first_uv_ + corners[corner]));
    }
    attributes_.add_face();
  };
  if (mode == kTriangles) {
    if (vertices.size() % 3 != 0)
      primitive.fail(std::to_string(vertices.size()) + " corners make no whole triangles");
    for (std::size_t i = 0; i < vertices.size(); i += 3) add(i, i + 1, i + 2);
    return;
  }
  for (std::size_t i = 0; i + 2 < vertices.size(); ++i) {
    if (mode == kStrip) {
      add(i, i + 1 + i % 2, i + 2 - i % 2);
    } else {
      add(i + 1, i + 2, 0);
    }
  }
}

}  // namespace

MeshFile read_gltf(const FileBytes& file) {
  const GlbParts parts = split_glb(file.bytes, file.name);
  const nlohmann::json document = parse_json(parts.json, file.name);
  const JsonPlace root(document, file.name, "");
  std::optional<std::filesystem::path> folder;
  if (!file.path.empty()) folder = file.path.parent_path();
  GltfSource source(root, parts.chunk, std::move(folder));
  return SceneReader(root, source).read(parts.format);
}

}  // namespace planish
