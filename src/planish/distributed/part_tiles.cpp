#include "planish/distributed/part_tiles.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/platform/files.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_fair.h"
#include "planish/files/tiles/tile.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/measure/figures.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"

namespace planish {

namespace fs = std::filesystem;

StagedTileset::StagedTileset(const Ranks& ranks, fs::path document, bool resume, bool replaces)
    : ranks_(ranks), document_(std::move(document)), replaces_(replaces) {
  part_ = document_.parent_path() / path_of(formatted(".{}.part", utf8(document_.filename())));
  agree(ranks_, [&] {
    if (ranks_.rank != 0) return;
    std::error_code error;
    if (!resume) fs::remove_all(part_, error);
    for (const fs::path& folder : {tile_folder(this->document()), records()}) {
      if (!error) fs::create_directories(folder, error);
      if (error)
        throw Error(ErrorCode::UnwritableOutput,
                    utf8(document_) + ": cannot make " + utf8(folder) + ": " + error.message());
    }
  });
}

StagedTileset::~StagedTileset() {
  std::error_code ignored;
  if (ranks_.rank == 0) fs::remove_all(part_, ignored);
}

void StagedTileset::move_into_place() const {
  const auto require = [&](const std::error_code& error) {
    if (error)
      throw Error(ErrorCode::UnwritableOutput,
                  utf8(document_) + ": cannot be put in place: " + error.message());
  };
  const fs::path folder = tile_folder(document_), own_folder = tile_folder(document());
  if (replaces_) {
    std::error_code ignored;
    for (const fs::path& old : {document_, folder})
      if (fs::exists(fs::symlink_status(old, ignored)))
        require(
            platform::rename_file(old, part_ / path_of(utf8(old.filename()) + ".replaced"), true));
  }
  require(
      platform::rename_file(own_folder, folder, true));  // of folders only an empty one is replaced
  const std::error_code error = platform::rename_file(document(), document_, replaces_);
  if (error) (void)platform::rename_file(folder, own_folder, true);
  require(error);
}

void StagedTileset::commit() {
  agree(ranks_, [&] {
    if (ranks_.rank == 0) move_into_place();
  });
}

namespace {

constexpr std::int64_t kRecordsInFolder = 4096;

static_assert(std::is_trivially_copyable_v<WrittenTile>);

struct RecordHead {
  TilesKey key;
  BlockFigures figures;
  std::uint64_t tile_count;
};

static_assert(std::is_trivially_copyable_v<RecordHead>);

void note_folds(const std::vector<FoldedPlace>& places, std::span<const std::int64_t> file_faces,
                std::array<BlockFold, kNamedFolds>& folds) {
  for (std::size_t i = 0; i < places.size(); ++i)
    folds[i] = {file_faces[places[i].face], places[i].position};
}

// Two hashes of a row of numbers, whose sums over all elements do not depend on who adds them.
// Source: S. Vigna's splitmix64.
class ElementHash {
 public:
  explicit ElementHash(std::uint64_t kind) { add(kind); }

