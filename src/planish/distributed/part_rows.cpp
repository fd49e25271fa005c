// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", equation (1): the
// rows of B, made by the same functions as on one machine, block by block.
#include "planish/distributed/part_rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "planish/core/assert.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/sound_topology.h"

namespace planish {

namespace {

class RowMaker {
 public:
  RowMaker(const MeshPart& part, const RowOptions& options)
      : part_(part), options_(options), maker_(part) {}

  void add_block(std::int32_t begin, std::int32_t end) {
    const SubMesh sub = maker_.make(begin, end);
    std::optional<MeshTopology> topology = sound_topology(sub.mesh);
    if (!topology && !sub.faces.empty()) {
      const std::vector<MeshProblem> problems = list_problems(sub.mesh);
      // The vertices of a block may well be at one place.
      const auto is_harmless = [](const MeshProblem& problem) {
        return problem.kind == MeshProblemKind::NoExtent;
      };
      if (!std::ranges::all_of(problems, is_harmless)) {
        note(begin, end, sub, problems);
      } else {
        topology.emplace(sub.mesh);
      }
    }
    if (topology && !sub.faces.empty()) {
      if (const auto problem = too_large_summed_masks(*topology)) note(begin, end, sub, {*problem});
    }
    if (is_sound_) add_rows(begin, end, sub, std::move(topology));
  }

  [[nodiscard]] const std::vector<FoundProblem>& found() const { return found_; }
  [[nodiscard]] bool is_sound() const { return is_sound_; }

  // Columns to ghosts that rows name, and nothing but those.
  PartRows finish() {
    const std::int32_t owned = part_.owned_count(), count = part_.vertex_count();
    // By local vertex, then by sum.
    std::vector<std::int32_t> places(part_.file_ids.size(), -1);
    for (const RowEntries* table : std::initializer_list<const RowEntries*>{&rows_, &rows_.sums})
      for (const std::int32_t column : table->columns)
        if (column < count) places[column] = 0;
    for (std::int32_t v = 0; v < count; ++v) {
      if (v >= owned && places[v] < 0) continue;
      places[v] = v < owned ? v : owned + static_cast<std::int32_t>(rows_.ghosts.size());
      if (v < owned) continue;
      rows_.ghosts.push_back(part_.ghosts[v - owned]);
      rows_.ghost_points.push_back(part_.positions[v]);
    }
    const std::int32_t first_sum = rows_.first_sum();
    for (RowEntries* table : std::initializer_list<RowEntries*>{&rows_, &rows_.sums})
      for (std::int32_t& column : table->columns)
        column = column < count ? places[column] : first_sum + (column - count);
    return std::move(rows_);
  }

 private:
  void note(std::int32_t begin, std::int32_t end, const SubMesh& sub,
            const std::vector<MeshProblem>& problems) {
    const auto found = problems_of_run(part_, sub, begin, end, problems);
    found_.insert(found_.end(), found.begin(), found.end());
    is_sound_ = false;
  }

  void add_rows(std::int32_t begin, std::int32_t end, const SubMesh& sub,
                std::optional<MeshTopology> topology) {
    if (sub.faces.empty()) {
      rows_.offsets.resize(rows_.offsets.size() + (end - begin), rows_.offsets.back());
      return;
    }
    const SharpFeatures features =
        find_sharp_features(sub.mesh, *topology, sub.mesh.positions, options_.sharp);
    const Subdivision subdivision(*topology, features, options_.weights);
    const SummedTable table = summed_limit_masks(subdivision);
    const StencilTable& masks = table.rows;
    const auto vertex_count = static_cast<std::int32_t>(sub.vertices.size());
    const std::int32_t per_face = face_sum_rule(options_.weights).sum_count();
    std::vector<std::int32_t> large;
    for (std::int32_t f = 0; f < topology->face_count(); ++f)
      if (topology->face_size(f) >= kSummedRing) large.push_back(f);
    rows_.spectral_bound =
        std::min(rows_.spectral_bound, spectral_bound(sub.mesh, options_.weights));
    row_of_.assign(static_cast<std::size_t>(end - begin), -1);
    for (std::size_t v = 0; v < sub.vertices.size(); ++v)
      if (sub.vertices[v] >= begin && sub.vertices[v] < end)
        row_of_[sub.vertices[v] - begin] = static_cast<std::int32_t>(v);
    for (const std::int32_t row : row_of_) {
      if (row >= 0) {
        rows_.has_boundary |= topology->is_boundary_vertex(row);
        ++rows_.kinds[static_cast<std::size_t>(features.vertex_kinds[row])];
        for (std::int32_t k = masks.offsets[row]; k < masks.offsets[row] + masks.sizes[row]; ++k) {
          const std::int32_t source = masks.indices[k];
          const std::int32_t sum = source - vertex_count;
          rows_.columns.push_back(
              sum < 0 ? sub.vertices[source]
                      : column_of_sum(sub, large[sum / per_face], table.sums, sum, per_face));
          rows_.weights.push_back(masks.weights[k]);
        }
      }
      rows_.offsets.push_back(static_cast<std::int64_t>(rows_.columns.size()));
    }
  }

