#include "planish/files/tiles/tile.h"

#include <oneapi/tbb/parallel_sort.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/files/gltf/gltf_payload.h"

namespace planish {
namespace {

// Based on: J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707, 2004.

constexpr std::size_t kGrain = std::size_t{1} << 13;

struct Place {
  std::uint64_t key;
  std::int32_t point;
  [[nodiscard]] bool operator<(const Place& other) const {
    return key != other.key ? key < other.key : point < other.point;
  }
};

std::uint32_t cell_of(double offset, double side) {
  constexpr double kCells = std::uint32_t{1} << kCurveBits;
  const double at = side > 0 ? offset / side * kCells : 0.0;
  // The comparison is false for what is not finite.
  return at > 0 ? static_cast<std::uint32_t>(std::min(at, kCells - 1)) : 0;
}

}  // namespace

CurveBox curve_box(std::span<const glm::dvec3> points) {
  if (points.empty()) return {};
  const auto [low, high] = point_bounds(points);
  const glm::dvec3 size = high - low;
  return {low, std::max({size.x, size.y, size.z})};
}

std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint32_t axes[3] = {x, y, z};
  constexpr std::uint32_t kTop = std::uint32_t{1} << (kCurveBits - 1);
  // Undoes the turns of the cubes around the cell, from the largest down.
  for (std::uint32_t bit = kTop; bit > 1; bit >>= 1) {
    const std::uint32_t below = bit - 1;
    for (std::uint32_t& axis : axes) {
      if ((axis & bit) != 0) {
        axes[0] ^= below;
      } else {
        const std::uint32_t swapped = (axes[0] ^ axis) & below;
        axes[0] ^= swapped;
        axis ^= swapped;
      }
    }
  }
  // Gray code.
  axes[1] ^= axes[0];
  axes[2] ^= axes[1];
  std::uint32_t flip = 0;
  for (std::uint32_t bit = kTop; bit > 1; bit >>= 1)
    if ((axes[2] & bit) != 0) flip ^= bit - 1;
  std::uint64_t key = 0;
  for (std::uint32_t bit = kCurveBits; bit-- > 0;)
    for (const std::uint32_t axis : axes) key = key << 1 | ((axis ^ flip) >> bit & 1);
  return key;
}

std::uint64_t hilbert_key(const glm::dvec3& point, const CurveBox& box) {
  const glm::dvec3 offset = point - box.lower;
  return hilbert_key(cell_of(offset.x, box.side), cell_of(offset.y, box.side),
                     cell_of(offset.z, box.side));
}

RawVector<std::int32_t> curve_order(std::span<const glm::dvec3> points) {
  const CurveBox box = curve_box(points);
  RawVector<Place> places(points.size());
  parallel_each(points.size(), kGrain, [&](std::int32_t i) {
    places[i] = {hilbert_key(points[i], box), i};
  });
  oneapi::tbb::parallel_sort(places.begin(), places.end());
  RawVector<std::int32_t> order(points.size());
  parallel_each(points.size(), kGrain, [&](std::size_t i) { order[i] = places[i].point; });
  return order;
}