  void add(std::uint64_t value) {
    for (std::size_t i = 0; i < 2; ++i) state_[i] = mix(state_[i] ^ value);
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(std::int64_t value) { add(static_cast<std::uint64_t>(value)); }
  void add(const glm::dvec3& p) {
    for (int axis = 0; axis < 3; ++axis) add(p[axis]);
  }
  void add(const std::string& text) {
    add(static_cast<std::uint64_t>(text.size()));
    for (const char c : text) add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
  }
  void add_to(TilesKey& key) const {
    for (std::size_t i = 0; i < 2; ++i) key[i] += state_[i];
  }

 private:
  static std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
  }
  std::uint64_t state_[2] = {1, 2};
};

enum ElementKind : std::uint64_t {
  kVertex,
  kFace,
  kCrease,
  kCorner,
  kHole,
  kOptions,
  kGrid,
  kControlPoint,
  kCurvePoint,
  kColor,
  kFaceAttributes,
  kGroup
};

// Whether the face's first vertex along the curve is: each face is one rank's.
bool is_of_owned(const MeshPart& part, std::int32_t face) {
  return part.first_vertex(face) < part.owned_count();
}

void add_part(const MeshPart& part, std::span<const glm::dvec3> cage, TilesKey& key) {
  for (std::int32_t v = 0; v < part.owned_count(); ++v) {
    ElementHash hash(kVertex);
    hash.add(part.file_ids[v]);
    hash.add(part.positions[v]);
    hash.add(cage[v]);
    hash.add_to(key);
  }
  for (std::int32_t f = 0; f < part.face_count(); ++f) {
    if (!is_of_owned(part, f)) continue;
    ElementHash hash(kFace);
    hash.add(part.face_ids[f]);
    for (const std::int32_t v : part.face(f)) hash.add(part.file_ids[v]);
    hash.add_to(key);
  }
  for (const PartCrease& crease : part.creases) {
    if (crease.v0 < 0 || crease.v0 >= part.owned_count()) continue;
    ElementHash hash(kCrease);
    for (const std::int64_t value : {crease.index, crease.file_v0, crease.file_v1}) hash.add(value);
    hash.add(static_cast<double>(crease.sharpness));
    hash.add_to(key);
  }
  for (const PartCorner& corner : part.corners) {
    ElementHash hash(kCorner);
    hash.add(corner.index);
    hash.add(part.file_ids[corner.vertex]);
    hash.add(static_cast<double>(corner.sharpness));
    hash.add_to(key);
  }
}

// A texture coordinate's number in the file tells where seams are.
void add_riding(const MeshPart& part, TilesKey& key) {
  const PartAttributes& own = part.attributes;
  for (std::int32_t v = 0; v < part.owned_count() && !own.colors.empty(); ++v) {
    ElementHash hash(kColor);
    hash.add(part.file_ids[v]);
    for (int k = 0; k < 4; ++k) hash.add(static_cast<double>(own.colors[v][k]));
    hash.add_to(key);
  }
  for (std::int32_t f = 0; f < part.face_count(); ++f) {
    if (!is_of_owned(part, f) || (own.face_uvs.empty() && own.face_groups.empty())) continue;
    ElementHash hash(kFaceAttributes);
    hash.add(part.face_ids[f]);
    if (!own.face_groups.empty()) hash.add(std::int64_t{own.face_groups[f]});
    for (std::int32_t c = part.face_offsets[f];
         c < part.face_offsets[f + 1] && !own.face_uvs.empty(); ++c) {
      const std::int32_t uv = own.face_uvs[c];
      hash.add(uv < 0 ? std::int64_t{-1} : own.uv_ids[uv]);
      for (int k = 0; k < 2 && uv >= 0; ++k) hash.add(own.uvs[uv][k]);
    }
    hash.add_to(key);
  }
}

// Of a fair surface: at corners of owned vertices, and on their curves.
void add_fair(const MeshPart& part, const PartFair& fair, TilesKey& key) {
  for (std::int32_t f = 0; f < part.face_count(); ++f) {
    for (std::int32_t c = part.face_offsets[f]; c < part.face_offsets[f + 1]; ++c) {
      if (part.face_vertices[c] >= part.owned_count()) continue;
      ElementHash hash(kControlPoint);
      hash.add(part.face_ids[f]);
      hash.add(std::int64_t{c - part.face_offsets[f]});
      hash.add(fair.state[c]);
      hash.add_to(key);
    }
  }
  for (const CurveKey& curve : fair.keys) {
    if (part.local_of(curve.vertex) >= part.owned_count()) continue;
    ElementHash hash(kCurvePoint);
    hash.add(curve.vertex);
    hash.add(curve.other);
    hash.add(fair.state[curve.index]);
    hash.add_to(key);
  }
}

}  // namespace

TilesKey tiles_key(const Ranks& ranks, const MeshPart& part, std::span<const glm::dvec3> cage,
                   const PartTilesOptions& options) {
  TilesKey key{};
  add_part(part, cage, key);
  add_riding(part, key);
  if (options.fair != nullptr) add_fair(part, *options.fair, key);
  MPI_Allreduce(MPI_IN_PLACE, key.data(), 2, MPI_UINT64_T, MPI_SUM, ranks.comm);
  for (const std::int64_t hole : part.holes) {
    ElementHash hash(kHole);
    hash.add(hole);
    hash.add_to(key);
  }
  for (std::size_t i = 0; i < part.attributes.groups.size(); ++i) {
    ElementHash hash(kGroup);
    hash.add(static_cast<std::int64_t>(i));
    hash.add(part.attributes.groups[i].name);
    hash.add(part.attributes.groups[i].material);
    hash.add_to(key);
  }
  const TilesOptions& tiles = options.tiles;
  ElementHash hash(kOptions);
  hash.add(std::string(PLANISH_VERSION));
  hash.add(tiles.gltf.name);
  for (const std::int64_t value :
       {std::int64_t{tiles.level}, tiles.tile_vertices, std::int64_t{tiles.skirts},
        std::int64_t{tiles.gltf.double_sided}, std::int64_t{tiles.gltf.z_up},
        static_cast<std::int64_t>(options.weights),
        static_cast<std::int64_t>(options.sharp.boundary), std::int64_t{options.sharp.use_tags},
        std::int64_t{options.fair != nullptr}, std::int64_t{sizeof(WrittenTile)}})
    hash.add(value);
  hash.add(options.placement.diagonal);
  hash.add(options.placement.centre);
  hash.add_to(key);
  return key;
}

TilesKey tiles_key_on_grid(const TilesKey& key, int doublings) {
  TilesKey result = key;
  ElementHash hash(kGrid);
  hash.add(std::int64_t{doublings});
  hash.add_to(result);
  return result;
}

void note_quality(const QualitySums& sums, std::span<const std::int64_t> file_faces,
                  BlockFigures& figures) {
  figures.area = sums.area;
  figures.folded = sums.folded;
  figures.folded_elsewhere = sums.folded_elsewhere;
  figures.squares = sums.squares;
  figures.largest = sums.largest;
  figures.bending = sums.bending;
  note_folds(sums.places.all(), file_faces, figures.folds);
  note_folds(sums.places.elsewhere(), file_faces, figures.folds_elsewhere);
}

SurfaceQuality quality_of(std::span<const BlockFigures> blocks,
                          std::vector<std::int64_t>& folded_faces) {
  QualitySums sums;
  std::vector<BlockFold> all, elsewhere;
  for (const BlockFigures& block : blocks) {
    sums.add({block.area,
              block.folded,
              block.folded_elsewhere,
              block.squares,
              block.largest,
              block.bending,
              {}});
    for (const BlockFold& fold : block.folds)
      if (fold.face >= 0) all.push_back(fold);
    for (const BlockFold& fold : block.folds_elsewhere)
      if (fold.face >= 0) elsewhere.push_back(fold);
  }
  SurfaceQuality quality = sums.quality();
  std::vector<BlockFold>& named = elsewhere.empty() ? all : elsewhere;
  std::ranges::sort(named, {}, &BlockFold::face);
  named.resize(std::min(named.size(), kNamedFolds));
  for (const BlockFold& fold : named) {
    // A number in the file may be more than 32 bits count.
    quality.folded_places.push_back({-1, fold.position});
    folded_faces.push_back(fold.face);
  }
  return quality;
}

void keep_only_of(const TilesKey& key, const fs::path& tiles, const fs::path& records) {
  const fs::path note = records / "key";
  TilesKey found{};
  std::ifstream file(note, std::ios::binary);
  const bool is_known =
      file.read(reinterpret_cast<char*>(found.data()), sizeof(found)) && found == key;
  file.close();
  std::error_code error;
  if (is_known) {
    // Whoever was killed has left halves of files under names of their own.
    std::vector<fs::path> halves;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(tiles, error))
      if (!entry.is_directory() && !is_tile_name(utf8(entry.path().filename())))
        halves.push_back(entry.path());
    for (const fs::path& half : halves) fs::remove(half, error);
    return;
  }
  for (const fs::path& folder : {tiles, records}) {
    fs::remove_all(folder, error);
    if (!error) fs::create_directories(folder, error);
    if (error)
      throw Error(ErrorCode::UnwritableOutput,
                  utf8(folder) + ": cannot be made anew: " + error.message());
  }
  OutputFile out(note);
  out.write(std::as_bytes(std::span(key)));
  out.commit();
}

