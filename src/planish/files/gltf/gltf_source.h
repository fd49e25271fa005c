#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/json_fwd.h"
#include "planish/core/raw_vector.h"
#include "planish/files/formats.h"

namespace planish {

/// A value of a JSON document that knows its place, for messages like
/// `a.gltf: accessors[3].count: -1 is no integer from 1`. Every member throws
/// Error{UnreadableInput} when the value is not what is asked for. The document must live longer.
class JsonPlace {
 public:
  JsonPlace(const nlohmann::json& value, std::string_view file, std::string path)
      : value_(&value), file_(file), path_(std::move(path)) {}

  [[nodiscard]] JsonPlace operator[](std::string_view key) const;
  [[nodiscard]] JsonPlace operator[](std::int64_t index) const;
  /// Empty when the object has no such key.
  [[nodiscard]] std::optional<JsonPlace> find(std::string_view key) const;

  [[nodiscard]] std::int64_t array_size() const;
  /// At least `least`, at most 2^53, which JSON numbers carry exactly.
  [[nodiscard]] std::int64_t integer(std::int64_t least = 0) const;
  [[nodiscard]] double number() const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] const std::string& text() const;
  [[nodiscard]] bool is_text() const;
  [[nodiscard]] bool is_object() const;

  /// The keys of an object, in order.
  [[nodiscard]] std::vector<std::string> keys() const;
  [[nodiscard]] const nlohmann::json& value() const { return *value_; }

  /// Members with a value to use where they are missing.
  [[nodiscard]] std::int64_t integer_or(std::string_view key, std::int64_t otherwise) const;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// As messages begin: `FILE: PATH`.
  [[nodiscard]] std::string named() const;
  [[noreturn]] void fail(const std::string& what) const;
  /// With formatted() text.
  template <class... Values>
  requires(sizeof...(Values) > 0)
      [[noreturn]] void fail(FormatText<sizeof...(Values)> format, const Values&... values) const {
    fail(formatted(format, values...));
  }

 private:
  [[nodiscard]] std::string clipped() const;

  const nlohmann::json* value_;
  std::string_view file_;
  std::string path_;
};

/// Parses JSON text that is nested no deeper than 64 levels.
/// Throws Error{UnreadableInput} with line and column.
[[nodiscard]] nlohmann::json parse_json(std::string_view text, std::string_view file);

/// A glTF file's document, and a GLB's binary chunk.
struct GlbParts {
  std::string_view json;
  std::span<const std::byte> chunk;
  FileFormat format = FileFormat::Gltf;
};

/// Takes a GLB apart; other files are all document. Throws Error{UnreadableInput}.
[[nodiscard]] GlbParts split_glb(std::span<const std::byte> bytes, std::string_view name);

/// How much a scene may hold.
struct GltfLimits {
  /// Triangle corners, points, texture coordinates and normals: what int32 counts.
  std::int64_t corners = (std::int64_t{1} << 31) - 1;
  std::uint64_t memory_bytes = 0;  ///< 0: what the machine has free when the first is counted
};

/// Counts what a scene holds before memory is taken for it: a few bytes of nodes can place any
/// number of triangles. Every member throws Error{UnreadableInput} naming `place` past the limits
/// of counts, Error{OutOfMemory} past that of memory.
class GltfBudget {
 public:
  GltfBudget(const GltfLimits& limits, std::string_view file) : limits_(limits), file_(file) {}

  /// A primitive's, each time that a node places it.
  void add_triangles(const JsonPlace& place, std::int64_t vertices, std::int64_t corners);
  void add_points(const JsonPlace& place, std::int64_t points);
  void add_uvs(const JsonPlace& place, std::int64_t uvs);
  void add_normals(const JsonPlace& place, std::int64_t normals);
  /// Of further attributes.
  void add_numbers(const JsonPlace& place, std::int64_t numbers);

 private:
  void add(const JsonPlace& place, std::int64_t& total, std::int64_t count, const char* what) const;
  void take(const JsonPlace& place, std::int64_t count, std::uint64_t bytes_each);

  GltfLimits limits_;
  std::string file_;
  std::int64_t corners_ = 0, uvs_ = 0, normals_ = 0;
  std::int64_t largest_ = 0;                  // vertices of a primitive
  std::uint64_t bytes_ = 0, free_bytes_ = 0;  // free: 0 before it is asked for
};