namespace {

constexpr std::size_t kPlanGrain = std::size_t{1} << 13;

RawVector<std::int32_t> places_of_faces(const MeshTopology& topology,
                                        std::span<const std::uint8_t> hidden,
                                        std::span<const std::int32_t> places) {
  RawVector<std::int32_t> face_places(static_cast<std::size_t>(topology.face_count()));
  parallel_each(face_places.size(), kPlanGrain, [&](std::int32_t f) {
    std::int32_t first = std::numeric_limits<std::int32_t>::max();
    for (const std::int32_t vertex : topology.face(f)) first = std::min(first, places[vertex]);
    face_places[f] = !hidden.empty() && hidden[f] != 0 ? -1 : first;
  });
  return face_places;
}

// Ascending faces of each place: a counting sort.
void sort_faces(std::size_t place_count, TilePlan& plan) {
  plan.face_begins.resize(place_count + 1);
  std::ranges::fill(plan.face_begins, 0);
  const auto is_ours = [&](std::int32_t place) {
    return place >= 0 && static_cast<std::size_t>(place) < place_count;
  };
  for (const std::int32_t place : plan.face_places)
    if (is_ours(place)) ++plan.face_begins[place + 1];
  for (std::size_t i = 0; i < place_count; ++i) plan.face_begins[i + 1] += plan.face_begins[i];
  plan.faces.resize(static_cast<std::size_t>(plan.face_begins.back()));
  RawVector<std::int32_t> next(plan.face_begins);
  for (std::size_t f = 0; f < plan.face_places.size(); ++f)
    if (is_ours(plan.face_places[f]))
      plan.faces[next[plan.face_places[f]]++] = static_cast<std::int32_t>(f);
}

void add_tiles(PlannedTile tile, int level, TilePlan& plan) {
  if (plan.faces_of(tile).empty()) return;
  const auto index = static_cast<std::int32_t>(plan.tiles.size());
  plan.tiles.push_back(tile);
  if (tile.level == level) return;
  for (std::int64_t k = 0; k < 4; ++k) {
    const std::int64_t begin = tile.run.first + tile.run.count * k / 4;
    const std::int64_t end = tile.run.first + tile.run.count * (k + 1) / 4;
    add_tiles({.level = tile.level + 1,
               .block = tile.block,
               .quarter = 4 * tile.quarter + static_cast<std::int32_t>(k),
               .run = {begin, end - begin},
               .parent = index},
              level, plan);
  }
}

}  // namespace

TilePlan plan_tiles(const MeshTopology& topology, std::span<const std::uint8_t> hidden,
                    std::span<const std::int32_t> places, const TileCut& cut) {
  return plan_tiles(places_of_faces(topology, hidden, places), cut);
}

TilePlan plan_tiles(RawVector<std::int32_t> face_places, const TileCut& cut) {
  TilePlan plan;
  plan.face_places = std::move(face_places);
  sort_faces(static_cast<std::size_t>(cut.place_count), plan);
  for (std::int64_t first = 0; first < cut.place_count;
       first += cut.block_vertices, ++plan.block_count) {
    add_tiles({.block = plan.block_count,
               .run = {first, std::min(cut.block_vertices, cut.place_count - first)}},
              cut.level, plan);
  }
  return plan;
}

namespace {

// write(range of faces, their part of `values`), where a face has `per_face` of them.
template <class Write>
void for_faces(std::span<const RowRange> ranges, std::size_t per_face,
               RawVector<std::int32_t>& values, const Write& write) {
  std::size_t count = 0;
  for (const RowRange& range : ranges) count += per_face * static_cast<std::size_t>(range.count);
  values.resize(count);
  std::size_t at = 0;
  for (const RowRange& range : ranges) {
    const std::size_t part = per_face * static_cast<std::size_t>(range.count);
    write(range, std::span(values).subspan(at, part));
    at += part;
  }
}

void take_uvs(const SurfaceBlocks& blocks, std::span<const std::int32_t> uvs, SurfaceMesh& mesh) {
  mesh.uvs.resize(uvs.size());
  for (std::size_t i = 0; i < uvs.size();) {
    std::size_t end = i + 1;
    while (end < uvs.size() && uvs[end] == uvs[end - 1] + 1) ++end;
    blocks.uvs({uvs[i], static_cast<std::int64_t>(end - i)},
               std::span(mesh.uvs).subspan(i, end - i));
    i = end;
  }
}

}  // namespace

std::vector<RowRange> faces_of_tile(const TileSource& source, const PlannedTile& tile) {
  const auto of = source.plan.faces_of(tile);
  std::vector<std::int32_t> faces(of.begin(), of.end());
  std::ranges::sort(faces);
  std::vector<RowRange> ranges;
  for (const std::int32_t face : faces) {
    const RowRange range = source.blocks.faces_of(face);
    if (!ranges.empty() && ranges.back().first + ranges.back().count == range.first) {
      ranges.back().count += range.count;
    } else {
      ranges.push_back(range);
    }
  }
  return ranges;
}