fs::path record_path(const fs::path& records, std::int64_t block) {
  return records / std::to_string(block / kRecordsInFolder) / std::to_string(block);
}

void write_record(const fs::path& path, const TilesKey& key, const WrittenBlock& block) {
  const RecordHead head{key, block.figures, block.tiles.size()};
  OutputFile file(path);
  file.write(std::as_bytes(std::span(&head, 1)));
  file.write(std::as_bytes(std::span(block.tiles)));
  file.commit();
}

std::optional<WrittenBlock> read_record(const fs::path& path, const TilesKey& key,
                                        std::size_t tile_count) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  RecordHead head{};
  if (bytes.size() != sizeof(head) + tile_count * sizeof(WrittenTile)) return std::nullopt;
  std::memcpy(&head, bytes.data(), sizeof(head));
  if (head.key != key || head.tile_count != tile_count) return std::nullopt;
  WrittenBlock block{std::vector<WrittenTile>(tile_count), head.figures};
  std::memcpy(static_cast<void*>(block.tiles.data()), bytes.data() + sizeof(head),
              tile_count * sizeof(WrittenTile));
  return block;
}

namespace {

// The surface over a block's faces and those around them (Rings::Whole): of a cage, one point per
// local vertex of the part, or of the control points that the options name.
class BlockSurface {
 public:
  // The faces have been found sound. `limits`: where the whole surface has the part's vertices, by
  // local vertex; none where nothing rides on it. `colors`: DooSabinSurface::take_whole().
  BlockSurface(const MeshPart& part, std::span<const glm::dvec3> cage, const SubMesh& sub,
               const PartTilesOptions& options, std::span<const glm::dvec3> limits = {},
               const std::vector<glm::vec4>& colors = {});
  BlockSurface(const BlockSurface&) = delete;
  BlockSurface& operator=(const BlockSurface&) = delete;

