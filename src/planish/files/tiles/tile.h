#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// A box in which points are placed on the curve: a cube at its lower corner.
struct CurveBox {
  glm::dvec3 lower{0.0};
  double side = 0;  ///< 0: all points coincide
};

/// Cells along each side of the cube.
inline constexpr std::uint32_t kCurveBits = 21;

[[nodiscard]] CurveBox curve_box(std::span<const glm::dvec3> points);

/// The place of a cell on Hilbert's curve through a cube of 2^21 cells a side, 63 bits: cells that
/// follow one another share a face. Coordinates must be below 2^21.
/// Source: J. Skilling, "Programming the Hilbert curve", 2004.
[[nodiscard]] std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// The key of a point's cell; points beside the box count as on its sides.
[[nodiscard]] std::uint64_t hilbert_key(const glm::dvec3& point, const CurveBox& box);

/// The numbers of all points by their places on the curve, those of one cell ascending: a total
/// order, the same for every number of threads. Takes 16 bytes a point on the way.
[[nodiscard]] RawVector<std::int32_t> curve_order(std::span<const glm::dvec3> points);

/// A run of the curve at one level, with at least one face.
struct PlannedTile {
  int level = 1;
  std::int32_t block = 0;    ///< the run of level 1 that it lies in
  std::int32_t quarter = 0;  ///< its place among those of its level in the block
  RowRange run;              ///< of places on the curve
  std::int32_t parent = -1;  ///< the tile of the level below; -1 at level 1
};

/// Which faces of a mesh are in which tile: what depends on the mesh and the sizes alone.
struct TilePlan {
  /// The place on the curve of each face's first vertex there; -1: a hole. Places behind the last
  /// one are those of faces in tiles of others.
  RawVector<std::int32_t> face_places;
  RawVector<std::int32_t> faces;        ///< by these places, then ascending
  RawVector<std::int32_t> face_begins;  ///< place_count + 1: where those of a place begin
  std::int32_t block_count = 0;
  /// Blocks one after another, in each a tile before its children, these in their order.
  std::vector<PlannedTile> tiles;

  [[nodiscard]] std::span<const std::int32_t> faces_of(const PlannedTile& tile) const {
    return faces_in(tile.run);
  }
  [[nodiscard]] std::span<const std::int32_t> faces_in(RowRange run) const {
    const std::int32_t begin = face_begins[run.first];
    return std::span(faces).subspan(begin, face_begins[run.first + run.count] - begin);
  }
  [[nodiscard]] bool holds(const PlannedTile& tile, std::int32_t face) const {
    const std::int32_t place = face_places[face];
    return place >= tile.run.first && place < tile.run.first + tile.run.count;
  }
};

/// How faces are cut into tiles.
struct TileCut {
  std::int64_t place_count = 0;     ///< places on the curve
  std::int64_t block_vertices = 0;  ///< of each run of it
  int level = 1;                    ///< the finest
};

/// Tiles of levels 1 to `level`: blocks are runs of `block_vertices` places on the curve, the
/// children of a tile are the quarters of its run. A face belongs to the first of its vertices, of
/// which `places` says where they are; tiles without faces are left out. `hidden` has one flag a
/// face, or nothing.
[[nodiscard]] TilePlan plan_tiles(const MeshTopology& topology,
                                  std::span<const std::uint8_t> hidden,
                                  std::span<const std::int32_t> places, const TileCut& cut);

/// The same of faces that have their places already; those from place_count on are seen, but in
/// tiles of others.
[[nodiscard]] TilePlan plan_tiles(RawVector<std::int32_t> face_places, const TileCut& cut);

/// The grid that all positions of a tile set lie on: multiples of a power of two, so that their
/// differences to a tile's origin are float32 numbers without rounding, and two tiles have the same
/// place for the same point.
class TileGrid {
 public:
  /// Float32's.
  static constexpr int kFloatBits = 24;

  /// Positions may be `reach` away from their tile's origin and `largest` from the model's. The
  /// step is no finer than needed for numbers of `bits` and a sign, nor than `coarsest` / 2, where
  /// that is larger.
  TileGrid(double reach, double largest, int bits = kFloatBits, double coarsest = 0)
      : bits_(bits),
        step_(std::ldexp(1.0, std::max({exponent_of(reach) + 1 - bits, coarsest_exponent(coarsest),
                                        exponent_of(largest) + 1 - kDoubleBits}))) {}

