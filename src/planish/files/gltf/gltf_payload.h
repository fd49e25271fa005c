#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/raw_vector.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/surface/mesh_blocks.h"

namespace planish {

/// Component types by their numbers in the format.
enum class GltfComponent : int {
  Byte = 5120,
  UnsignedByte = 5121,
  Short = 5122,
  UnsignedShort = 5123,
  UnsignedInt = 5125,
  Float = 5126
};

/// Where an array lies when EXT_meshopt_compression has packed it.
struct GltfStream {
  std::uint64_t offset = 0, bytes = 0;
  std::string_view mode;             ///< "ATTRIBUTES" or "TRIANGLES"
  std::string_view filter = "NONE";  ///< "OCTAHEDRAL", "EXPONENTIAL"
};

/// An accessor and the buffer view that it has for itself.
struct GltfArray {
  std::string_view type;  ///< "SCALAR", "VEC2" ...
  GltfComponent component = GltfComponent::Float;
  std::uint64_t count = 0;
  bool normalized = false, is_indices = false;
  std::optional<FloatBox> bounds;       ///< smallest and largest numbers as they are stored
  std::uint64_t offset = 0, bytes = 0;  ///< decoded, where there is a stream
  std::uint32_t stride = 0;             ///< 0: without gaps
  std::optional<GltfStream> stream;
};

/// Triangles by their arrays, and the names of their group, which may be empty.
struct GltfPrimitive {
  std::map<std::string, std::size_t> attributes;
  std::size_t indices = 0;
  std::string name, material;
  std::int32_t group = -1;     ///< of the surface; -1: it has none
  bool encodes_ngons = false;  ///< see GltfOptions::ngon_groups
};

/// A surface on its way into a file: a mesh with its place, and the bytes that its arrays name.
struct GltfPayload {
  std::vector<GltfArray> arrays;
  std::vector<GltfPrimitive> primitives;
  std::uint64_t vertex_count = 0, triangle_count = 0;  ///< of all primitives
  std::uint64_t buffer_bytes = 0;       ///< of all arrays, each padded to a multiple of 4
  std::uint64_t decoded_bytes = 0;      ///< of the buffer that streams stand for; 0: none does
  std::vector<std::string> extensions;  ///< required by readers
  bool shares_materials = false;        ///< primitives of one material's name have it together
  glm::dvec3 translation{0.0};
  double scale = 1.0;
  /// Its buffer, piece by piece, where it has been made already; else write_plain() sends it.
  std::vector<RawVector<std::byte>> pieces;
  std::function<void(std::span<const ByteSink>)> write_plain;

  void write(std::span<const ByteSink> sinks) const;
};

/// Surveys the surface, and packs it where it is to be compressed: a large one by blocks of
/// kPackedFaces, a primitive each (or one for each group), all on one grid. The same bytes for any
/// number of threads. Calls options.decoded. Surface and options must outlive it. Throws as
/// encode_glb(); where `is_glb` before the work, if it cannot fit.
[[nodiscard]] GltfPayload payload_of(const SurfaceBlocks& surface, const GltfOptions& options,
                                     bool is_glb);

/// Some faces of a surface, to be written by themselves.
class GltfBlock {
 public:
  /// `options` are those of the whole; its callbacks are not taken.
  GltfBlock(const SurfaceBlocks& surface, RowRange faces, const GltfOptions& options);
  GltfBlock(const GltfBlock&) = delete;
  GltfBlock& operator=(const GltfBlock&) = delete;

  [[nodiscard]] const FaceRangeBlocks& surface() const { return surface_; }
  [[nodiscard]] const GltfVertices& vertices() const { return vertices_; }
  [[nodiscard]] GltfOptions& options() { return options_; }
  [[nodiscard]] std::uint64_t buffer_bytes() const { return buffer_bytes_; }
  /// Uncompressed; adds the rows whose normals are those of facets. This must outlive it. Throws as
  /// gltf_survey().
  [[nodiscard]] GltfPayload payload(DegenerateRows& degenerate) const;

