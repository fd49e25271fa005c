#include "planish/job/forecast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/portable_math.h"
#include "planish/core/words.h"
#include "planish/fair/semi_sharp.h"
#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/job/job.h"
#include "planish/job/job_input.h"
#include "planish/job/job_settings.h"
#include "planish/job/job_text.h"
#include "planish/job/output_plan.h"
#include "planish/job/page/page.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/bake_maps.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/reconstruct/mesher_process.h"
#include "planish/solve/stencil_table.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

// Triangles that surfaces took for each one counted here: of meshes of quads 0.8 to 5, of meshes
// of triangles, whose surfaces ripple, 6 to 11.
constexpr double kOfQuads = 6, kOfTriangles = 12;
// Of what is decimated, for each that is left.
constexpr double kSamplesOfTriangle = 8;

double area_of(const PolygonMesh& mesh) {
  double area = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    area += glm::length(area_vector(mesh.positions, mesh.face(f)));
  return area;
}

// In radians, by edge; 0 at boundaries and where the surface is sharp.
std::vector<double> turns_at_edges(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                   const std::vector<glm::dvec3>& normals) {
  const MeshTopology& topology = *prepared.topology;
  std::set<std::pair<std::int32_t, std::int32_t>> sharp;
  for (const CreaseEdge& crease : mesh.creases) sharp.insert(std::minmax(crease.v0, crease.v1));
  std::vector<double> turns(static_cast<std::size_t>(topology.edge_count()));
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const std::int32_t corner = topology.corner_of(e), twin = topology.twin(corner);
    const auto [v0, v1] = topology.edge_vertices(e);
    if (twin < 0 || sharp.contains(std::minmax(prepared.vertices[v0], prepared.vertices[v1])))
      continue;
    const double cosine =
        glm::dot(normals[topology.face_of(corner)], normals[topology.face_of(twin)]);
    turns[e] = portable::acos(std::clamp(cosine, -1.0, 1.0));
  }
  return turns;
}

// At most about how many triangles a tessellation to an adaptive fineness takes, told from how
// much the mesh turns at its edges: between a face's middle and each edge the surface bends by
// half of that. `prepared` is of `mesh`.
double expected_triangles(const PolygonMesh& mesh, const PreparedMesh& prepared,
                          const Fineness& fineness) {
  const MeshTopology& topology = *prepared.topology;
  const DecimationTarget& target = fineness.target;
  if (target.triangles > 0 || target.edge_length > 0) {
    // Several times as many as are wanted, or the least that there can be.
    const double wanted = target.triangles > 0
                              ? static_cast<double>(target.triangles)
                              : area_of(mesh) / (target.edge_length * target.edge_length / 2);
    return std::max(kSamplesOfTriangle * wanted, 2.0 * topology.corner_count());
  }
  const double error = fineness.chord_error + target.distance / 4;
  const double chord = error * placement_of(mesh).diagonal;
  const double angle = fineness.angle * std::numbers::pi / 180;
  std::vector<glm::dvec3> normals;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const glm::dvec3 area = area_vector(mesh.positions, mesh.face(f));
    const double length = glm::length(area);
    normals.push_back(length > 0 ? area / length : glm::dvec3(0.0));
  }
  const std::vector<double> turns = turns_at_edges(mesh, prepared, normals);
  double sum = 0;
  std::vector<double> cuts;  // of the way to each edge of the face at hand
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const auto edges = topology.face_edges(f);
    const auto position = [&](std::size_t i) { return mesh.positions[face[i % face.size()]]; };
    glm::dvec3 middle(0.0);
    for (std::size_t i = 0; i < face.size(); ++i) middle += position(i);
    middle /= static_cast<double>(face.size());
    cuts.clear();
    for (std::size_t i = 0; i < face.size(); ++i) {
      const double turn = turns[edges[i]] / 2;
      const double way = glm::length((position(i) + position(i + 1)) / 2.0 - middle);
      // An arc that turns by `turn` rises by an eighth of it over its length.
      const double by_chord = chord > 0 ? std::sqrt(way * turn / (8 * chord)) : 0;
      cuts.push_back(std::max(by_chord, angle > 0 ? turn / angle : 0));
    }
    const double share = face.size() == 3 ? kOfTriangles : kOfQuads;
    double count = static_cast<double>(face.size() - 2);
    if (std::ranges::max(cuts) >= 0.5) {
      count = 0;
      for (std::size_t i = 0; i < cuts.size(); ++i) {
        const double most = std::max({1.0, cuts[i], cuts[(i + 1) % cuts.size()]});
        count += 2 * most * most;
      }
    }
    sum += share * count;
  }
  return sum;
}

