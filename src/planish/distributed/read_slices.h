#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/platform/files.h"
#include "planish/core/raw_vector.h"
#include "planish/distributed/ranks.h"
#include "planish/files/formats.h"
#include "planish/files/ply/read_ply.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// What rides on a slice of a mesh, as PolygonMesh has it of a whole one. The flags are the same on
/// all ranks; where one is not set, what it names is empty.
struct SliceAttributes {
  bool has_colors = false, has_uvs = false, has_groups = false;
  std::vector<glm::vec4> colors;          ///< linear RGBA, one per vertex of the slice
  Layout uv_runs;                         ///< the runs of all ranks of the texture coordinates
  std::vector<glm::dvec2> uvs;            ///< those of this rank's run
  std::vector<std::int64_t> face_uvs;     ///< one per corner: a number in the file; -1: none there
  std::vector<FaceGroup> groups;          ///< of the whole mesh, the same on all ranks
  std::vector<std::int32_t> face_groups;  ///< one per face of the slice
};

/// The texts of rank 0, then those of rank 1, ..., on all ranks.
[[nodiscard]] std::vector<std::string> texts_of_all(const Ranks& ranks,
                                                    std::span<const std::string> own);

/// Gives faces their groups: those of all ranks in the order of their first faces, as one reader
/// numbers them; none where no group has a name. `own`: this rank's groups in that order,
/// `face_groups` name one of them for each of its faces.
void settle_groups(const Ranks& ranks, std::span<const FaceGroup> own,
                   std::vector<std::int32_t> face_groups, SliceAttributes& attributes);

/// The slices of what rides on a mesh that rank 0 has, whose vertices, faces and corners go to
/// ranks by these counts (rank 0's; others' are not looked at).
struct ScatterCounts {
  std::span<const std::int64_t> vertices, faces, corners;
};
[[nodiscard]] SliceAttributes scatter_attributes(const Ranks& ranks, const PolygonMesh& mesh,
                                                 const ScatterCounts& counts);

/// A tagged edge.
struct SliceCrease {
  std::int64_t v0, v1;  ///< numbers in the file; on their way to the owners, along the curve
  float sharpness;
  std::int64_t index;  ///< among all creases, in the order of the file
  std::int64_t file_v0 = v0, file_v1 = v1;
};

/// A tagged vertex.
struct SliceCorner {
  std::int64_t vertex;  ///< as those of creases
  float sharpness;
  std::int64_t index;
  std::int64_t file_vertex = vertex;
};

/// What one rank holds of a mesh as it was read: runs of its vertices and faces in the order of the
/// file, which follow those of the rank before.
struct MeshSlice {
  Layout vertices, faces;  ///< the runs of all ranks
  std::vector<glm::dvec3> positions;
  std::vector<std::int64_t> face_offsets{0};
  std::vector<std::int64_t> face_vertices;  ///< numbers in the file, all in range
  std::vector<SliceCrease> creases;
  std::vector<SliceCorner> corners;
  std::vector<std::int64_t> holes;  ///< faces that are not shown; numbers in the file, any rank's
  SliceAttributes attributes;
  std::vector<Warning> warnings;  ///< the same on all ranks

  [[nodiscard]] std::int64_t vertex_total() const { return vertices.back(); }
  [[nodiscard]] std::int64_t face_total() const { return faces.back(); }
  [[nodiscard]] std::int64_t face_count() const {
    return static_cast<std::int64_t>(face_offsets.size()) - 1;
  }
  [[nodiscard]] std::span<const std::int64_t> face(std::int64_t index) const {
    return std::span(face_vertices)
        .subspan(face_offsets[index], face_offsets[index + 1] - face_offsets[index]);
  }
  void add_face(std::span<const std::int64_t> named) {
    face_vertices.insert(face_vertices.end(), named.begin(), named.end());
    face_offsets.push_back(static_cast<std::int64_t>(face_vertices.size()));
  }
};

/// Adds tags behind those of the file; the same on all ranks. Throws AgreedError{UnusableMesh} for
/// one that names no vertex.
void add_tags(const Ranks& ranks, std::span<const CreaseEdge> creases,
              std::span<const CornerVertex> corners, MeshSlice& slice);

/// Takes all tags away, as planish does where they are to be ignored.
void clear_tags(MeshSlice& slice);

/// A file of which ranks read ranges. Throws Error{UnreadableInput} naming the path and the
/// system's reason.
class RangeFile {
 public:
  explicit RangeFile(std::string path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::int64_t size() const { return size_; }
  /// The bytes [begin, end), cut to what the file has when it was opened.
  [[nodiscard]] RawVector<std::byte> read(std::int64_t begin, std::int64_t end) const;

 private:
  std::string path_;
  platform::File file_;
  std::int64_t size_ = 0;
};

/// Finds where records of unknown lengths begin in a range of bytes that may begin inside one.
/// Chains of records are followed from every possible first byte; those that meet something
/// impossible end, others soon merge. Which one is true is told by where the first record really
/// begins, which the range before knows: nothing is guessed.
class RecordChains {
 public:
  /// Behind the record at a place, or below 0 where none can be. Places count from the range's
  /// first byte; records may end behind the range.
  using Next = std::function<std::int64_t(std::int64_t)>;

  /// `candidates`: how many of the first bytes may begin a record.
  RecordChains(std::int64_t range_bytes, std::int64_t candidates, const Next& next);

  /// Where the first record at or behind the range's end begins, counted from there, if the first
  /// at or behind the range's begin is at `start`; below 0 where that chain ends before.
  [[nodiscard]] std::int64_t overhang(std::int64_t start) const;

 private:
  struct Chain {
    std::int64_t end = -1;
    std::int32_t joined = -1;  ///< the chain that it merged with
  };
  std::int64_t range_bytes_;
  std::vector<Chain> chains_;
};

/// What a format that cannot be read in slices may have at most: rank 0 reads it whole.
inline constexpr std::int64_t kMostWholeBytes = std::int64_t{2} << 30;

/// Reads a mesh, each rank a part: binary little-endian PLY and OBJ by ranges of bytes, other
/// formats (and forms of PLY) by rank 0, which sends the slices. Throws AgreedError:
/// UnreadableInput for files that are missing, damaged or cut, InvalidArgument for formats of
/// points and for files above kMostWholeBytes that cannot be read in slices.
[[nodiscard]] MeshSlice read_slices(const Ranks& ranks, const std::string& path,
                                    std::optional<FileFormat> format = std::nullopt);

/// The slices of a mesh that rank 0 has; that of other ranks is not looked at.
[[nodiscard]] MeshSlice scatter_mesh(const Ranks& ranks, const PolygonMesh& mesh);

/// A PLY whose vertices are of a fixed size, and whose last element are the faces with one list.
[[nodiscard]] bool has_sliceable_body(const PlyHeader& header);
[[nodiscard]] MeshSlice read_ply_slices(const Ranks& ranks, const std::string& path,
                                        const PlyHeader& header);
[[nodiscard]] MeshSlice read_obj_slices(const Ranks& ranks, const std::string& path);

}  // namespace planish
