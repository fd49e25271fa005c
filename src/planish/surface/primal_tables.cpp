#include "planish/surface/primal_tables.h"

#include "planish/core/assert.h"
#include "planish/core/parallel.h"
#include "planish/primal/primal_stencils.h"
#include "planish/primal/vertex_star.h"
#include "planish/surface/memory_need.h"

namespace planish {

PrimalTables::PrimalTables(const UsedPart& used, PrimalScheme scheme,
                           const EvaluateOptions& options)
    : level_(options.level),
      split_(used.mesh, {scheme, options.sharp, used.prepared->topology.get()}) {
  const std::vector<LevelCounts> counts = split_.counts_to(state_level());
  require_memory(counts, LastLevel::Full, RefinedAttributes::of(used.mesh),
                 options.memory_limit_bytes);
  split_.refine(state_level());
  rows_ = primal_sector_rows(split_, state_level(), counts[level_].vertices);
}

StencilTable PrimalTables::step(int level, RowRange rows) const {
  return primal_refinement_table(split_, level - 1, rows);
}

StencilTable PrimalTables::limit(RowRange rows) const {
  return primal_limit_table(split_, state_level(), rows_, rows);
}

std::vector<std::int32_t> PrimalTables::face_vertices() const {
  const auto& topology = split_.level(level_);
  const auto face_count = static_cast<std::size_t>(topology.GetNumFaces());
  std::vector<std::size_t> first(face_count + 1, 0);
  for (std::size_t f = 0; f < face_count; ++f) {
    first[f + 1] = first[f] + topology.GetFaceVertices(static_cast<int>(f)).size();
  }
  std::vector<std::int32_t> result(first.back());
  parallel_for(face_count, 4096, [&](std::size_t begin, std::size_t end) {
    VertexStar star;
    for (std::size_t f = begin; f < end; ++f) {
      const auto vertices = topology.GetFaceVertices(static_cast<int>(f));
      for (int k = 0; k < vertices.size(); ++k) {
        result[first[f] + k] = row_of(static_cast<std::int32_t>(f), k, vertices[k], star);
      }
    }
  });
  return result;
}

// The row of a vertex as seen from a face of the output, of which it is corner `corner`.
std::int32_t PrimalTables::row_of(std::int32_t face, int corner, std::int32_t vertex,
                                  VertexStar& star) const {
  if (!rows_.is_split(vertex)) return vertex;
  const std::int32_t state_face =
      level_ == 0 ? split_.level(0).GetFaceChildFaces(face)[corner] : face;
  const int place = split_.level(state_level()).GetVertexFaces(vertex).FindIndex(state_face);
  PLANISH_ASSERT(place >= 0);
  gather_star(split_, state_level(), vertex, star);
  return rows_.row(vertex, sector_of(star, place));
}

}  // namespace planish