// Where the surface has several normals: copies of the mesh's vertices, and edges whose inner
// vertices are copied at every level.
struct Copies {
  std::int64_t vertices = 0, edges = 0;

  [[nodiscard]] std::int64_t at(int level) const {
    return vertices + edges * ((std::int64_t{1} << level) - 1);
  }
};

// `prepared` is of `mesh`.
Copies copies_of(const PolygonMesh& mesh, const PreparedMesh& prepared) {
  const MeshTopology& topology = *prepared.topology;
  // The topology's number of a vertex, -1: no face names it.
  const auto used = [&](std::int32_t vertex) {
    const auto found = std::ranges::lower_bound(prepared.vertices, vertex);
    return found == prepared.vertices.end() || *found != vertex
               ? -1
               : static_cast<std::int32_t>(found - prepared.vertices.begin());
  };
  std::set<std::int32_t> sharp;
  for (const CreaseEdge& crease : mesh.creases) {
    if (!std::isinf(crease.sharpness) && crease.sharpness < kInfiniteSharpness) continue;
    const std::int32_t v0 = used(crease.v0), v1 = used(crease.v1);
    const std::int32_t edge = v0 < 0 || v1 < 0 ? -1 : topology.find_edge(v0, v1);
    if (edge >= 0 && !topology.is_boundary_edge(edge)) sharp.insert(edge);
  }
  Copies copies{.edges = std::ssize(sharp)};
  std::set<std::int32_t> inner;  // whose first sharp edge parts nothing
  for (const std::int32_t edge : sharp) {
    const auto [v0, v1] = topology.edge_vertices(edge);
    for (const std::int32_t v : {v0, v1})
      if (topology.is_boundary_vertex(v) || !inner.insert(v).second) ++copies.vertices;
  }
  return copies;
}

// Elements of a mesh.
struct MeshCounts {
  LevelCounts base;
  std::int64_t corners;
};

// Bytes of what rides on a mesh of an asset: as it was given, at the surface's rows, and what its
// rows are made from meanwhile.
struct RideBytes {
  std::uint64_t given = 0, rows = 0, making = 0;
};

// What the meshes of a job hold at its peak. They are solved one after another beside what is kept
// of all; then their surfaces are held together. Doo-Sabin surfaces go by blocks to who writes
// them, but for those who need neighbours: values of vertices.
class HeldBytes {
 public:
  // `settings` must outlive it.
  explicit HeldBytes(const Settings& settings);

  // `held_levels`: those whose surfaces are held together. `solve`: bytes of the mesh and its
  // fits. `ride_on_levels`: what rides on the vertices is written with these levels.
  void add(const RefinedAttributes& attributes, const MeshCounts& counts,
           const std::vector<int>& held_levels, std::uint64_t solve,
           const AssetVertices* rides = nullptr, bool ride_on_levels = true);
  [[nodiscard]] std::uint64_t peak() const;

 private:
  void add_surface(const RefinedAttributes& attributes, const std::vector<LevelCounts>& levels,
                   std::uint64_t corner_count, const AssetVertices* rides);