 private:
  void take_further(GltfAttribute& attribute);

  FaceRangeBlocks surface_;
  GltfVertices vertices_;
  GltfOptions options_;
  std::list<std::vector<float>> values_;  // of options_.attributes
  std::list<std::vector<UvOnRow>> further_;
  std::list<std::vector<glm::dvec2>> uvs_;  // of options_.further_uvs
  std::uint64_t buffer_bytes_ = 0;
};

/// So many faces, from `first` on, that their buffer is no larger than options.buffer_bytes, or
/// one. `surface_bytes`: of all in one buffer.
[[nodiscard]] RowRange faces_of_buffer(const SurfaceBlocks& surface, std::int64_t first,
                                       std::uint64_t surface_bytes, const GltfOptions& options);

/// Of the progress of writing: where the survey ends, and where all is packed if it is.
inline constexpr double kGltfSurveyed = 0.35, kGltfPacked = 0.97;

/// Smallest and largest float32 coordinates as stored, of each primitive, and the normals that are
/// those of facets.
struct GltfSurvey {
  std::vector<FloatBox> bounds;
  DegenerateRows degenerate;
};
/// Throws Error{InvalidArgument} for a position that float32 cannot hold and a normal that is not
/// of unit length, by its number in `surface_rows` where the surface is a part of another.
[[nodiscard]] GltfSurvey gltf_survey(const SurfaceBlocks& surface, const GltfVertices& vertices,
                                     const GltfOptions& options,
                                     std::span<const std::int32_t> surface_rows = {});
/// The bounds alone. Warns "degenerate-normals".
[[nodiscard]] std::vector<FloatBox> gltf_bounds(const SurfaceBlocks& surface,
                                                const GltfVertices& vertices,
                                                const GltfOptions& options);

/// Most vertices that 16-bit indices are used for. One less than their largest value, which some
/// graphics interfaces take for a primitive restart.
inline constexpr std::uint64_t kMaxShortIndexVertices = 65534;

/// Bytes up to a multiple of four, on which every array of a buffer starts.
[[nodiscard]] inline std::uint64_t padded(std::uint64_t bytes) { return (bytes + 3) / 4 * 4; }

/// "TEXCOORD_1" of set 1.
[[nodiscard]] inline std::string uv_name(int set) { return "TEXCOORD_" + std::to_string(set); }
/// 1 of "TEXCOORD_1"; -1: it is no such name.
[[nodiscard]] int uv_set(std::string_view attribute);

/// Fields and attributes of the options, as they are written.
[[nodiscard]] std::vector<GltfAttribute> row_attributes(const GltfOptions& options);

/// Where the arrays of a surface lie in its uncompressed buffer. First, each for all primitives in
/// turn: POSITION (float32 x 3), NORMAL (float32 x 3), TEXCOORD_0, TEXCOORD_1 ... (float32 x 2) of
/// those that have any, COLOR_0 (float32 x 4) where there are any, row_attributes(), of which
/// integers that are fewer than a multiple of 4 bytes have zeros behind them; then the triangle
/// indices of each primitive, in 16 bits where those do.
[[nodiscard]] GltfPayload plain_payload(const SurfaceInfo& info, const GltfVertices& vertices,
                                        const GltfOptions& options);
/// The bounds that the format wants: `positions`, of each primitive, and those of morph targets.
void set_bounds(GltfPayload& payload, std::span<const FloatBox> positions,
                const GltfVertices& vertices, const GltfOptions& options);

/// Sends the buffer of plain_payload() to the sinks in pieces of about a MB, in order, the survey
/// being done.
/// Throws Error{Cancelled} and whatever a sink throws.
void write_buffer(const SurfaceBlocks& surface, const GltfVertices& vertices,
                  const GltfOptions& options, std::span<const ByteSink> sinks);

/// The step of the coarsest grid on which every position moves by `error` at most, half a step in
/// each of three directions.
[[nodiscard]] double coarsest_step(double error);

/// Whole numbers for all positions: node.translation and node.scale carry the grid.
struct PositionGrid {
  glm::dvec3 origin{0.0};
  double step = 0;  ///< 0: float32 stays

