#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/core/output_file.h"
#include "planish/core/raw_vector.h"
#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_fair.h"
#include "planish/distributed/ranks.h"
#include "planish/distributed/read_slices.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// An OutputFile that all ranks write by MPI-IO: it appears whole or not at all, when all agree
/// that everything is there. A job that is killed may leave its temporary, as on one machine: it
/// has a name of its own, so that no other job and no other program's file is touched. Every
/// function is called by all ranks and throws AgreedError{UnwritableOutput} naming the path.
class StagedFile {
 public:
  /// `replaces`: as OutputFile has it.
  StagedFile(const Ranks& ranks, std::string path, bool replaces = true);
  /// Closes, and removes what was not committed.
  ~StagedFile();
  StagedFile(const StagedFile&) = delete;
  StagedFile& operator=(const StagedFile&) = delete;

  /// Each rank its own bytes at its own place.
  void write(std::int64_t offset, std::span<const std::byte> bytes);
  /// Closes, looks whether the file has `bytes` bytes, and agrees on it.
  void close(std::int64_t bytes);
  /// Renames.
  void commit();

 private:
  void fail(const std::string& what) const;

  const Ranks& ranks_;
  std::string path_;
  std::optional<OutputFile> output_;  // on rank 0
  MPI_File file_ = MPI_FILE_NULL;
};

/// The faces of a slice as they stand in a cage's PLY, and the colours of its vertices, which are
/// kept from reading to writing: 17 bytes a quad, 4 a vertex.
struct CageFaces {
  bool has_short_counts = true;  ///< no face of any rank has more than 255 corners
  RawVector<std::byte> bytes;
  bool has_colors = false;  ///< on any rank
  std::vector<std::array<std::uint8_t, 4>> colors;
};

/// Throws AgreedError{InvalidArgument} above 2^31 - 1 vertices, which the file's indices cannot
/// name.
[[nodiscard]] CageFaces encode_cage_faces(const Ranks& ranks, const MeshSlice& slice);

/// The same of faces that are there already: `sizes` of each, then its `corners`, which are numbers
/// of the cage's `vertex_total`.
[[nodiscard]] CageFaces encode_faces(const Ranks& ranks, std::span<const std::int64_t> sizes,
                                     std::span<const std::int64_t> corners,
                                     std::int64_t vertex_total);

/// The cage as `planish fit` writes it: binary little-endian PLY, double positions. `positions`: of
/// the slice's vertices in the order of the file. Throws as StagedFile; not committed yet.
void write_cage(const Ranks& ranks, const Layout& vertices, std::int64_t face_total,
                std::span<const glm::dvec3> positions, const CageFaces& faces,
                const std::vector<std::string>& header, StagedFile& file);

/// Values of owned vertices sent to where they stand in the file.
[[nodiscard]] std::vector<glm::dvec3> in_file_order(const Ranks& ranks, const Layout& vertices,
                                                    std::span<const std::int64_t> file_ids,
                                                    std::span<const glm::dvec3> values);

/// Where the corners of a slice's faces stand among all corners of the file.
struct CornerStarts {
  Layout faces;                      ///< of all slices
  std::vector<std::int64_t> starts;  ///< of each face of this rank's slice
  std::int64_t total = 0;            ///< corners of all ranks
};
/// Throws AgreedError{InvalidArgument} for meshes with holes, whose borders cut polygons of
/// level 1.
[[nodiscard]] CornerStarts corner_starts_of(const Ranks& ranks, const MeshSlice& slice);

/// The cage of a fair surface as it stands in its file, each rank a run of vertices and of faces.
struct FairCage {
  Layout vertices;
  std::vector<glm::dvec3> positions;
  CageFaces faces;
  std::int64_t face_total = 0;
};

/// level_one_mesh() of the whole mesh: each rank makes that of its part, and takes the polygons
/// around its own vertices, faces and edges, which are sent to where they stand in the order of the
/// file. Throws AgreedError{InvalidArgument} for more vertices than a file's indices count.
[[nodiscard]] FairCage make_fair_cage(const Ranks& ranks, const MeshPart& part,
                                      const PartFair& fair, const CornerStarts& corners,
                                      const SharpFeatureOptions& sharp);

}  // namespace planish