  const Settings& settings_;
  LastLevel last_;
  std::uint64_t fixed_, kept_ = 0, surfaces_ = 0, solve_ = 0, making_ = 0, packing_ = 0;
};

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

// Elements of the levels 0 to `last`: quads from level 1 on, triangles with Loop.
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

// `holds_rows`: of each surface, as but levels of Doo-Sabin surfaces do.
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

MeshCounts mesh_counts_of(const PreparedMesh& mesh) {
  const MeshTopology& topology = *mesh.topology;
  return {{topology.vertex_count(), topology.edge_count(), topology.face_count()},
          topology.corner_count()};
}

// CPU seconds, reading and writing included, measured on two cores: of a million vertices of the
// mesh for each fit, of points of a surface, of vertices of a page's, of triangles cut where it
// bends, of points that are meshed, and of those of a large cloud of which few are.
constexpr double kVertexSeconds = 6, kPointSeconds = 0.6, kPageSeconds = 4, kBendSeconds = 2.5,
                 kCloudSeconds = 80, kCarriedSeconds = 20;
// The same of a vertex that may be left: two to ten further fits, each measured; with other schemes
// than Doo-Sabin, whose levels are made whole for that.
constexpr double kLeavingSeconds = 25, kLeavingPrimalSeconds = 120;

// And of places of a baked map, of which it has so many along a side at least; its PNG included.
constexpr double kBakeSeconds = 0.2;
constexpr int kBakeSide = 4096;

// Bytes of host memory, upper values of what the command took: tools/planish/README.md has them.
constexpr std::uint64_t kPageVertexBytes = 210 + 36, kPageUvBytes = 110, kBendBytes = 48,
                        kBendUvBytes = 96;
constexpr std::uint64_t kTileVertexBytes = 180;
// Of a page's still picture: four samples of 8 bytes and a pixel of 4.
constexpr std::uint64_t kStillBytes = std::uint64_t{36} * kStillWidth * kStillHeight;
constexpr std::uint64_t kCloudFixedBytes = 40u << 20, kCarriedPointBytes = 130;
// Copies of what points have besides their places: the reader's and the cloud's.
constexpr std::uint64_t kRiderCopies = 2;
// So many times the vertices and faces a mesh may have where vertices are added to it: of 60 meshes
// 2.5 to 7 times.
// With added vertices a mesh has about 3 times its faces, seldom more than so many.
constexpr std::int64_t kMostAdded = 4;
// Samples may be so many times more than asked for.
constexpr double kMostSamples = 1.3;

// Of B-spline faces, by quads of level 1 of a mesh of triangles, which has most points where none
// is regular: what they take, and for how many points of a surface they take the time; of degree 2
// and 3.
constexpr std::uint64_t kStepCornerBytes = 6000, kCubicCornerBytes = 9000;
constexpr double kStepPoints = 60, kCubicPoints = 150;

// The mesh and what its fits take, by corners of the mesh before triangles are joined: where the
// progressive method is named, where another or both may be made, and both of quads and triangles.
constexpr std::uint64_t kProgressiveBytes = 150, kFairBytes = 210, kPrimalBytes = 300,
                        kBothBytes = 290;

// Of a net in which semi-sharp edges are smooth beside the one in which they are sharp.
constexpr std::uint64_t kSemiSharpBytes = 80;

// Where vertices may be left, the best surface so far beside the next one and how it bends.
constexpr std::uint64_t kLeavingBytes = 110, kLeavingPrimalBytes = 800;

bool may_leave_vertices(const Settings& settings) {
  return settings.within.is_measured || settings.within.of_diagonal.value_or(0) > 0;
}