  [[nodiscard]] const DooSabinSurface& surface() const { return *surface_; }

 private:
  PolygonMesh cage_;
  LevelOne level_one_;
  std::optional<DooSabinSurface> surface_;
};

BlockSurface::BlockSurface(const MeshPart& part, std::span<const glm::dvec3> cage,
                           const SubMesh& sub, const PartTilesOptions& options,
                           std::span<const glm::dvec3> limits, const std::vector<glm::vec4>& colors)
    : cage_(sub.mesh) {
  for (std::size_t v = 0; v < sub.vertices.size(); ++v) cage_.positions[v] = cage[sub.vertices[v]];
  EvaluateOptions evaluate;
  evaluate.weights = options.weights;
  evaluate.prepared = prepared_whole(cage_, topology_of_sound(cage_));
  const MeshTopology& topology = *evaluate.prepared->topology;
  evaluate.features = std::make_shared<const SharpFeatures>(
      find_sharp_features(sub.mesh, topology, sub.mesh.positions, options.sharp));
  if (options.fair == nullptr) {
    surface_.emplace(cage_, options.placement, evaluate);
  } else {
    level_one_ = level_one_of(part, *options.fair, sub, topology, *evaluate.features);
    surface_.emplace(cage_, level_one_, evaluate);
  }
  if (limits.empty()) return;
  RawVector<glm::dvec3> of_sub(sub.vertices.size());
  for (std::size_t v = 0; v < of_sub.size(); ++v) of_sub[v] = limits[sub.vertices[v]];
  surface_->take_whole(std::move(of_sub), colors);
}

// A run of the rank's vertices, and the tiles of the faces that begin in it.
struct PlannedBlock {
  std::int32_t begin = 0, end = 0;  // owned vertices
  std::vector<PlannedTile> tiles;   // parents are places in here
  std::int64_t first_tile = 0;      // of the set's
  TileBox box;                      // of the given vertices of its faces
};

// What rank 0 has to know of a tile.
struct TileFact {
  PlannedTile tile;
  WrittenTile written;
  glm::dvec3 origin;
};

constexpr std::int32_t kInOtherBlock = std::numeric_limits<std::int32_t>::max();

class PartTilesWriter {
 public:
  PartTilesWriter(const Ranks& ranks, const fs::path& path, const MeshPart& part,
                  std::span<const glm::dvec3> cage, const PartTilesOptions& options)
      : ranks_(ranks), path_(path), part_(part), cage_(cage), options_(options), maker_(part) {}