TileMesh make_tile(const TileSource& source, const PlannedTile& tile, const glm::dvec3& origin) {
  const DooSabinBlocks& blocks = source.blocks;
  const SurfaceInfo& info = blocks.info();
  TileMesh made;
  SurfaceMesh& mesh = made.mesh;
  mesh.level = info.level;
  const std::vector<RowRange> faces = faces_of_tile(source, tile);
  for_faces(faces, 4, mesh.face_vertices, [&](RowRange range, std::span<std::int32_t> rows) {
    blocks.face_vertices(range, rows);
  });
  made.rows = make_local(mesh.face_vertices);
  mesh.positions.resize(made.rows.size());
  mesh.normals.resize(made.rows.size());
  RowTarget target;
  target.positions = mesh.positions;
  target.normals = mesh.normals;
  if (info.has_colors) {
    mesh.colors.resize(made.rows.size());
    target.colors = mesh.colors;
  }
  made.degenerate = blocks.rows_at(made.rows, target);
  for (glm::dvec3& position : mesh.positions) position = source.grid.snap(position) - origin;
  if (info.uv_count > 0) {
    for_faces(faces, 4, mesh.face_uvs,
              [&](RowRange range, std::span<std::int32_t> uvs) { blocks.face_uvs(range, uvs); });
    take_uvs(blocks, make_local(mesh.face_uvs), mesh);
  }
  if (info.has_groups) {
    mesh.groups = info.groups;
    for_faces(faces, 1, mesh.face_groups, [&](RowRange range, std::span<std::int32_t> groups) {
      blocks.face_groups(range, groups);
    });
  }
  return made;
}

TileBox box_of(const SurfaceMesh& mesh) {
  TileBox box{mesh.positions.front(), mesh.positions.front()};
  for (const glm::dvec3& position : mesh.positions) box.add(position);
  return box;
}

double coarser_error(const SurfaceMesh& mesh) {
  double largest = 0;
  const auto count = static_cast<std::size_t>(mesh.face_count());
  for (std::size_t first = 0; first < count; first += 4) {
    // Child j keeps corner j at its place, the other corners follow: the middle of the edge behind
    // it, the centre, the middle of the edge before it.
    const auto at = [&](std::size_t child, std::size_t place) -> const glm::dvec3& {
      return mesh.positions[mesh.face_vertices[4 * (first + child) + (child + place) % 4]];
    };
    const glm::dvec3 sum = at(0, 0) + at(1, 0) + at(2, 0) + at(3, 0);
    double farthest = glm::length(at(0, 2) - 0.25 * sum);
    for (std::size_t j = 0; j < 4; ++j) {
      const glm::dvec3 middle = 0.5 * (at(j, 0) + at((j + 1) % 4, 0));
      farthest = std::max(farthest, glm::length(at(j, 1) - middle));
    }
    const glm::dvec3 twist = at(0, 0) - at(1, 0) + at(2, 0) - at(3, 0);
    largest = std::max(largest, farthest + 0.25 * glm::length(twist));
  }
  return largest;
}

namespace {

// The lower vertex of each vertex that a skirt hangs from.
class SkirtVertices {
 public:
  SkirtVertices(const TileGrid& grid, double length, SurfaceMesh& mesh)
      : grid_(grid), length_(length), mesh_(mesh) {}

  std::int32_t below(std::int32_t vertex) {
    const auto [entry, is_new] =
        below_.try_emplace(vertex, static_cast<std::int32_t>(mesh_.positions.size()));
    if (is_new) {
      const glm::vec3 normal = mesh_.normals[vertex];
      const glm::dvec3 place = mesh_.positions[vertex] - length_ * glm::dvec3(normal);
      mesh_.positions.push_back(grid_.snap(place));
      mesh_.normals.push_back(normal);
      if (!mesh_.colors.empty()) mesh_.colors.push_back(glm::vec4(mesh_.colors[vertex]));
    }
    return entry->second;
  }

 private:
  const TileGrid& grid_;
  double length_;
  SurfaceMesh& mesh_;
  std::unordered_map<std::int32_t, std::int32_t> below_;
};

// Places of rows among those of the tile.
void find_all(std::span<const std::int32_t> sorted, std::vector<std::int32_t>& rows) {
  for (std::int32_t& row : rows)
    row = static_cast<std::int32_t>(std::ranges::lower_bound(sorted, row) - sorted.begin());
}

}  // namespace