  [[nodiscard]] double step() const { return step_; }
  /// As far from a tile's origin as such numbers hold all multiples.
  [[nodiscard]] double reach() const { return std::ldexp(step_, bits_) - step_; }
  [[nodiscard]] glm::dvec3 snap(const glm::dvec3& position) const {
    return {snap(position.x), snap(position.y), snap(position.z)};
  }

 private:
  static constexpr int kDoubleBits = 53;
  static constexpr double kSmallest = 1e-30;  // of a model of no size; floats end at 1e-38

  [[nodiscard]] static int exponent_of(double length) {
    return std::ilogb(std::max(length, kSmallest));
  }

  // Division and product by a power of two are exact.
  [[nodiscard]] double snap(double value) const { return std::nearbyint(value / step_) * step_; }

  [[nodiscard]] static int coarsest_exponent(double coarsest) {
    return coarsest > 0 ? std::ilogb(coarsest) : std::numeric_limits<int>::min();
  }

  int bits_;
  double step_;
};

/// Which numbers occur, by words of 64 that follow one another: rows come in runs, so that words
/// are few, and who looks for one finds it in a near cache.
class NumberWords {
 public:
  NumberWords() : table_(1024) {}

  /// Notes a number and returns its word's slot.
  std::int32_t note(std::int32_t number) {
    const std::int32_t word = number >> kBits;
    if (word != last_word_) {
      last_slot_ = slot_of(word);
      last_word_ = word;
    }
    masks_[last_slot_] |= std::uint64_t{1} << (number & kMask);
    return last_slot_;
  }

  /// All numbers, ascending; from now on place() knows theirs.
  RawVector<std::int32_t> sort() {
    const RawVector<std::int32_t> order = slots_by_word();
    first_.resize(words_.size());
    std::int32_t count = 0;
    for (const std::int32_t slot : order) {
      first_[slot] = count;
      count += std::popcount(masks_[slot]);
    }
    RawVector<std::int32_t> found;
    found.reserve(static_cast<std::size_t>(count));
    for (const std::int32_t slot : order)
      for (std::uint64_t left = masks_[slot]; left != 0; left &= left - 1)
        found.push_back((words_[slot] << kBits) + std::countr_zero(left));
    return found;
  }

  /// The place of a noted number among all, behind sort().
  [[nodiscard]] std::int32_t place(std::int32_t number, std::int32_t slot) const {
    const std::uint64_t below = (std::uint64_t{1} << (number & kMask)) - 1;
    return first_[slot] + std::popcount(masks_[slot] & below);
  }

 private:
  static constexpr int kBits = 6;
  static constexpr std::int32_t kMask = (1 << kBits) - 1;

  struct Entry {
    std::int32_t word = -1, slot = 0;
  };

  std::int32_t slot_of(std::int32_t word) {
    Entry* entry = &entry_of(word);
    if (entry->word >= 0) return entry->slot;
    // At most half full.
    if (2 * (words_.size() + 1) > table_.size()) {
      table_.assign(2 * table_.size(), {});
      for (std::size_t i = 0; i < words_.size(); ++i)
        entry_of(words_[i]) = {words_[i], static_cast<std::int32_t>(i)};
      entry = &entry_of(word);
    }
    *entry = {word, static_cast<std::int32_t>(words_.size())};
    words_.push_back(word);
    masks_.push_back(0);
    return entry->slot;
  }

  // Open addressing; where runs lie is mixed, for they begin at multiples of each other's lengths.
  Entry& entry_of(std::int32_t word) {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ull;  // 2^64 over the golden ratio
    const std::size_t mask = table_.size() - 1;
    std::size_t at = static_cast<std::uint64_t>(word) * kGolden >> 32 & mask;
    while (table_[at].word >= 0 && table_[at].word != word) at = (at + 1) & mask;
    return table_[at];
  }

  // By digits of words, which have 25 bits, the least first.
  [[nodiscard]] RawVector<std::int32_t> slots_by_word() const {
    constexpr int kDigitBits = 9, kDigits = 3;
    constexpr std::size_t kBuckets = std::size_t{1} << kDigitBits;
    RawVector<std::int32_t> order(words_.size()), other(words_.size());
    std::iota(order.begin(), order.end(), 0);
    for (int d = 0; d < kDigits; ++d) {
      std::vector<std::size_t> places(kBuckets + 1, 0);
      const auto digit = [&](std::int32_t slot) {
        return static_cast<std::size_t>(words_[slot] >> (d * kDigitBits)) & (kBuckets - 1);
      };
      for (const std::int32_t slot : order) ++places[digit(slot) + 1];
      std::partial_sum(places.begin(), places.end(), places.begin());
      for (const std::int32_t slot : order) other[places[digit(slot)]++] = slot;
      order.swap(other);
    }
    return order;
  }