  // The tiles of this rank's blocks, and where they stand among all.
  void plan() {
    std::int64_t tile_count = 0;
    agree(ranks_, [&] {
      require_tiles_options(options_.tiles);
      plan_blocks();
      for (const PlannedBlock& block : blocks_) tile_count += std::ssize(block.tiles);
    });
    std::int64_t first = sum_before(ranks_, tile_count);
    total_ = sum_over(ranks_, tile_count);
    block_total_ = sum_over(ranks_, std::ssize(blocks_));
    for (PlannedBlock& block : blocks_) {
      block.first_tile = first;
      first += std::ssize(block.tiles);
      reach_.add(block.box);
    }
    reach_.reach = max_over(ranks_, reach_.reach);
    reach_.largest = max_over(ranks_, reach_.largest);
    key_ = tiles_key(ranks_, part_, cage_, options_);
    find_limits();
    agree(ranks_, [&] {
      require_some();
      if (ranks_.rank != 0) return;
      keep_only_of(key_, tile_folder(path_), options_.records);
      make_folders();
    });
  }

  void write_all() {
    for (int doublings = 0;; ++doublings) {
      const TileGrid grid = reach_.grid(doublings, options_.tiles.gltf);
      bool fits = true;
      agree(ranks_, [&] { fits = try_all(grid, tiles_key_on_grid(key_, doublings)); });
      if (min_over(ranks_, std::int64_t{fits}) == 0) continue;
      for (const PlannedBlock& block : blocks_) origins_.push_back(origin_of(block, grid));
      return;
    }
  }

  // The documents, and the figures of all tiles.
  PartTiles finish() {
    PartTiles result;
    result.blocks = block_total_;
    result.resumed = sum_over(ranks_, resumed_.load());
    std::vector<BlockFigures> own;
    for (const WrittenBlock& block : written_) own.push_back(block.figures);
    const auto figures = gather<BlockFigures>(ranks_, own);
    const auto facts = gather<TileFact>(ranks_, tile_facts());
    agree(ranks_, [&] {
      if (ranks_.rank != 0) return;
      result.file = write_documents(facts);
      for (const BlockFigures& block : figures) {
        result.file.row_count += block.row_count;
        result.file.face_count += block.face_count;
      }
      result.quality = quality_of(figures, result.folded_faces);
    });
    return result;
  }

 private:
  void plan_blocks() {
    const std::int64_t size = options_.tiles.tile_vertices / 4;
    const std::int32_t owned = part_.owned_count();
    const auto block_count = static_cast<std::size_t>((owned + size - 1) / size);
    std::vector<RawVector<std::int32_t>> places(block_count);
    std::vector<TileBox> boxes(block_count);
    for (std::int32_t f = 0; f < part_.face_count(); ++f) {
      const auto named = part_.face(f);
      const std::int32_t first = part_.first_vertex(f);
      if (first >= owned || part_.is_hole(f)) continue;
      const auto b = static_cast<std::size_t>(first / size);
      const glm::dvec3& corner = part_.positions[named.front()];
      if (places[b].empty()) boxes[b] = {corner, corner};
      places[b].push_back(static_cast<std::int32_t>(first % size));
      for (const std::int32_t v : named) boxes[b].add(part_.positions[v]);
    }
    for (std::size_t b = 0; b < block_count; ++b) {
      if (places[b].empty()) continue;
      PlannedBlock& block = blocks_.emplace_back();
      block.begin = static_cast<std::int32_t>(static_cast<std::int64_t>(b) * size);
      block.end = static_cast<std::int32_t>(std::min<std::int64_t>(block.begin + size, owned));
      block.box = boxes[b];
      block.tiles = plan_of(block, std::move(places[b])).tiles;
    }
    written_.resize(blocks_.size());
  }