  [[nodiscard]] glm::vec3 place(const glm::vec3& position) const {
    return glm::vec3(glm::round((glm::dvec3(position) - origin) / step));
  }
};

/// For packing positions within these bounds as coarse as options.position_error leaves room for,
/// else in 16 bits where those do.
[[nodiscard]] PositionGrid position_grid(const FloatBox& all, const GltfOptions& options);

/// Calls options.kept_float, if it is there and positions within these bounds stay float32.
void tell_kept_float(const GltfOptions& options, const FloatBox& bounds);

/// The exponent of the coarsest grid 2^e on which every number moves by less than `error` / sqrt(3)
/// and has 24 bits: vectors of three then move by less than `error`. Empty where float32 has no
/// more room than such a grid, or `error` is 0.
[[nodiscard]] std::optional<int> grid_exponent(std::span<const float> numbers, double error);

/// Numbers as the meshopt filter "EXPONENTIAL" decodes them, mantissa * 2^exponent, all with one
/// exponent: of 12-byte vectors only the low bytes then change from one to the next.
[[nodiscard]] RawVector<std::uint32_t> on_grid(std::span<const float> numbers, int exponent);

/// Unit vectors as the filter "OCTAHEDRAL" decodes them to int16 x 4: `width` 3, the fourth 0, or
/// 4, which is kept. 14 bits turn them by at most 0.02 degrees.
[[nodiscard]] RawVector<std::int16_t> octahedral(std::span<const float> vectors, std::size_t width);

/// The same as int16 x 4 normalised.
[[nodiscard]] RawVector<std::int16_t> short_vectors(std::span<const float> vectors,
                                                    std::size_t width);

/// Numbers from 0 to 1 as uint16, 65535 for 1.
[[nodiscard]] RawVector<std::uint16_t> unit_shorts(std::span<const float> numbers);

/// Bytes of the meshopt vertex codec, version 0. `size` bytes a vertex, a multiple of 4 up to 256.
[[nodiscard]] RawVector<std::byte> encode_vertices(std::span<const std::byte> vertices,
                                                   std::size_t size);
/// Bytes of the meshopt index codec, version 1.
[[nodiscard]] RawVector<std::byte> encode_triangles(std::span<const std::uint32_t> indices,
                                                    std::size_t vertex_count);

/// What a reader gets from on_grid() and encode_vertices().
[[nodiscard]] RawVector<glm::vec3> decode_grid(std::span<const std::byte> encoded,
                                               std::size_t count);
/// The same without the filter.
[[nodiscard]] RawVector<glm::vec3> decode_vectors(std::span<const std::byte> encoded,
                                                  std::size_t count);

/// Triangles and vertices in an order in which neighbours follow each other.
struct StripOrder {
  RawVector<std::uint32_t> indices;       ///< of the triangles, naming vertices in the new order
  RawVector<std::uint32_t> new_vertices;  ///< by old vertex; every vertex has one
};

/// Triangles in strips, blocks of them on all threads, then vertices as triangles first use them;
/// those that none uses come last. The result does not depend on the threads.
/// Source: meshoptimizer's vertex cache optimiser for strips.
[[nodiscard]] StripOrder strip_order(std::span<const std::uint32_t> indices,
                                     std::size_t vertex_count);

/// Packs a plain payload, whose buffer is its only piece, as options.compression says (see
/// write_gltf.h) and hands the decoded positions to options.decoded. `bounds` are those of all
/// positions that lie on one grid: those of the payload's, or of more. The same bytes for any
/// number of threads.
[[nodiscard]] GltfPayload pack_gltf(GltfPayload plain, const GltfVertices& vertices,
                                    const GltfOptions& options, const FloatBox& bounds);
[[nodiscard]] FloatBox bounds_of_all(const GltfPayload& payload);

/// A glTF on its way into a file: its JSON, and what writes the buffer that this names. An asset's
/// begins with what it keeps (asset/gltf_asset.h), any other with nothing (plain_document()).
struct GltfDocument {
  /// Of a list, the places that new elements take: those that are free, then those behind it.
  struct Places {
    std::set<std::int64_t> free;
    std::int64_t next(nlohmann::json& list);
  };