  std::vector<Entry> table_;
  RawVector<std::int32_t> words_, first_;
  RawVector<std::uint64_t> masks_;
  std::int32_t last_word_ = -1, last_slot_ = 0;
};

/// Replaces numbers (of rows, not negative) by their places among those that occur, which it
/// returns in ascending order.
[[nodiscard]] inline RawVector<std::int32_t> make_local(std::span<std::int32_t> numbers) {
  NumberWords words;
  RawVector<std::int32_t> slots(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) slots[i] = words.note(numbers[i]);
  RawVector<std::int32_t> found = words.sort();
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = words.place(numbers[i], slots[i]);
  return found;
}

/// Smallest and largest coordinates.
struct TileBox {
  glm::dvec3 lower{0.0}, upper{0.0};

  void add(const TileBox& other) {
    lower = glm::min(lower, other.lower);
    upper = glm::max(upper, other.upper);
  }
  void add(const glm::dvec3& point) { add({point, point}); }
  [[nodiscard]] glm::dvec3 centre() const { return 0.5 * (lower + upper); }
  [[nodiscard]] glm::dvec3 half() const { return 0.5 * (upper - lower); }
};

/// What all tiles of a level are made of.
struct TileSource {
  const DooSabinBlocks& blocks;
  const MeshTopology& topology;
  const TilePlan& plan;
  const TileGrid& grid;
};

/// A tile as it is written.
struct TileMesh {
  SurfaceMesh mesh;              ///< about the tile's origin, on the grid
  RawVector<std::int32_t> rows;  ///< the surface's row of each vertex, ascending
  DegenerateRows degenerate;
};

/// The descendants of a tile's faces, ascending.
[[nodiscard]] std::vector<RowRange> faces_of_tile(const TileSource& source,
                                                  const PlannedTile& tile);

/// The faces of a tile with their rows in the surface's order and all attributes. The same bits as
/// the surface in one piece, but for the grid.
[[nodiscard]] TileMesh make_tile(const TileSource& source, const PlannedTile& tile,
                                 const glm::dvec3& origin);

[[nodiscard]] TileBox box_of(const SurfaceMesh& mesh);

/// Of the vertices of some faces, one at least; `point(vertex)` says where they are.
template <class Point>
[[nodiscard]] TileBox box_of_faces(const MeshTopology& topology,
                                   std::span<const std::int32_t> faces, const Point& point) {
  const glm::dvec3& first = point(topology.face(faces.front()).front());
  TileBox box{first, first};
  for (const std::int32_t face : faces)
    for (const std::int32_t vertex : topology.face(face)) box.add(point(vertex));
  return box;
}

/// How far the quads of level l - 1 are from those of a mesh of level l >= 2, which come four by
/// four in its place: the largest distance of a middle or a centre from its place on the bilinear
/// quad, and a quarter of the quad's twist. An estimate of their distance from the limit surface.
[[nodiscard]] double coarser_error(const SurfaceMesh& mesh);

/// Adds strips of that length along the tile's edges to others, against the normals: what shows
/// through a gap between tiles of different levels is the surface. Not along the surface's own
/// boundary.
void add_skirts(const TileSource& source, const PlannedTile& tile, double length, TileMesh& made);

/// A tile that has been written.
struct TileRecord {
  TileBox box;       ///< about its block's origin
  double error = 0;  ///< its geometricError; 0 of the last level
  std::uint64_t bytes = 0, vertex_count = 0, triangle_count = 0;
};

/// Tiles in a folder; one that grows beyond that slows file systems and viewers of folders.
inline constexpr std::size_t kTilesInFolder = 4096;
/// Blocks of one document; a set of more has a document for each group of so many.
inline constexpr std::size_t kBlocksInDocument = 64;

/// Where tiles find the images that they share, as a relative URI, and their folder in the set's.
inline constexpr const char* kTileImages = "../images/";
inline constexpr const char* kImageFolder = "images";

