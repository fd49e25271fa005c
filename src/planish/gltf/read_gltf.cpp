// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.7 (meshes) and 4 (GLB).
#include "planish/gltf/read_gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>
#include <optional>

#include "planish/core/error.h"
#include "planish/gltf/gltf_accessor.h"
#include "planish/gltf/gltf_nodes.h"
#include "planish/gltf/gltf_source.h"
#include "planish/gltf/json_place.h"
#include "planish/mesh/bytes.h"
#include "planish/mesh/number_text.h"
#include "planish/mesh/weld.h"

namespace planish {
namespace {

// A few bytes of nodes can place any number of triangles; more than these could not be handled by
// what follows anyway.
constexpr std::int64_t kMaxCorners = std::int64_t{1} << 28;
constexpr std::int64_t kMaxPrimitives = std::int64_t{1} << 20;

// Extensions that change nothing about the triangles; any other that a file requires is refused.
constexpr std::array<std::string_view, 5> kHarmlessExtensions = {
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_mesh_quantization"};

struct GltfFileParts {
  std::string_view json;
  std::span<const std::byte> chunk;
  MeshFormat format = MeshFormat::Gltf;
};

bool is_finite(const glm::dvec3& position) {
  return std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z);
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

GltfFileParts split_glb(std::span<const std::byte> bytes, std::string_view name) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942;
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::UnreadableInput, std::string(name) + ": " + what);
  };
  if (!text_of(bytes).starts_with("glTF")) return {.json = text_of(bytes), .chunk = {}};
  if (bytes.size() < kHeader + kChunkHeader)
    fail("a GLB begins with 20 bytes, but the file has " + std::to_string(bytes.size()));
  const auto version = load<std::uint32_t>(bytes.subspan(4));
  if (version != 2) fail("GLB version " + std::to_string(version) + " is not 2");
  const auto length = load<std::uint32_t>(bytes.subspan(8));
  if (length > bytes.size() || length < kHeader)
    fail("header promises " + std::to_string(length) + " bytes, but the file has " +
         std::to_string(bytes.size()));
  GltfFileParts parts{.json = {}, .chunk = {}, .format = MeshFormat::Glb};
  std::span<const std::byte> left = bytes.subspan(kHeader, length - kHeader);
  for (int index = 0; left.size() >= kChunkHeader; ++index) {
    const auto size = load<std::uint32_t>(left);
    const auto type = load<std::uint32_t>(left.subspan(4));
    if (size > left.size() - kChunkHeader)
      fail("chunk " + std::to_string(index) + " promises " + std::to_string(size) +
           " bytes, but only " + std::to_string(left.size() - kChunkHeader) + " follow");
    if (index == 0 && type != kJson) fail("the first chunk is not JSON");
    if (index == 0) parts.json = text_of(left.subspan(kChunkHeader, size));
    if (index == 1 && type == kBinary) parts.chunk = left.subspan(kChunkHeader, size);
    left = left.subspan(kChunkHeader + size);
  }
  return parts;
}

class SceneReader {
 public:
  SceneReader(JsonPlace root, GltfSource& source) : root_(std::move(root)), source_(source) {}

  MeshFile read(MeshFormat format) {
    require_version();
    for (const GltfInstance& instance : gltf_instances(root_)) read_instance(instance);
    file_.format = format;
    triangles_.finish(welder_, file_);
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
  void add_triangles(const JsonPlace& primitive, std::int64_t mode,
                     const std::vector<std::int32_t>& vertices, bool mirrored);
  std::int32_t welded(const GltfAccessor& positions, std::int64_t vertex,
                      const JsonPlace& primitive, const GltfInstance& instance);

  JsonPlace root_;
  GltfSource& source_;
  Welder welder_;
  TriangleCollector triangles_;
  MeshFile file_;
  std::int64_t deformed_count_ = 0, primitive_count_ = 0, corner_count_ = 0;
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
  constexpr std::int64_t kTriangles = 4, kFan = 6;
  const std::int64_t mode = primitive.integer_or("mode", kTriangles);
  if (mode > kFan) primitive["mode"].fail(std::to_string(mode) + " is no mode of primitives");
  const auto position = primitive["attributes"].find("POSITION");
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
  std::vector<std::int32_t> vertices(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t vertex = indices ? indices->index(i) : i;
    if (vertex >= positions.count())
      primitive["indices"].fail("entry " + std::to_string(i) + " names vertex " +
                                std::to_string(vertex) + " of " +
                                std::to_string(positions.count()));
    vertices[static_cast<std::size_t>(i)] = welded(positions, vertex, primitive, instance);
  }
  add_triangles(primitive, mode, vertices, glm::determinant(glm::dmat3(instance.to_world)) < 0);
}

std::int32_t SceneReader::welded(const GltfAccessor& positions, std::int64_t vertex,
                                 const JsonPlace& primitive, const GltfInstance& instance) {
  const auto slot = static_cast<std::size_t>(vertex);
  if (stamps_[slot] != stamp_) {
    const glm::dvec3 stored = positions.position(vertex);
    const glm::dvec3 position(instance.to_world * glm::dvec4(stored, 1.0));
    if (!is_finite(position)) {
      const glm::dvec3& shown = is_finite(stored) ? position : stored;
      primitive["attributes"]["POSITION"].fail("vertex " + std::to_string(vertex) + " is at (" +
                                               shortest(shown.x) + ", " + shortest(shown.y) + ", " +
                                               shortest(shown.z) + ")");
    }
    stamps_[slot] = stamp_;
    welded_vertices_[slot] = welder_.insert(position);
  }
  return welded_vertices_[slot];
}

void SceneReader::add_triangles(const JsonPlace& primitive, std::int64_t mode,
                                const std::vector<std::int32_t>& vertices, bool mirrored) {
  constexpr std::int64_t kTriangles = 4, kStrip = 5;
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    // A mirror turns front faces into back faces.
    if (mirrored) std::swap(b, c);
    triangles_.add(vertices[a], vertices[b], vertices[c]);
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

MeshFile read(std::span<const std::byte> bytes, std::string_view name,
              std::optional<std::filesystem::path> folder) {
  const GltfFileParts parts = split_glb(bytes, name);
  const nlohmann::json document = parse_json(parts.json, name);
  const JsonPlace root(document, name, "");
  GltfSource source(root, parts.chunk, std::move(folder));
  return SceneReader(root, source).read(parts.format);
}

}  // namespace

MeshFile read_gltf(const std::filesystem::path& path) {
  return read(read_file(path), path.string(), path.parent_path());
}

MeshFile read_gltf(std::span<const std::byte> bytes, std::string_view name) {
  return read(bytes, name, std::nullopt);
}

}  // namespace planish