  // What rides on the surface goes by where that has the vertices of the faces around a vertex, and
  // around those a block does not have all faces; colours by those of the whole surface, too.
  void find_limits() {
    // Of a rank without faces too.
    const bool rides = !part_.attributes.face_uvs.empty() || !part_.attributes.colors.empty();
    if (max_over(ranks_, std::int64_t{rides}) == 0) return;
    glm::vec4 lowest(std::numeric_limits<float>::infinity()), highest(-lowest);
    const std::int32_t owned = part_.owned_count();
    agree(ranks_, [&] {
      limits_.resize(static_cast<std::size_t>(part_.vertex_count()));
      const auto size = static_cast<std::int32_t>(options_.tiles.tile_vertices / 4);
      for (std::int32_t begin = 0; begin < owned; begin += std::min(size, owned - begin)) {
        const std::int32_t end = begin + std::min(size, owned - begin);
        const SubMesh sub = maker_.make(begin, end, Rings::TwoTagged);
        if (sub.faces.empty()) continue;
        const BlockSurface block(part_, cage_, sub, options_);
        const auto limits = vertex_limits(block.surface().patches(), block.surface().state());
        for (std::size_t v = 0; v < limits.size(); ++v)
          if (sub.vertices[v] >= begin && sub.vertices[v] < end)
            limits_[sub.vertices[v]] = limits[v];
        for (const std::int32_t v : sub.mesh.face_vertices) {
          if (part_.attributes.colors.empty()) break;
          const glm::vec4& color = part_.attributes.colors[sub.vertices[v]];
          lowest = glm::min(lowest, color);
          highest = glm::max(highest, color);
        }
      }
    });
    for (int k = 0; k < 4; ++k) {
      lowest[k] = static_cast<float>(min_over(ranks_, double{lowest[k]}));
      highest[k] = static_cast<float>(max_over(ranks_, double{highest[k]}));
    }
    if (lowest.x <= highest.x) colors_ = {lowest, highest};
    const auto of_ghosts = fetch<glm::dvec3>(ranks_, part_.ghosts, part_.layout,
                                             [&](std::int64_t place) { return limits_[place]; });
    std::ranges::copy(of_ghosts, limits_.begin() + owned);
  }

  // With the block's number in the set.
  TilePlan plan_of(const PlannedBlock& block, RawVector<std::int32_t> face_places) const {
    const std::int64_t count = block.end - block.begin;
    TilePlan plan =
        plan_tiles(std::move(face_places),
                   {.place_count = count, .block_vertices = count, .level = options_.tiles.level});
    const std::int64_t number =
        (part_.layout[part_.rank] + block.begin) / (options_.tiles.tile_vertices / 4);
    for (PlannedTile& tile : plan.tiles) tile.block = static_cast<std::int32_t>(number);
    return plan;
  }

  void require_some() const {
    const std::string& name = options_.tiles.gltf.name;
    if (total_ == 0) {
      throw Error(ErrorCode::InvalidArgument,
                  name + ": the surface has no face; 3D Tiles need one");
    }
    if (total_ > std::numeric_limits<std::int32_t>::max()) {
      throw Error(
          ErrorCode::OutOfMemory,
          formatted("{}: {} tiles are more than 32 bits count; take larger ones (--tile-vertices)",
                    name, total_));
    }
  }

  void make_folders() const {
    std::error_code error;
    const auto make = [&](const fs::path& folder) {
      fs::create_directories(folder, error);
      if (error)
        throw Error(ErrorCode::UnwritableOutput,
                    utf8(folder) + ": cannot make the folder: " + error.message());
    };
    constexpr auto kInFolder = static_cast<std::int64_t>(kTilesInFolder);
    for (std::int64_t i = 0; i < total_; i += kInFolder)
      make(tile_folder(path_) / std::to_string(i / kInFolder));
    const std::int64_t blocks = part_.layout.back() / (options_.tiles.tile_vertices / 4) + 1;
    for (std::int64_t i = 0; i < blocks; i += kInFolder)
      make(record_path(options_.records, i).parent_path());
  }