std::uint64_t solve_bytes(std::int64_t corners, bool makes_both, const Settings& settings) {
  const bool is_primal = settings.scheme != Scheme::DooSabin;
  std::uint64_t bytes = is_primal    ? kPrimalBytes
                        : makes_both ? kBothBytes
                        : settings.interpolation == InterpolationChoice::Progressive
                            ? kProgressiveBytes
                            : kFairBytes;
  if (may_leave_vertices(settings)) bytes += is_primal ? kLeavingPrimalBytes : kLeavingBytes;
  return bytes * static_cast<std::uint64_t>(corners);
}

// Of control cages beside surfaces, which are of other fits where the method is left open or the
// scheme is another.
int cage_fits(const Settings& settings, const std::vector<PlannedOutput>& outputs) {
  const bool is_other = settings.cage_scheme && settings.cage_scheme != settings.scheme;
  return has_cage(outputs) && (is_other || chooses_by_measurement(settings)) ? 1 : 0;
}

// The levels that are held together: the highest, or those of detail in one file.
std::vector<int> held_levels(const std::vector<PlannedOutput>& outputs) {
  std::vector<int> held{1};  // where the surface is measured
  for (const PlannedOutput& output : outputs) {
    // Tiles are made one by one, and STEP has no levels.
    if (output.kind != OutputKind::Surface || !info_of(output.format).has_fineness()) continue;
    std::vector<int> levels;
    for (const Fineness& fineness : output.finenesses()) levels.push_back(fineness.level);
    held = std::max(held, levels);  // by the first, which is the highest
  }
  return held;
}

// Whose elements the file has. Control cages of the fair method are its meshes of level 1.
int level_of(const PlannedOutput& output, const Settings& settings) {
  if (output.kind == OutputKind::Surface) return output.fineness.level;
  return settings.interpolation == InterpolationChoice::Fair ? 1 : 0;
}

// The finest level that a page shows: the next is made while that of the last leaves room, which
// takes three bytes a vertex at least.
const LevelCounts& page_counts(const std::vector<LevelCounts>& levels, std::uint64_t page_bytes) {
  std::size_t level = 0;
  while (level < kPageLevel && 9 * levels[level].vertices / 2 <= std::int64_t(page_bytes)) ++level;
  return levels[level];
}

// What any job with these numbers of elements takes, of memory beside HeldBytes; of files those
// aside that curvature decides, and STEP.
Forecast forecast_by_counts(const MeshCounts& counts, const Settings& settings,
                            const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes) {
  int finest = kPageLevel;
  for (const PlannedOutput& output : outputs) finest = std::max(finest, output.fineness.level);
  const std::vector<LevelCounts> levels = levels_to(counts, settings.scheme, finest);
  const std::span<const LevelCounts> all(levels);
  Forecast forecast;
  double points = 0;
  for (const PlannedOutput& output : outputs) {
    OutputForecast& file = forecast.outputs.emplace_back();
    if (output.fineness.is_adaptive()) continue;
    if (info_of(output.format).is_brep) {
      const bool is_cubic = settings.scheme == Scheme::CatmullClark;
      points += (is_cubic ? kCubicPoints : kStepPoints) * static_cast<double>(counts.corners);
      forecast.peak_bytes =
          std::max(forecast.peak_bytes, (is_cubic ? kCubicCornerBytes : kStepCornerBytes) *
                                            static_cast<std::uint64_t>(counts.corners));
      continue;
    }
    const int level = level_of(output, settings);
    const bool is_tiles = info_of(output.format).is_tiles;
    const auto add = [&](const LevelCounts& l) {
      file.vertices += l.vertices;
      file.faces += l.faces;
    };
    std::ranges::for_each(all.subspan(is_tiles ? 1 : level, is_tiles ? level : 1), add);
    for (const Fineness& coarser : output.coarser)
      if (!coarser.is_adaptive()) add(levels[coarser.level]);
    points += static_cast<double>(file.vertices);
    if (is_tiles)
      forecast.peak_bytes = std::max(
          forecast.peak_bytes, kTileVertexBytes * static_cast<std::uint64_t>(std::min(
                                                      settings.tile_vertices, file.vertices)));
  }
  double seconds = kPointSeconds * points;
  if (page_bytes > 0) {
    const std::int64_t vertices = page_counts(levels, page_bytes).vertices;
    forecast.peak_bytes += kStillBytes + kPageVertexBytes * static_cast<std::uint64_t>(vertices);
    seconds += kPageSeconds * static_cast<double>(vertices);
  }
  const double fits = (chooses_by_measurement(settings) ? 2 : 1) + cage_fits(settings, outputs);
  const double leaving = !may_leave_vertices(settings)         ? 0
                         : settings.scheme != Scheme::DooSabin ? kLeavingPrimalSeconds
                                                               : kLeavingSeconds;
  seconds += (kVertexSeconds * fits + leaving) * static_cast<double>(levels[0].vertices);
  forecast.seconds = 1e-6 * seconds;
  return forecast;
}