/// Where a tile's file lies in the set's folder: "0/12-2-3.glb", the block, the level and the place
/// among those of its level in the block. `index`: among all tiles of the set.
[[nodiscard]] std::string tile_path(const PlannedTile& tile, std::size_t index);
/// "12-2-3" of it.
[[nodiscard]] std::string tile_name(const PlannedTile& tile);

/// Whether a name may stand in a set's folder, or in a folder of that: "0", "images" and
/// "group-0.json", or "12-2-3.glb".
[[nodiscard]] bool is_tileset_entry(std::string_view name);
[[nodiscard]] bool is_tile_name(std::string_view name);
/// Whether it may stand in the folder of images: "3.png".
[[nodiscard]] bool is_image_name(std::string_view name);
/// The first thing in a set's folder that no set has there; empty if there is none.
[[nodiscard]] std::filesystem::path foreign_in_tiles(const std::filesystem::path& folder);

struct TilesetText {
  std::string path;  ///< in the set's folder; empty: the document itself
  std::string text;
};

struct TilesetOptions {
  std::string folder;  ///< its name
  bool z_up = false;   ///< the content is turned upright, see GltfOptions
  std::string extras;  ///< of the asset, as JSON
};

/// The documents of a set of 3D Tiles 1.1: those of groups first, where there are several, the
/// document itself last. Of the plan only its tiles count; `origins` are those of the blocks. Tiles
/// of one block are a tree with refine REPLACE, whose root carries the origin as its transform;
/// what stands above is empty. Volumes hold their children's, errors never fall below theirs.
/// Source: OGC 22-025r4, "3D Tiles Specification 1.1".
[[nodiscard]] std::vector<TilesetText> tileset_documents(const TilePlan& plan,
                                                         std::span<const TileRecord> tiles,
                                                         std::span<const glm::dvec3> origins,
                                                         const TilesetOptions& options);

/// How far the given vertices of a set's blocks are from their middles, and from the model's
/// origin: what the grid of all positions follows from.
struct TileReach {
  double reach = 0, largest = 0;

  /// The box of the given vertices of a block's faces.
  void add(const TileBox& block);
  /// The surface between the vertices leaves their boxes: by a sixteenth, twice as much with each
  /// doubling.
  /// Compressed positions have as many bits as the form of `options` has, and may be as coarse as
  /// its position_error allows.
  [[nodiscard]] TileGrid grid(int doublings, const GltfOptions& options) const;
};

/// What is known of a tile once it is written.
struct WrittenTile {
  TileRecord record;
  double coarser_error = 0;     ///< of the level before in its place
  double largest_distance = 0;  ///< of a given vertex from its place
  DegenerateRows degenerate;
};

/// Where a tile goes.
struct TilePlace {
  std::filesystem::path path;
  glm::dvec3 origin{0.0};  ///< of its block
  double error = 0;        ///< its geometricError, which its children have told
};

/// Makes a tile and writes it: a function of the faces of its block, those around them, and of what
/// the whole set shares. Of the options level, skirts, given and gltf count, as TilesOptions says.
/// Nothing where the tile leaves the reach of its grid. Throws as write_tiles().
[[nodiscard]] std::optional<WrittenTile> write_tile(const TileSource& source,
                                                    const PlannedTile& tile, const TilePlace& place,
                                                    const TilesOptions& options);

/// Makes the errors of the parents of a level's tiles no smaller than theirs, and than what those
/// say of the level before.
void pass_errors_up(std::span<const PlannedTile> tiles, int level, std::span<WrittenTile> written);
/// Makes volumes hold those of children.
void pass_boxes_up(std::span<const PlannedTile> tiles, std::span<WrittenTile> written);

/// The figures of a set of these tiles; those of the finest level in one piece are left out.
[[nodiscard]] TilesFile sum_of_tiles(std::span<const PlannedTile> tiles,
                                     std::span<const WrittenTile> written, int level);

/// Throws Error{InvalidArgument} for a level, size or compression that tiles cannot have.
void require_tiles_options(const TilesOptions& options);

/// The documents of a set, as tileset_documents(); `path` is that of the document itself.
[[nodiscard]] std::vector<TilesetText> documents_of(const std::filesystem::path& path,
                                                    const TilePlan& plan,
                                                    std::span<const WrittenTile> written,
                                                    std::span<const glm::dvec3> origins,
                                                    const TilesOptions& options);

}  // namespace planish