  static glm::dvec3 origin_of(const PlannedBlock& block, const TileGrid& grid) {
    return grid.snap(block.box.centre());
  }

  // False where a tile leaves the reach of the grid. Sub meshes are made one after another, what is
  // in them side by side.
  bool try_all(const TileGrid& grid, const TilesKey& key) {
    const auto at_once =
        static_cast<std::size_t>(std::max(oneapi::tbb::this_task_arena::max_concurrency(), 1));
    std::atomic<bool> fits = true;
    resumed_ = 0;
    for (std::size_t first = 0; first < blocks_.size() && fits; first += at_once) {
      const std::size_t count = std::min(at_once, blocks_.size() - first);
      std::vector<std::optional<SubMesh>> meshes(count);
      for (std::size_t i = 0; i < count; ++i) {
        const PlannedBlock& block = blocks_[first + i];
        auto known = read_record(record_of(block), key, block.tiles.size());
        if (known && has_tiles(block)) {
          written_[first + i] = std::move(*known);
          ++resumed_;
        } else {
          meshes[i] = maker_.make(block.begin, block.end, Rings::Whole);
        }
      }
      parallel_each(count, 1, [&](std::size_t i) {
        if (meshes[i] && !write_block(first + i, *meshes[i], grid)) fits = false;
        meshes[i].reset();
        if (options_.after_block) options_.after_block();
      });
      for (std::size_t i = first; i < first + count && fits; ++i)
        write_record(record_of(blocks_[i]), key, written_[i]);
    }
    return fits;
  }

  [[nodiscard]] fs::path record_of(const PlannedBlock& block) const {
    return record_path(options_.records, block.tiles.front().block);
  }

  [[nodiscard]] fs::path path_of(const PlannedBlock& block, std::size_t tile) const {
    return tile_folder(path_) /
           tile_path(block.tiles[tile], static_cast<std::size_t>(block.first_tile) + tile);
  }

  [[nodiscard]] bool has_tiles(const PlannedBlock& block) const {
    std::error_code ignored;
    for (std::size_t t = 0; t < block.tiles.size(); ++t)
      if (!fs::exists(path_of(block, t), ignored)) return false;
    return true;
  }

  bool write_block(std::size_t index, const SubMesh& sub, const TileGrid& grid) {
    bool fits = true;
    // A thread that waits in here must not begin another block.
    oneapi::tbb::this_task_arena::isolate([&] { fits = write_levels(index, sub, grid); });
    return fits;
  }

  bool write_levels(std::size_t index, const SubMesh& sub, const TileGrid& grid) {
    const PlannedBlock& block = blocks_[index];
    const BlockSurface block_surface(part_, cage_, sub, options_, limits_, colors_);
    const DooSabinSurface& surface = block_surface.surface();
    const TilePlan plan = plan_of(block, places_of(block, sub));
    TilesOptions tiles = options_.tiles;
    tiles.given = sub.mesh.positions;
    std::vector<glm::dvec3> points;
    if (!options_.points.empty())
      for (const std::int32_t vertex : sub.vertices) points.push_back(options_.points[vertex]);
    tiles.points = points;
    WrittenBlock& written = written_[index];
    written = {std::vector<WrittenTile>(plan.tiles.size()), {}};
    for (int level = tiles.level; level >= 1; --level) {
      const DooSabinBlocks blocks(surface, level, nullptr);
      if (level == tiles.level) {
        written.figures.row_count = blocks.rows_of(sub.is_own);
        for (const std::int32_t face : plan.faces)
          written.figures.face_count += blocks.faces_of(face).count;
      }
      const TileSource source{blocks, surface.topology(), plan, grid};
      std::atomic<bool> fits = true;
      parallel_each(plan.tiles.size(), 1, [&](std::size_t t) {
        if (plan.tiles[t].level != level) return;
        const auto made = write_tile(
            source, plan.tiles[t],
            {path_of(block, t), origin_of(block, grid), written.tiles[t].record.error}, tiles);
        if (made) written.tiles[t] = *made;
        if (!made) fits = false;
      });
      if (!fits) return false;
      pass_errors_up(plan.tiles, level, written.tiles);
      if (level == 1) measure(source, sub, written.figures);
    }
    pass_boxes_up(plan.tiles, written.tiles);
    return true;
  }