/// Binary data of a glTF document, fetched when first asked for: a GLB's chunk, data URIs, and
/// files that the document names, where `file` has a path.
class GltfSource {
 public:
  GltfSource(JsonPlace root, std::span<const std::byte> glb_chunk, const FileBytes& file)
      : root_(std::move(root)), glb_chunk_(glb_chunk), path_(file.path), reach_(file.reach) {}

  /// The bytes of buffer `index`: exactly its byteLength. Throws Error{UnreadableInput}.
  [[nodiscard]] std::span<const std::byte> buffer(std::int64_t index);
  /// The bytes of a buffer view, which lie within its buffer; unpacked where they are packed.
  [[nodiscard]] std::span<const std::byte> view(std::int64_t index);
  /// The bytes that a URI stands for: data, or a file as read_named() gives it.
  [[nodiscard]] std::span<const std::byte> fetch(const JsonPlace& uri);
  /// True the first time that it is asked of an accessor: what is looked at once for all its uses.
  [[nodiscard]] bool is_new_sparse(std::int64_t accessor) {
    return sparse_accessors_.insert(accessor).second;
  }

 private:
  // Of a file the first bytes, as many as are wanted; empty: all, which are not too many.
  [[nodiscard]] std::span<const std::byte> fetch(const JsonPlace& uri,
                                                 std::optional<std::uint64_t> wanted);
  // Of a data URI.
  [[nodiscard]] std::span<const std::byte> decoded(const JsonPlace& uri);
  // Of a buffer view, or of its packed stream.
  [[nodiscard]] std::span<const std::byte> part(const JsonPlace& place);

  JsonPlace root_;
  std::span<const std::byte> glb_chunk_;
  std::filesystem::path path_;
  FileReach reach_;
  // By URI, and of files by what was wanted of them, so that none is read twice.
  std::map<std::string, RawVector<std::byte>> decoded_;
  std::map<std::pair<std::string, std::optional<std::uint64_t>>, RawVector<std::byte>> files_;
  std::map<std::int64_t, RawVector<std::byte>> unpacked_;  // by buffer view
  std::set<std::int64_t> sparse_accessors_;
};

/// Decodes base64 (RFC 4648) with or without its padding; empty if `text` is none.
[[nodiscard]] std::optional<std::vector<std::byte>> decode_base64(std::string_view text);

/// Text with what its percent signs stand for; one that two hexadecimal digits do not follow stands
/// for itself, as in names that no program has encoded.
[[nodiscard]] std::string decode_percents(std::string_view text);

[[nodiscard]] inline bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }
/// The bytes of a data URI (RFC 2397), base64 or percent-encoded; empty if it is none.
[[nodiscard]] std::optional<std::vector<std::byte>> decode_data_uri(std::string_view uri);

/// The path that a URI without a scheme stands for, with slashes for backslashes; empty where it
/// has one or names nothing.
[[nodiscard]] std::optional<std::string> decode_uri_path(std::string_view uri);

/// All files that the glTF at `path` names, there or not. Of a file that is none: nothing.
[[nodiscard]] std::vector<std::filesystem::path> gltf_named_files(
    const std::filesystem::path& path);

/// The extension of a buffer view whose bytes are packed.
inline constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";

/// Unpacks `stream` as `extension`, the EXT_meshopt_compression object of a buffer view, says:
/// count * byteStride bytes. Sizes are held against the most that so many bytes can stand for
/// before memory is taken. Throws Error{UnreadableInput}.
[[nodiscard]] RawVector<std::byte> decode_meshopt(const JsonPlace& extension,
                                                  std::span<const std::byte> stream);

/// The extension of a primitive whose corners and attributes are packed.
inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// Elements that stood packed, one behind the other.
struct UnpackedElements {
  std::int64_t count = 0, number_count = 0;  ///< elements, numbers of each
  std::int64_t component = 0;                ///< componentType of an accessor that holds them
  RawVector<std::byte> bytes;
};

/// What a Draco stream holds.
struct DracoMesh {
  UnpackedElements corners;                                ///< three of each triangle, in 32 bits
  std::map<std::int64_t, UnpackedElements> by_identifier;  ///< attributes, each with point_count
};