void add_skirts(const TileSource& source, const PlannedTile& tile, double length, TileMesh& made) {
  SurfaceMesh& mesh = made.mesh;
  SkirtVertices skirt(source.grid, length, mesh);
  std::vector<std::int32_t> rows, uvs;
  std::vector<glm::dvec2> values;
  std::int32_t group = 0;
  const auto hang = [&](std::int32_t corner) {
    source.blocks.edge_rows(corner, rows);
    find_all(made.rows, rows);
    if (!mesh.face_uvs.empty()) {
      // Strips have texture coordinates of their own, equal to the edge's.
      source.blocks.edge_uvs(corner, uvs);
      for (std::int32_t& uv : uvs) {
        values.resize(1);
        source.blocks.uvs({uv, 1}, values);
        uv = static_cast<std::int32_t>(mesh.uvs.size());
        mesh.uvs.push_back(values[0]);
      }
    }
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
      const std::int32_t quad[] = {rows[i + 1], rows[i], skirt.below(rows[i]),
                                   skirt.below(rows[i + 1])};
      mesh.face_vertices.insert(mesh.face_vertices.end(), std::begin(quad), std::end(quad));
      if (!mesh.face_uvs.empty()) {
        const std::int32_t uv[] = {uvs[i + 1], uvs[i], uvs[i], uvs[i + 1]};
        mesh.face_uvs.insert(mesh.face_uvs.end(), std::begin(uv), std::end(uv));
      }
      if (!mesh.face_groups.empty()) mesh.face_groups.push_back(std::int32_t{group});
    }
  };
  for (const std::int32_t face : source.plan.faces_of(tile)) {
    if (!mesh.face_groups.empty()) {
      source.blocks.face_groups({source.blocks.faces_of(face).first, 1}, std::span(&group, 1));
    }
    const std::int32_t first = source.topology.first_corner(face);
    for (std::int32_t c = first; c < first + source.topology.face_size(face); ++c) {
      const std::int32_t twin = source.topology.twin(c);
      if (twin < 0) continue;
      const std::int32_t other = source.topology.face_of(twin);
      if (source.plan.face_places[other] >= 0 && !source.plan.holds(tile, other)) hang(c);
    }
  }
}

