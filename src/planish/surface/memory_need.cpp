#include "planish/surface/memory_need.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <string>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/platform/machine.h"
#include "planish/core/words.h"

namespace planish {

namespace {

std::atomic<std::uint64_t> memory_elsewhere = 0;

// OpenSubdiv's tables for one quad with its share of edges and vertices: both directions of all
// incidences.
constexpr std::uint64_t kTopologyBytes = 260;
// A control point of a level's state in double.
constexpr std::uint64_t kStateBytes = 24;
// Position in double, normal in float, four indices.
constexpr std::uint64_t kSurfaceVertexBytes = 36;
constexpr std::uint64_t kSurfaceFaceBytes = 16;
// A texture coordinate: those of the last level and of the one before as they are refined, and
// those of the surface. As many as vertices; seams add few.
constexpr std::uint64_t kUvBytes = 16 + 4 + 16;
// Their indices at a surface's face, and OpenSubdiv's tables of them for a face of any level.
constexpr std::uint64_t kUvFaceBytes = 16;
constexpr std::uint64_t kUvTopologyBytes = 64;
// A colour, likewise: in double as it is refined, in float on the surface.
constexpr std::uint64_t kColorBytes = 32 + 8 + 16;
constexpr std::uint64_t kGroupFaceBytes = 4;
// Values of a surface alone.
constexpr std::uint64_t kPatchUvBytes = 16;
constexpr std::uint64_t kPatchColorBytes = 16;
// Of a number of an attribute; the primal schemes carry four at a time in double, besides.
constexpr std::uint64_t kNumberBytes = 4;
// Position and normal in float, beside the surface's own.
constexpr std::uint64_t kDeviceRowBytes = 24;
// Stencil slices on their way.
constexpr std::uint64_t kFixedBytes = 256u << 20;
// Of a surface of patches: what a corner of the mesh takes with its share of vertices (the mesh
// without unused vertices, connectivity, the control point of level 1), and the tiles of all
// threads.
constexpr std::uint64_t kPatchCornerBytes = 100;
// Of a field of texture coordinates or values while it is made; what is left of one of values, of
// four numbers at each corner and vertex.
constexpr std::uint64_t kFieldCornerBytes = 100, kValueCornerBytes = 16 + 4;
constexpr std::uint64_t kPatchFixedBytes = 32u << 20;
// What is kept of a surface while it is written (kept_rows.h): rows up to a bound, the cut of each
// quad; texture coordinates and groups make a vertex of each corner beside the values.
constexpr std::uint64_t kKeptRowBytes = 36;
constexpr std::uint64_t kMostKeptBytes = std::uint64_t{1} << 30;
constexpr std::uint64_t kCutBytes = 1;
constexpr std::uint64_t kSplitFaceBytes = 32, kSplitVertexBytes = 24;

std::string gibibytes(std::uint64_t bytes) {
  const std::string tenths = std::to_string(bytes * 10 / (std::uint64_t{1} << 30));
  return tenths.size() == 1 ? "0." + tenths + " GiB"
                            : tenths.substr(0, tenths.size() - 1) + "." + tenths.back() + " GiB";
}

std::string counts_text(std::span<const LevelCounts> levels) {
  return formatted("level {} has {} and {}", levels.size() - 1,
                   counted(levels.back().vertices, "vertex"), counted(levels.back().faces, "face"));
}

std::uint64_t patch_bytes(std::span<const LevelCounts> levels, LastLevel last,
                          const RefinedAttributes& attributes) {
  // The faces of level 1 are the corners; at least three a face.
  const auto corners =
      static_cast<std::uint64_t>(levels.size() > 1 ? levels[1].faces : 4 * levels[0].faces);
  const auto faces = static_cast<std::uint64_t>(levels.back().faces);
  const auto vertices = static_cast<std::uint64_t>(levels.back().vertices);
  std::uint64_t bytes = kPatchFixedBytes + kPatchCornerBytes * corners;
  // Where attributes of one and of four numbers take turns, two of five numbers begin a four.
  const std::uint64_t fours = (attributes.colors ? 1 : 0) + (attributes.numbers + 1) / 2;
  if (attributes.uvs || fours > 0) bytes += kFieldCornerBytes * corners;
  bytes += kValueCornerBytes * fours * corners;
  if (attributes.device_rows) bytes += kDeviceRowBytes * vertices;
  bytes += kNumberBytes * attributes.numbers * vertices;
  if (last == LastLevel::Blocks) {
    bytes += std::min(kKeptRowBytes * vertices, kMostKeptBytes) + kCutBytes * faces;
    if (attributes.uvs || attributes.groups)
      bytes += kSplitVertexBytes * vertices + kSplitFaceBytes * faces;
    return bytes;
  }
  bytes += kSurfaceVertexBytes * vertices + kSurfaceFaceBytes * faces;
  if (attributes.uvs) bytes += kPatchUvBytes * vertices + kUvFaceBytes * faces;
  if (attributes.colors) bytes += kPatchColorBytes * vertices;
  if (attributes.groups) bytes += kGroupFaceBytes * faces;
  return bytes;
}

}  // namespace

RefinedAttributes RefinedAttributes::of(const PolygonMesh& mesh) {
  return {.uvs = !mesh.face_uvs.empty(),
          .colors = !mesh.colors.empty(),
          .groups = !mesh.face_groups.empty(),
          .numbers = numbers_of(mesh.attributes),
          .holes = !mesh.hole_faces.empty()};
}

std::uint64_t tessellation_bytes(std::span<const LevelCounts> levels, LastLevel last,
                                 const RefinedAttributes& attributes) {
  if (last == LastLevel::None || last == LastLevel::Blocks)
    return patch_bytes(levels, last, attributes);
  std::uint64_t bytes = kFixedBytes;
  for (const LevelCounts& level : levels)
    bytes += kTopologyBytes * static_cast<std::uint64_t>(level.faces);
  const auto faces = static_cast<std::uint64_t>(levels.back().faces);
  bytes += kStateBytes * (faces + faces / 4);
  const auto vertices = static_cast<std::uint64_t>(levels.back().vertices);
  std::uint64_t surface = kSurfaceVertexBytes * vertices + kSurfaceFaceBytes * faces;
  if (attributes.uvs) {
    surface += kUvBytes * vertices + kUvFaceBytes * faces;
    for (const LevelCounts& level : levels) {
      bytes += kUvTopologyBytes * static_cast<std::uint64_t>(level.faces);
    }
  }
  if (attributes.colors) surface += kColorBytes * vertices;
  surface += kNumberBytes * attributes.numbers * vertices;
  if (attributes.groups) surface += kGroupFaceBytes * faces;
  return bytes + (attributes.holes ? 2 : 1) * surface;
}

namespace {

std::uint64_t free_on_machine() {
  const std::uint64_t available = platform::free_memory();
  const std::uint64_t elsewhere = memory_elsewhere;
  return available + std::min(elsewhere, std::numeric_limits<std::uint64_t>::max() - available);
}

}  // namespace

std::uint64_t available_memory_bytes() {
  const LimitScope* const scope = LimitScope::current();
  const std::uint64_t allowed = scope != nullptr ? scope->limits().memory_bytes : 0;
  return allowed > 0 ? std::min(allowed, free_on_machine()) : free_on_machine();
}

void set_memory_elsewhere(std::uint64_t bytes) { memory_elsewhere = bytes; }

void require_indices(std::span<const LevelCounts> levels) {
  // Four corners a face are indexed by int32.
  if (levels.back().edges * 2 > std::numeric_limits<std::int32_t>::max()) {
    throw Error(ErrorCode::OutOfMemory,
                counts_text(levels) + ", more than 32-bit indices reach; take fewer levels");
  }
}

void require_memory(std::span<const LevelCounts> levels, LastLevel last,
                    const RefinedAttributes& attributes, std::uint64_t limit_bytes) {
  require_indices(levels);
  const std::uint64_t need = tessellation_bytes(levels, last, attributes);
  const std::uint64_t limit = limit_bytes > 0 ? limit_bytes : available_memory_bytes();
  if (need > limit) {
    throw Error(ErrorCode::OutOfMemory,
                formatted("{} and needs {} of memory where {} are free; take fewer levels",
                          counts_text(levels), gibibytes(need), gibibytes(limit)));
  }
}

}  // namespace planish