/// How much a stream must hold: what the accessors say.
struct DracoCounts {
  std::int64_t corner_count, point_count;
};

/// False: files that require the extension are refused.
[[nodiscard]] bool reads_draco();

/// Unpacks a mesh of Draco's bitstream 2.2. Its counts must be `wanted`, and no larger than so many
/// bytes may stand for, before memory is taken. `extension` stands in messages. Throws
/// Error{UnreadableInput}.
[[nodiscard]] DracoMesh decode_draco(const JsonPlace& extension, std::span<const std::byte> stream,
                                     const DracoCounts& wanted);

/// A typed array whose every element lies within its buffer view.
class GltfAccessor {
 public:
  /// Vectors: of one to four numbers each. Matrices: of 4 by 4, by columns.
  enum class Use {
    Positions,
    Normals,
    Indices,
    TextureCoordinates,
    Colors,
    Numbers,
    Vectors,
    Matrices
  };

  /// Checks everything before any element can be asked for: component and element type for the
  /// use, count, offset, stride, and the same of the elements that a sparse accessor has in the
  /// place of others. The elements come from `unpacked` where it is given, which must live longer
  /// and cannot be sparse. Without a buffer view they are zeros, where the format has it so;
  /// indices of zero alone are refused. Throws Error{UnreadableInput}.
  GltfAccessor(const JsonPlace& root, std::int64_t index, Use use, GltfSource& source,
               const UnpackedElements* unpacked = nullptr);

  [[nodiscard]] std::int64_t count() const { return count_; }
  /// Of Use::Positions and Use::Normals; normalised integers are scaled. May not be finite.
  [[nodiscard]] glm::dvec3 position(std::int64_t index) const;
  /// Of Use::TextureCoordinates. May not be finite.
  [[nodiscard]] glm::dvec2 texture_coordinate(std::int64_t index) const;
  /// Of Use::Colors, opaque where there is no alpha. May not be finite.
  [[nodiscard]] glm::vec4 color(std::int64_t index) const;
  /// Of Use::Numbers. May not be finite.
  [[nodiscard]] double value(std::int64_t index) const { return number(index, 0); }
  /// Of Use::Vectors and Use::Matrices: the k-th of number_count().
  [[nodiscard]] double value(std::int64_t index, std::int64_t k) const { return number(index, k); }
  [[nodiscard]] std::int64_t number_count() const { return number_count_; }
  /// Whole numbers that are not scaled to parts of 1.
  [[nodiscard]] bool is_integer() const { return component_ != Float && !normalized_; }
  /// Those without a sign, below 2^16.
  [[nodiscard]] bool is_short() const {
    return !normalized_ && (component_ == UByte || component_ == UShort);
  }
  /// Of Use::Indices.
  [[nodiscard]] std::uint32_t index(std::int64_t index) const;

 private:
  enum Component {
    Byte = 5120,
    UByte = 5121,
    Short = 5122,
    UShort = 5123,
    UInt = 5125,
    Float = 5126
  };

  void use_view(const JsonPlace& root, const JsonPlace& place, GltfSource& source);
  void use_elements(const JsonPlace& place, const UnpackedElements& unpacked);
  void use_sparse(const JsonPlace& root, const JsonPlace& place, std::int64_t index,
                  GltfSource& source);
  void require_ascending(const JsonPlace& indices) const;
  [[nodiscard]] std::uint32_t sparse_index(std::int64_t place) const;
  [[nodiscard]] std::span<const std::byte> element(std::int64_t index) const;
  [[nodiscard]] double component(std::span<const std::byte> bytes) const;
  // The k-th number of an element.
  [[nodiscard]] double number(std::int64_t index, std::int64_t k) const;

  std::span<const std::byte> bytes_;  // empty: zeros, but for sparse elements
  // Elements in the place of others: their numbers, ascending, and the elements, packed tightly.
  std::span<const std::byte> sparse_indices_, sparse_values_;
  std::int64_t sparse_count_ = 0, sparse_index_bytes_ = 0;
  std::int64_t count_ = 0, stride_ = 0, component_bytes_ = 0, number_count_ = 0;
  Component component_ = Float;
  bool normalized_ = false;
};

}  // namespace planish