std::uint64_t solve_bytes(const ReadyFit& ready, const Settings& settings,
                          const std::vector<PlannedOutput>& outputs) {
  const bool makes_both = ready.paired && !ready.is_plainly_halved;
  const std::int64_t corners = ready.input.prepared->topology->corner_count();
  std::uint64_t further =
      (settings.cage_scheme ? kPrimalBytes : kProgressiveBytes) * cage_fits(settings, outputs);
  if (settings.scheme == Scheme::DooSabin && has_semi_sharp(ready.input.mesh))
    further += kSemiSharpBytes;
  return solve_bytes(corners, makes_both, settings) + further * static_cast<std::uint64_t>(corners);
}

std::uint64_t rider_bytes(const PointCloud& cloud) {
  std::uint64_t bytes =
      std::span(cloud.normals).size_bytes() + std::span(cloud.colors).size_bytes();
  for (const VertexAttribute& attribute : cloud.attributes)
    bytes += std::span(attribute.values).size_bytes();
  return bytes;
}

double thread_count() { return std::max(1u, std::thread::hardware_concurrency()); }

const MeshToFit& expected_mesh(const MeshNeed& mesh) { return expected_fit(*mesh.ready).input; }

// Whose level is settled: as if vertices were added where they may be.
MeshDensity expected_density(const MeshNeed& mesh) {
  MeshDensity density = expected_mesh(mesh).density;
  density.is_refined |= may_refine(*mesh.ready);
  return density;
}

MeshCounts expected_counts(const MeshNeed& mesh) {
  MeshCounts counts = mesh_counts_of(*expected_mesh(mesh).prepared);
  if (mesh.ready->refined || !may_refine(*mesh.ready)) return counts;
  for (std::int64_t* count :
       {&counts.base.vertices, &counts.base.edges, &counts.base.faces, &counts.corners})
    *count *= kMostAdded;
  return counts;
}

// `share`: see MeshFineness.
std::vector<PlannedOutput> settled_for(const MeshNeed& mesh,
                                       const std::vector<PlannedOutput>& outputs,
                                       double share = 1) {
  return settled(outputs, {expected_density(mesh).level(), share});
}

// With so many levels less, as far as there are any.
std::uint64_t held_bytes(std::span<const MeshNeed> meshes, const Settings& settings,
                         const std::vector<PlannedOutput>& outputs, int less = 0) {
  // Else a level is measured, and nothing rides on it.
  const bool writes_levels = std::ranges::any_of(outputs, [](const PlannedOutput& output) {
    return output.kind == OutputKind::Surface && info_of(output.format).has_fineness() &&
           !output.fineness.is_adaptive();
  });
  HeldBytes held(settings);
  for (const MeshNeed& mesh : meshes) {
    const MeshToFit& expected = expected_mesh(mesh);
    std::vector<int> levels = held_levels(settled_for(mesh, outputs));
    for (int& level : levels) level = std::max(0, level - less);
    held.add(RefinedAttributes::of(expected.mesh), expected_counts(mesh), levels,
             solve_bytes(*mesh.ready, settings, outputs), mesh.vertices, writes_levels);
  }
  return held.peak();
}

