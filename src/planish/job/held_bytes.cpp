#include "planish/job/held_bytes.h"

#include <algorithm>
#include <array>
#include <set>
#include <thread>

#include "planish/files/gltf/write_gltf.h"

namespace planish {
namespace {

constexpr std::uint64_t kStartBytes = 20 << 20;
constexpr std::uint64_t kKeptOfSolve = 4;
constexpr std::array<LevelCounts, 2> kNothing{};

// What packing takes beside the surface: a small one's plain bytes and those of the result; of a
// large one, quantized ones, and a block for each thread.
std::uint64_t packing_bytes(const LevelCounts& level) {
  const auto vertices = static_cast<std::uint64_t>(level.vertices);
  const auto faces = static_cast<std::uint64_t>(level.faces);
  if (level.faces <= kPackedFaces) return 48 * (vertices + faces);
  return 20 * vertices + 24 * faces;
}

std::uint64_t packed_blocks_bytes() {
  constexpr std::uint64_t kBlockBytes = 100'000'000;
  return kBlockBytes * std::max(1u, std::thread::hardware_concurrency());
}

LastLevel last_level(const Settings& settings) {
  if (settings.scheme != Scheme::DooSabin) return LastLevel::Full;
  return settings.attributes.any() ? LastLevel::None : LastLevel::Blocks;
}

}  // namespace

std::vector<LevelCounts> levels_to(const MeshCounts& mesh, Scheme scheme, int last) {
  std::vector<LevelCounts> levels{mesh.base};
  std::int64_t corners = mesh.corners;
  for (int level = 1; level <= last; ++level) {
    const LevelCounts& c = levels.back();
    const bool loop = scheme == Scheme::Loop;
    const LevelCounts next =
        loop ? LevelCounts{c.vertices + c.edges, 2 * c.edges + corners, 4 * c.faces}
             : LevelCounts{c.vertices + c.edges + c.faces, 2 * c.edges + corners, corners};
    corners = (loop ? 3 : 4) * next.faces;
    levels.push_back(next);
  }
  return levels;
}

RideBytes ride_bytes(const AssetVertices& vertices, const Settings& settings,
                     std::uint64_t row_count, std::uint64_t corner_count, bool holds_rows) {
  constexpr std::uint64_t kUv = sizeof(glm::dvec2), kPoint = sizeof(glm::dvec3), kFloat = 4;
  RideBytes bytes;
  const std::uint64_t targets = vertices.targets.size();
  const auto sets = static_cast<std::uint64_t>(vertices.joint_sets);
  for (const auto& set : vertices.further_uvs) bytes.given += kUv * set.size();
  for (const AssetArray& array : vertices.arrays) bytes.given += kFloat * array.values.size();
  for (const auto& target : vertices.targets) bytes.given += kPoint * target.size();
  bytes.given +=
      sizeof(JointWeight) * (vertices.influences.size() + vertices.first_influence.size());
  std::uint64_t row =
      kUv * vertices.further_uvs.size() + 2 * 4 * kFloat * sets + 6 * kFloat * targets;
  for (const AssetArray& array : vertices.arrays)
    row += kFloat * static_cast<std::uint64_t>(array.width);
  row += (kUv + 4 * kFloat) * static_cast<std::uint64_t>(vertices.tangent_count());
  bytes.rows = row * row_count;
  if (!vertices.moves()) return bytes;
  // B, and surfaces: one of three joints each, all at once; of a target. On fair surfaces four
  // joints are a field, at all rows.
  constexpr std::uint64_t kFieldJoints = 4, kFieldBytes = 140, kSystemBytes = 150,
                          kThroughBytes = 60, kTargetSurfaces = 3, kHeldRowBytes = 36;
  std::set<std::int32_t> joints;
  for (const JointWeight& influence : vertices.influences) joints.insert(influence.joint);
  const bool is_fair = settings.interpolation == InterpolationChoice::Fair;
  const std::uint64_t fields = (joints.size() + kFieldJoints - 1) / kFieldJoints;
  const std::uint64_t surfaces = std::max<std::uint64_t>(is_fair ? 0 : (joints.size() + 2) / 3,
                                                         targets > 0 ? kTargetSurfaces : 0);
  if (surfaces > 0) bytes.making = (kSystemBytes + kThroughBytes * surfaces) * corner_count;
  if (holds_rows) bytes.making += kHeldRowBytes * surfaces * row_count;
  if (fields > 0 && settings.interpolation != InterpolationChoice::Progressive)
    bytes.making = std::max(bytes.making, kFieldBytes * corner_count +
                                              kFieldJoints * kFloat * (fields + 2) * row_count);
  return bytes;
}

HeldBytes::HeldBytes(const Settings& settings)
    : settings_(settings),
      last_(last_level(settings)),
      fixed_(tessellation_bytes(kNothing, last_)) {}

void HeldBytes::add(const RefinedAttributes& attributes, const MeshCounts& counts,
                    const std::vector<int>& held_levels, std::uint64_t solve,
                    const AssetVertices* rides, bool ride_on_levels) {
  std::uint64_t kept = solve / kKeptOfSolve;
  if (rides != nullptr) kept += ride_bytes(*rides, settings_, 0, 0, false).given;
  kept_ += kept;
  solve_ = std::max(solve_, solve - solve / kKeptOfSolve);
  for (const int level : held_levels)
    add_surface(attributes, levels_to(counts, settings_.scheme, level),
                static_cast<std::uint64_t>(counts.corners), ride_on_levels ? rides : nullptr);
}

std::uint64_t HeldBytes::peak() const {
  return kept_ + std::max(kStartBytes + solve_, kStartBytes / kKeptOfSolve + fixed_ + surfaces_ +
                                                    std::max(making_, packing_));
}

void HeldBytes::add_surface(const RefinedAttributes& attributes,
                            const std::vector<LevelCounts>& levels, std::uint64_t corner_count,
                            const AssetVertices* rides) {
  const LevelCounts& level = levels.back();
  const auto rows = static_cast<std::uint64_t>(level.vertices);
  std::uint64_t surface = tessellation_bytes(levels, last_, attributes) - fixed_;
  // Fields, and what they are made from: who is a vertex's neighbour.
  constexpr std::uint64_t kFieldBytes = 120;
  if (settings_.attributes.any()) surface += kFieldBytes * rows;
  if (settings_.compression != GltfCompression::None) {
    const std::uint64_t packing = packing_bytes(level);  // the last half is what comes out
    surface += packing / 2;
    packing_ = std::max(
        packing_, packing - packing / 2 + (level.faces > kPackedFaces ? packed_blocks_bytes() : 0));
  }
  if (rides != nullptr) {
    const RideBytes bytes =
        ride_bytes(*rides, settings_, rows, corner_count, last_ == LastLevel::Full);
    surface += bytes.rows;
    making_ = std::max(making_, bytes.making);
  }
  surfaces_ += surface;
}

}  // namespace planish
