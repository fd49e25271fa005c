#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/distributed/mesh_part.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/check.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

struct RowOptions {
  Weights weights = Weights::DooSabin;
  SharpFeatureOptions sharp;
  std::int64_t block_vertices = kBlockVertices;
  std::function<void()> after_block;  ///< a sign of life
};

/// Rows of entries, one after another.
struct RowEntries {
  std::vector<std::int64_t> offsets{0};
  RawVector<std::int32_t> columns;
  RawVector<double> weights;

  [[nodiscard]] std::int32_t row_count() const {
    return static_cast<std::int32_t>(offsets.size()) - 1;
  }
};

/// The rows of B of a rank's vertices, as summed_limit_masks() has them. Columns below the row
/// count are owned vertices, then places in `ghosts`, then sums, whose own columns are the first
/// two. Entries of a row ascend by number in the file, sums last, and those of a sum go around its
/// face, so that products have the same bits for every rank count. Vertices that no face names have
/// no entries.
struct PartRows : RowEntries {
  RowEntries sums;                       ///< of faces that rows name
  std::vector<std::int64_t> ghosts;      ///< numbers of other ranks' vertices, ascending
  std::vector<glm::dvec3> ghost_points;  ///< where they are
  double spectral_bound = 1;             ///< of all ranks
  std::array<std::int64_t, 4> kinds{};   ///< owned vertices by VertexKind
  bool has_boundary = false;             ///< any rank's

  [[nodiscard]] std::int32_t first_sum() const {
    return row_count() + static_cast<std::int32_t>(ghosts.size());
  }
};

/// The limit masks of each block's sub mesh. Throws AgreedError{UnusableMesh} as require_usable()
/// on the whole mesh, with the file's numbers: each problem is found by the owner of its element.
[[nodiscard]] PartRows make_rows(const Ranks& ranks, const MeshPart& part, const std::string& name,
                                 std::int64_t face_total, const RowOptions& options);

/// What a rank found wrong, with the file's numbers.
struct FoundProblem {
  MeshProblemKind kind;
  std::int64_t element;
  std::string message;
};

/// Throws as require_usable() where any rank found any; all call it.
void require_none(const Ranks& ranks, const std::vector<FoundProblem>& found,
                  const std::string& name);

/// Those of check() on a sub mesh that concern the run [begin, end).
[[nodiscard]] std::vector<FoundProblem> problems_of_run(const MeshPart& part, const SubMesh& sub,
                                                        std::int32_t begin, std::int32_t end,
                                                        const std::vector<MeshProblem>& problems);

/// Tags at owned vertices that name no edge or no used vertex.
[[nodiscard]] std::vector<FoundProblem> unknown_tags(const MeshPart& part);

}  // namespace planish