// Maps of a mesh.
void add_bake(const PolygonMesh& mesh, const Settings& settings, Forecast& forecast) {
  const int level = bake_level(mesh, settings.bake);
  const auto faces = static_cast<std::int64_t>(
      std::ldexp(static_cast<double>(mesh.face_vertices.size()), 2 * (level - 1)));
  forecast.making_bytes += bake_bytes(mesh.face_count() + faces, settings.bake);
  const double side = std::max(settings.bake, kBakeSide);
  const auto maps = static_cast<double>(std::max<std::size_t>(mesh.groups.size(), 1));
  forecast.seconds +=
      1e-6 * (kBakeSeconds * side * side * maps + kPointSeconds * static_cast<double>(faces));
}

// One mesh's, its memory beside HeldBytes.
Forecast forecast_of_mesh(const MeshNeed& need, const Settings& settings,
                          const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes) {
  const MeshToFit& expected = expected_mesh(need);
  const PolygonMesh& mesh = expected.mesh;
  const PreparedMesh& prepared = *expected.prepared;
  const auto attributes = RefinedAttributes::of(mesh);
  Forecast forecast = forecast_by_counts(mesh_counts_of(prepared), settings, outputs, page_bytes);
  const Copies copies = copies_of(mesh, prepared);
  double most = 0, bends = 0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    OutputForecast& file = forecast.outputs[i];
    const PlannedOutput& output = outputs[i];
    if (output.fineness.is_adaptive()) {
      double count = 0;
      for (const Fineness& fineness : output.finenesses())
        count += expected_triangles(mesh, prepared, fineness);
      bends += count;
      most = std::max(most, count);
    } else if (info_of(output.format).has_fineness()) {
      const std::vector<LevelCounts> levels = levels_to(mesh_counts_of(prepared), settings.scheme,
                                                        std::max(level_of(output, settings), 1));
      file.vertices = 0;
      for (const Fineness& fineness : output.finenesses()) {
        const int level = output.coarser.empty() ? level_of(output, settings) : fineness.level;
        file.vertices +=
            levels[level].vertices + (output.kind == OutputKind::Surface ? copies.at(level) : 0);
      }
    }
  }
  const std::uint64_t triangle_bytes = attributes.uvs ? kBendUvBytes : kBendBytes;
  forecast.peak_bytes += triangle_bytes * static_cast<std::uint64_t>(most);
  if (need.vertices != nullptr && most > 0) {
    // Half as many rows as triangles.
    const RideBytes rides =
        ride_bytes(*need.vertices, settings, static_cast<std::uint64_t>(most / 2), 0, true);
    forecast.peak_bytes += rides.rows;
    forecast.making_bytes = rides.making;
  }
  forecast.seconds += 1e-6 * kBendSeconds * bends;
  if (page_bytes > 0 && attributes.uvs) {
    const auto levels = levels_to(mesh_counts_of(prepared), settings.scheme, kPageLevel);
    forecast.peak_bytes +=
        kPageUvBytes * static_cast<std::uint64_t>(page_counts(levels, page_bytes).vertices);
  }
  if (settings.bake > 0) add_bake(mesh, settings, forecast);
  return forecast;
}

}  // namespace

double triangles_of(const PolygonMesh& mesh) {
  return static_cast<double>(std::ssize(mesh.face_vertices) - 2 * std::int64_t{mesh.face_count()});
}

const ReadyFit& expected_fit(const ReadyFit& ready) {
  if (ready.refined) return *ready.refined;
  return ready.paired && ready.is_plainly_halved ? *ready.paired : ready;
}