  void measure(const TileSource& source, const SubMesh& sub, BlockFigures& figures) const {
    const std::vector<std::uint8_t> is_beside = folded_edges(sub.mesh, source.topology).is_beside;
    std::vector<std::int64_t> file_faces;
    for (const std::int32_t face : sub.faces) file_faces.push_back(part_.face_ids[face]);
    // The first tile of a block has all of its faces.
    const std::vector<RowRange> faces = faces_of_tile(source, source.plan.tiles.front());
    note_quality(quality_sums(source.blocks, faces, sub.mesh, is_beside), file_faces, figures);
  }

  [[nodiscard]] RawVector<std::int32_t> places_of(const PlannedBlock& block,
                                                  const SubMesh& sub) const {
    RawVector<std::int32_t> places(sub.faces.size());
    for (std::size_t f = 0; f < places.size(); ++f) {
      const std::int32_t first = part_.first_vertex(sub.faces[f]);
      places[f] = sub.is_own[f] != 0 ? first - block.begin : kInOtherBlock;
    }
    for (const std::int32_t hole : sub.mesh.hole_faces) places[hole] = -1;
    return places;
  }

  [[nodiscard]] std::vector<TileFact> tile_facts() const {
    std::vector<TileFact> facts;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      for (std::size_t t = 0; t < blocks_[b].tiles.size(); ++t) {
        TileFact fact{blocks_[b].tiles[t], written_[b].tiles[t], origins_[b]};
        if (fact.tile.parent >= 0)
          fact.tile.parent += static_cast<std::int32_t>(blocks_[b].first_tile);
        facts.push_back(fact);
      }
    }
    return facts;
  }

  TilesFile write_documents(std::span<const TileFact> facts) const {
    TilePlan plan;
    std::vector<WrittenTile> written;
    std::vector<glm::dvec3> origins(static_cast<std::size_t>(facts.back().tile.block) + 1);
    for (const TileFact& fact : facts) {
      plan.tiles.push_back(fact.tile);
      written.push_back(fact.written);
      origins[fact.tile.block] = fact.origin;
    }
    TilesFile file = sum_of_tiles(plan.tiles, written, options_.tiles.level);
    for (const TilesetText& document :
         documents_of(path_, plan, written, origins, options_.tiles)) {
      OutputFile out(document.path.empty() ? path_ : tile_folder(path_) / document.path);
      out.write(document.text);
      if (document.path.empty() && options_.tiles.gltf.observe)
        options_.tiles.gltf.observe(std::as_bytes(std::span(document.text)));
      out.commit();
      file.byte_count += document.text.size();
    }
    return file;
  }

  const Ranks& ranks_;
  const fs::path& path_;
  const MeshPart& part_;
  std::span<const glm::dvec3> cage_;
  const PartTilesOptions& options_;
  SubMeshMaker maker_;
  std::vector<PlannedBlock> blocks_;
  std::vector<WrittenBlock> written_;
  std::vector<glm::dvec3> origins_;
  std::vector<glm::dvec3> limits_;  // where anything rides: of the vertices here
  std::vector<glm::vec4> colors_;   // of all: the least and the largest numbers
  TileReach reach_;
  TilesKey key_{};
  std::int64_t total_ = 0, block_total_ = 0;
  std::atomic<std::int64_t> resumed_ = 0;
};

}  // namespace

PartTiles write_part_tiles(const Ranks& ranks, const fs::path& path, const MeshPart& part,
                           std::span<const glm::dvec3> cage, const PartTilesOptions& options) {
  PartTilesWriter writer(ranks, path, part, cage, options);
  writer.plan();
  writer.write_all();
  return writer.finish();
}

}  // namespace planish