  nlohmann::json json = nlohmann::json::object();
  Places accessors, views;
  std::set<std::string> extensions;         ///< required of readers by the surfaces in it
  std::vector<std::uint64_t> full_buffers;  ///< bytes of each before the last one
  std::uint64_t buffer_bytes = 0;           ///< of the last, so far
  std::uint64_t decoded_bytes = 0;          ///< of the buffer that streams stand for
  std::uint64_t vertex_count = 0, triangle_count = 0;  ///< of all surfaces
  /// Write the parts of the only buffer, in order, each padded to a multiple of four.
  std::vector<std::function<void(std::span<const ByteSink>)>> parts;

  /// Puts bytes, which must outlive it, behind the others. Returns where in the buffer.
  std::uint64_t keep(std::span<const std::byte> bytes);
  /// The same with a buffer view, whose number it returns.
  std::int64_t add_view(std::span<const std::byte> bytes);
  /// Accessors and buffer views of a surface, whose bytes come behind the others: whoever adds it
  /// adds that part. Returns the accessor of each array.
  std::vector<std::int64_t> add(const GltfPayload& payload);
  /// Sets its buffers. The text, keys sorted, with URIs for the buffers of a .gltf at that path, or
  /// with an empty one for the chunk of a GLB, without white space. Text that is not UTF-8 and
  /// non-finite numbers become U+FFFD and null.
  [[nodiscard]] std::string text(const std::filesystem::path& gltf);
};

/// "asset" with the options' extras, which also say what packing has done.
[[nodiscard]] nlohmann::json asset_json(const GltfOptions& options);

/// `rest` with attributes, morph targets and indices of a primitive, whose arrays have these
/// accessors.
[[nodiscard]] nlohmann::json primitive_json(const GltfPrimitive& primitive,
                                            std::span<const std::int64_t> accessors,
                                            nlohmann::json rest);

/// A document of surfaces alone: a node and a mesh for each, of several in a buffer of its own, and
/// plain materials.
[[nodiscard]] GltfDocument plain_document(std::span<const GltfPayload> surfaces,
                                          const GltfOptions& options);

/// Writes a .glb, or a .gltf and its buffer, by extension. The buffer comes first: the document is
/// nothing without it. Warns of large ones; reports "write" as done. Throws
/// Error{UnwritableOutput}; for a .glb Error{InvalidArgument} from 4 GiB on.
GltfFile write_document(const std::filesystem::path& path, GltfDocument document,
                        const GltfOptions& options);
/// The same as a GLB in memory.
[[nodiscard]] std::vector<std::byte> encode_document(GltfDocument document,
                                                     const GltfOptions& options);

/// The text of a document, or what stands before a GLB's buffer; GltfOptions::observe gets it too.
void write_text(OutputFile& file, std::string_view text, const GltfOptions& options);

/// Bytes in pieces, and zeros up to a multiple of four.
void write_padded(std::span<const std::byte> bytes, std::span<const ByteSink> sinks);

/// Bytes of the GLB of a JSON text (before padding) and a buffer.
/// Throws Error{InvalidArgument} naming `name` where they do not fit a GLB's 32-bit length.
[[nodiscard]] std::uint64_t glb_byte_count(std::uint64_t json_bytes, std::uint64_t buffer_bytes,
                                           std::string_view name);

/// A file name as a relative URI: all but letters, digits and -._~ percent-encoded.
[[nodiscard]] std::string encode_uri(std::string_view file_name);

}  // namespace planish