namespace {

// An estimate is no bound: finer levels were up to 1.1 times as far away on creased models.
constexpr double kErrorShare = 4.0 / 3.0;
// Of the box of the given vertices: the surface between them leaves it by less, as a rule.
constexpr double kReachShare = 1.0 + 1.0 / 16;

// Whole numbers with a sign: of the filter that float positions are packed by, and of 16 bits.
constexpr int kPackedBits = 23, kShortBits = 15;

double largest_of(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

double distance_from_given(const TileSource& source, const TileMesh& made, const glm::dvec3& origin,
                           std::span<const glm::dvec3> given) {
  const std::vector<std::int32_t>& base = source.blocks.info().base_vertices;
  double largest = 0;
  for (std::size_t i = 0; i < made.rows.size(); ++i) {
    const auto row = static_cast<std::size_t>(made.rows[i]);
    if (row >= base.size()) break;  // rows ascend
    const glm::dvec3 read = origin + glm::dvec3(glm::vec3(made.mesh.positions[i]));
    const double distance = glm::length(read - given[base[row]]);
    largest = std::max(
        largest, std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity());
  }
  return largest;
}

std::vector<std::byte> glb_of(const TileMesh& made, const PlannedTile& tile, const TileGrid& grid,
                              const GltfOptions& options) {
  GltfOptions gltf;
  gltf.compression = options.compression;
  gltf.grid_step = grid.step();
  gltf.materials = options.materials;
  gltf.image_folder = kTileImages;
  gltf.name = options.name + " " + tile_name(tile);
  gltf.double_sided = options.double_sided;
  gltf.z_up = options.z_up;
  gltf.extras = {{"planish", std::string(PLANISH_VERSION)}, {"level", std::int64_t{tile.level}}};
  // A thread that waits here must not begin another tile.
  return oneapi::tbb::this_task_arena::isolate([&] { return encode_glb(made.mesh, gltf); });
}

std::string extras_of(const GltfOptions& options) {
  nlohmann::json json;
  for (const auto& [key, value] : options.extras)
    std::visit([&, &name = key](const auto& held) { json[name] = held; }, value);
  return json.is_null() ? "" : json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void TileReach::add(const TileBox& block) {
  reach = std::max(reach, largest_of(block.half()));
  largest = std::max({largest, largest_of(block.lower), largest_of(block.upper)});
}

TileGrid TileReach::grid(int doublings, const GltfOptions& options) const {
  const double share = std::ldexp(kReachShare, doublings);
  const double coarsest = coarsest_step(options.position_error);
  const auto of_bits = [&](int bits, double coarsest_of_bits) {
    return TileGrid(share * reach, 2 * share * largest, bits, coarsest_of_bits);
  };
  switch (options.compression) {
    case GltfCompression::Meshopt:
      return of_bits(kPackedBits, coarsest);
    case GltfCompression::Quantize:
      if (const TileGrid shorts = of_bits(kShortBits, 0); shorts.step() <= coarsest) return shorts;
      break;
    case GltfCompression::None:
      break;
  }
  return of_bits(TileGrid::kFloatBits, 0);
}

std::optional<WrittenTile> write_tile(const TileSource& source, const PlannedTile& tile,
                                      const TilePlace& place, const TilesOptions& options) {
  TileMesh made = make_tile(source, tile, place.origin);
  WrittenTile written;
  written.record.error = place.error;
  written.largest_distance = distance_from_given(
      source, made, place.origin, options.points.empty() ? options.given : options.points);
  // Those of a finer level are others, and its own once more.
  if (tile.level == options.level) written.degenerate = made.degenerate;
  if (tile.level > 1) written.coarser_error = kErrorShare * coarser_error(made.mesh);
  const double gap = tile.level == options.level ? written.coarser_error : place.error;
  if (options.skirts && gap > 0) add_skirts(source, tile, gap, made);
  TileRecord& record = written.record;
  record.box = box_of(made.mesh);
  if (std::max(largest_of(record.box.lower), largest_of(record.box.upper)) > source.grid.reach())
    return std::nullopt;
  OutputFile file(place.path);
  const std::vector<std::byte> bytes = glb_of(made, tile, source.grid, options.gltf);
  file.write(bytes);
  file.commit();
  record.bytes = bytes.size();
  record.vertex_count = made.mesh.positions.size();
  record.triangle_count = 2 * static_cast<std::uint64_t>(made.mesh.face_count());
  return written;
}

void pass_errors_up(std::span<const PlannedTile> tiles, int level, std::span<WrittenTile> written) {
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    if (tiles[i].level != level || tiles[i].parent < 0) continue;
    TileRecord& above = written[tiles[i].parent].record;
    above.error = std::max({above.error, written[i].coarser_error, written[i].record.error});
  }
}

void pass_boxes_up(std::span<const PlannedTile> tiles, std::span<WrittenTile> written) {
  // Children come behind their parents.
  for (std::size_t i = tiles.size(); i-- > 0;) {
    const std::int32_t parent = tiles[i].parent;
    if (parent >= 0) written[parent].record.box.add(written[i].record.box);
  }
}

TilesFile sum_of_tiles(std::span<const PlannedTile> tiles, std::span<const WrittenTile> written,
                       int level) {
  TilesFile file;
  for (int l = 1; l <= level; ++l) file.levels.emplace_back().level = l;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const TileRecord& record = written[i].record;
    TileLevel& at = file.levels[tiles[i].level - 1];
    ++at.tiles;
    at.bytes += record.bytes;
    at.vertex_count += record.vertex_count;
    at.triangle_count += record.triangle_count;
    at.geometric_error = std::max(at.geometric_error, record.error);
    file.byte_count += record.bytes;
    file.largest_distance = std::max(file.largest_distance, written[i].largest_distance);
    file.degenerate.add(written[i].degenerate);
  }
  return file;
}

void require_tiles_options(const TilesOptions& options) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, options.gltf.name + ": " + what);
  };
  if (options.level < 1) refuse("3D Tiles have levels from 1 on");
  if (options.tile_vertices < kLeastTileVertices) {
    refuse(formatted("tiles of {} vertices; {} are the least", options.tile_vertices,
                     kLeastTileVertices));
  }
}

std::vector<TilesetText> documents_of(const std::filesystem::path& path, const TilePlan& plan,
                                      std::span<const WrittenTile> written,
                                      std::span<const glm::dvec3> origins,
                                      const TilesOptions& options) {
  std::vector<TileRecord> records;
  records.reserve(written.size());
  for (const WrittenTile& tile : written) records.push_back(tile.record);
  return tileset_documents(plan, records, origins,
                           {.folder = utf8(tile_folder(path).filename()),
                            .z_up = options.gltf.z_up,
                            .extras = extras_of(options.gltf)});
}

}  // namespace planish