  // The column of a sum of a block's face; those of a face are the same for all blocks, and made
  // once.
  std::int32_t column_of_sum(const SubMesh& sub, std::int32_t face, const StencilTable& sums,
                             std::int32_t sum, std::int32_t per_face) {
    const std::int32_t first = sum / per_face * per_face;
    const auto [at, is_new] =
        sums_of_face_.try_emplace(sub.faces[face], part_.vertex_count() + rows_.sums.row_count());
    for (std::int32_t s = first; is_new && s < first + per_face; ++s) {
      for (std::int32_t k = sums.offsets[s]; k < sums.offsets[s] + sums.sizes[s]; ++k) {
        rows_.sums.columns.push_back(sub.vertices[sums.indices[k]]);
        rows_.sums.weights.push_back(sums.weights[k]);
      }
      rows_.sums.offsets.push_back(static_cast<std::int64_t>(rows_.sums.columns.size()));
    }
    return at->second + sum - first;
  }

  const MeshPart& part_;
  const RowOptions& options_;
  SubMeshMaker maker_;
  std::map<std::int32_t, std::int32_t> sums_of_face_;  // of the part: its first sum's column
  PartRows rows_;
  std::vector<FoundProblem> found_;
  std::vector<std::int32_t> row_of_;
  bool is_sound_ = true;
};

// Vertices that no face names are seen by no block.
std::vector<FoundProblem> unused_and_infinite(const MeshPart& part) {
  std::vector<FoundProblem> found;
  for (std::int32_t v = 0; v < part.owned_count(); ++v) {
    const glm::dvec3& p = part.positions[v];
    const auto is_fine = [](double x) { return std::abs(x) <= kMaxCoordinate; };
    if (!part.around(v).empty() || (is_fine(p.x) && is_fine(p.y) && is_fine(p.z))) continue;
    found.push_back({MeshProblemKind::NonFinitePosition, part.file_ids[v],
                     formatted("vertex {} is at ({}, {}, {})", part.file_ids[v], shortest(p.x),
                               shortest(p.y), shortest(p.z))});
  }
  return found;
}

// Whether two used vertices differ.
bool has_extent_over(const Ranks& ranks, const MeshPart& part) {
  glm::dvec3 first(0.0);
  const auto used = [&](std::int32_t v) { return !part.around(v).empty(); };
  std::int32_t v = 0;
  while (v < part.owned_count() && !used(v)) ++v;
  const bool has_any = v < part.owned_count();
  const std::int64_t root = min_over(ranks, std::int64_t{has_any ? ranks.rank : ranks.size});
  if (root == ranks.size) return false;
  if (ranks.rank == root) first = part.positions[v];
  MPI_Bcast(&first.x, 3, MPI_DOUBLE, static_cast<int>(root), ranks.comm);
  bool differs = false;
  for (std::int32_t u = 0; u < part.owned_count(); ++u)
    differs |= used(u) && part.positions[u] != first;
  return max_over(ranks, std::int64_t{differs}) > 0;
}

}  // namespace

PartRows make_rows(const Ranks& ranks, const MeshPart& part, const std::string& name,
                   std::int64_t face_total, const RowOptions& options) {
  std::vector<FoundProblem> found;
  RowMaker maker(part, options);
  agree(ranks, [&] {
    found = unknown_tags(part);
    const std::vector<FoundProblem> beside = unused_and_infinite(part);
    found.insert(found.end(), beside.begin(), beside.end());
    for (std::int64_t begin = 0; begin < part.owned_count(); begin += options.block_vertices) {
      const auto end = std::min<std::int64_t>(begin + options.block_vertices, part.owned_count());
      maker.add_block(static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
      if (options.after_block) options.after_block();
    }
    found.insert(found.end(), maker.found().begin(), maker.found().end());
  });
  if (ranks.rank == 0 && face_total == 0)
    found.push_back({MeshProblemKind::NoFaces, -1, kNoFacesMessage});
  const bool is_sound_so_far = sum_over(ranks, static_cast<std::int64_t>(found.size())) == 0;
  if (is_sound_so_far && !has_extent_over(ranks, part) && ranks.rank == 0)
    found.push_back({MeshProblemKind::NoExtent, -1,
                     "all vertices of the faces are at one place: there is no surface to make"});
  require_none(ranks, found, name);
  // Whatever a block cannot take is a problem of some block's own element.
  agree(ranks, [&] { PLANISH_ASSERT(maker.is_sound()); });
  PartRows rows;
  agree(ranks, [&] { rows = maker.finish(); });
  rows.spectral_bound = min_over(ranks, rows.spectral_bound);
  rows.has_boundary = max_over(ranks, std::int64_t{rows.has_boundary}) > 0;
  return rows;
}

}  // namespace planish