Forecast forecast_of(std::span<const MeshNeed> meshes, const Settings& settings,
                     const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes,
                     std::uint64_t asset_bytes) {
  Forecast all;
  all.outputs.resize(outputs.size());
  all.peak_bytes = asset_bytes + held_bytes(meshes, settings, outputs);
  double triangles = 0;
  for (const MeshNeed& mesh : meshes) triangles += triangles_of(mesh.ready->input.mesh);
  for (const MeshNeed& mesh : meshes) {
    const double share = triangles_of(mesh.ready->input.mesh) / triangles;
    const Forecast one =
        forecast_of_mesh(mesh, settings, settled_for(mesh, outputs, share), page_bytes);
    all.peak_bytes += one.peak_bytes;
    all.making_bytes = std::max(all.making_bytes, one.making_bytes);
    all.seconds += one.seconds / thread_count();
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      OutputForecast& file = all.outputs[i];
      file.vertices += one.outputs[i].vertices;
      file.faces += one.outputs[i].faces;
    }
  }
  all.peak_bytes += all.making_bytes;
  return all;
}

Forecast forecast_of_points(const PointCloud& cloud, const Settings& settings,
                            const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes) {
  const std::int64_t point_count = std::ssize(cloud.points);
  const std::int64_t first = meshed_at_first(point_count, settings.points);
  const bool few = first < point_count;
  const auto meshed = static_cast<std::int64_t>(few ? kMostSamples * static_cast<double>(first)
                                                    : static_cast<double>(first));
  // A closed mesh of triangles has twice as many faces as vertices; pairs of them are quads.
  const MeshCounts counts{{meshed, 3 * meshed, 2 * meshed}, 6 * meshed};
  Forecast forecast = forecast_by_counts(counts, settings, outputs, page_bytes);
  HeldBytes held(settings);
  held.add({}, counts, held_levels(outputs), solve_bytes(counts.corners, false, settings));
  forecast.outputs.assign(outputs.size(), {});
  const auto carried = few ? static_cast<std::uint64_t>(point_count) : 0;
  const std::uint64_t meshing =
      kCloudFixedBytes + kMesherPointBytes * static_cast<std::uint64_t>(meshed);
  forecast.peak_bytes = std::max(forecast.peak_bytes + held.peak(), meshing) +
                        kCarriedPointBytes * carried + kRiderCopies * rider_bytes(cloud);
  for (const PlannedOutput& output : outputs)
    if (output.fineness.is_adaptive()) forecast.peak_bytes = 0;
  forecast.seconds =
      forecast.seconds / thread_count() + 1e-6 * (kCloudSeconds * static_cast<double>(meshed) +
                                                  kCarriedSeconds * static_cast<double>(carried));
  return forecast;
}

void require_memory_for(std::span<const MeshNeed> meshes, const Settings& settings,
                        const std::vector<PlannedOutput>& outputs) {
  int wanted = 0;
  for (const MeshNeed& mesh : meshes) {
    const int finest = held_levels(settled_for(mesh, outputs)).front();
    require_indices(
        levels_to(mesh_counts_of(*expected_mesh(mesh).prepared), settings.scheme, finest));
    wanted = std::max(wanted, finest);
  }
  const std::uint64_t free = available_memory_bytes();
  const auto need = [&](int level) {
    return held_bytes(meshes, settings, outputs, wanted - level);
  };
  const std::uint64_t needed = need(wanted);
  if (needed <= free) return;
  int fitting = wanted - 1;
  while (fitting >= 0 && need(fitting) > free) --fitting;
  const std::string of = meshes.size() == 1 ? "" : " of " + counted(std::ssize(meshes), "mesh");
  throw Error(ErrorCode::OutOfMemory,
              formatted("level {}{} needs about {} of memory where {} are free; {}", wanted, of,
                        byte_size(needed), byte_size(free),
                        fitting < 0 ? "no level fits"
                                    : formatted("--levels {} fits ({})", fitting,
                                                byte_size(need(fitting)))));
}

}  // namespace planish
