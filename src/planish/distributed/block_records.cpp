#include "planish/distributed/block_records.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <string>
#include <system_error>
#include <type_traits>

#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/version.h"
#include "planish/files/tiles/tileset.h"

namespace planish {

namespace fs = std::filesystem;

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
      if (!entry.is_directory() && !is_tile_name(entry.path().filename().string()))
        halves.push_back(entry.path());
    for (const fs::path& half : halves) fs::remove(half, error);
    return;
  }
  for (const fs::path& folder : {tiles, records}) {
    fs::remove_all(folder, error);
    if (!error) fs::create_directories(folder, error);
    if (error)
      throw Error(ErrorCode::UnwritableOutput,
                  folder.string() + ": cannot be made anew: " + error.message());
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

}  // namespace planish
