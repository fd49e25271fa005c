#include "planish/distributed/part_rows.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/sound_topology.h"

namespace planish {
namespace {

using Kind = MeshProblemKind;

std::int64_t file_id_of(const MeshPart& part, const SubMesh& sub, std::int32_t vertex) {
  return part.file_ids[sub.vertices[vertex]];
}
std::int64_t face_id_of(const MeshPart& part, const SubMesh& sub, std::int32_t face) {
  return part.face_ids[sub.faces[face]];
}

// The message with the file's numbers for those of the sub mesh.
std::string in_file_numbers(const MeshPart& part, const SubMesh& sub, std::string_view message) {
  std::string text;
  const auto number = [&](std::int64_t (*of)(const MeshPart&, const SubMesh&, std::int32_t)) {
    std::int32_t value = 0;
    const auto [end, error] =
        std::from_chars(message.data(), message.data() + message.size(), value);
    if (error != std::errc()) return;
    message.remove_prefix(static_cast<std::size_t>(end - message.data()));
    text += std::to_string(of(part, sub, value));
  };
  while (!message.empty()) {
    const auto take = [&](std::string_view word) {
      if (!message.starts_with(word)) return false;
      text += word;
      message.remove_prefix(word.size());
      return true;
    };
    if (take("face ") || take("the largest face, ")) {
      number(face_id_of);
    } else if (take("vertex ")) {
      number(file_id_of);
    } else if (take("edge ")) {
      number(file_id_of);
      if (take("-")) number(file_id_of);
    } else {
      text += message.front();
      message.remove_prefix(1);
    }
  }
  return text;
}

bool is_of_vertex(const MeshProblem& problem) {
  return problem.kind == Kind::NonFinitePosition || problem.kind == Kind::NonManifoldVertex ||
         (problem.kind == Kind::ValenceTooHigh && problem.message.starts_with("vertex"));
}

bool is_of_face(const MeshProblem& problem) {
  switch (problem.kind) {
    case Kind::IndexOutOfRange:
    case Kind::FaceTooSmall:
    case Kind::RepeatedCorner:
    case Kind::DuplicateFace:
    case Kind::InconsistentWinding:
    case Kind::NonManifoldEdge:
    case Kind::TooLarge:
      return problem.element >= 0;
    case Kind::ValenceTooHigh:
      return !is_of_vertex(problem);
    default:
      return false;
  }
}

struct ProblemHead {
  std::int64_t kind, element, bytes;
};

// The first few of every rank, and rank 0's count of all.
std::vector<FoundProblem> first_of_all(const Ranks& ranks, std::vector<FoundProblem> found,
                                       std::size_t most) {
  const auto in_order = [](const FoundProblem& a, const FoundProblem& b) {
    return a.kind != b.kind ? a.kind < b.kind : a.element < b.element;
  };
  std::ranges::stable_sort(found, in_order);
  found.resize(std::min(found.size(), most));
  std::vector<ProblemHead> heads;
  std::vector<char> text;
  for (const FoundProblem& problem : found) {
    heads.push_back({static_cast<std::int64_t>(problem.kind), problem.element,
                     static_cast<std::int64_t>(problem.message.size())});
    text.insert(text.end(), problem.message.begin(), problem.message.end());
  }
  const auto all_heads = gather<ProblemHead>(ranks, heads);
  const auto all_text = gather<char>(ranks, text);
  std::vector<FoundProblem> all;
  std::size_t at = 0;
  for (const ProblemHead& head : all_heads) {
    all.push_back({static_cast<Kind>(head.kind), head.element,
                   std::string(all_text.data() + at, static_cast<std::size_t>(head.bytes))});
    at += static_cast<std::size_t>(head.bytes);
  }
  std::ranges::stable_sort(all, in_order);
  return all;
}

}  // namespace

std::vector<FoundProblem> problems_of_run(const MeshPart& part, const SubMesh& sub,
                                          std::int32_t begin, std::int32_t end,
                                          const std::vector<MeshProblem>& problems) {
  const auto in_run = [&](std::int32_t v) { return v >= begin && v < end; };
  // A face is its first vertex's along the curve.
  const auto owns_face = [&](std::int64_t face) {
    return in_run(part.first_vertex(sub.faces[face]));
  };
  std::vector<FoundProblem> found;
  for (const MeshProblem& problem : problems) {
    if (is_of_vertex(problem) && in_run(sub.vertices[problem.element])) {
      found.push_back({problem.kind,
                       file_id_of(part, sub, static_cast<std::int32_t>(problem.element)),
                       in_file_numbers(part, sub, problem.message)});
    } else if (is_of_face(problem) && owns_face(problem.element)) {
      found.push_back({problem.kind,
                       face_id_of(part, sub, static_cast<std::int32_t>(problem.element)),
                       in_file_numbers(part, sub, problem.message)});
    }
  }
  return found;
}

std::vector<FoundProblem> unknown_tags(const MeshPart& part) {
  std::vector<FoundProblem> found;
  const auto owned = [&](std::int32_t v) { return v >= 0 && v < part.owned_count(); };
  const auto meet = [&](std::int32_t v0, std::int32_t v1) {
    return std::ranges::any_of(part.around(v0), [&](std::int32_t face) {
      const auto named = part.face(face);
      for (std::size_t i = 0; i < named.size(); ++i) {
        const std::int32_t next = named[(i + 1) % named.size()];
        if ((named[i] == v0 && next == v1) || (named[i] == v1 && next == v0)) return true;
      }
      return false;
    });
  };
  for (const PartCrease& crease : part.creases) {
    // The owner of its first vertex tells.
    if (!owned(crease.v0) || (crease.v1 >= 0 && meet(crease.v0, crease.v1))) continue;
    found.push_back({Kind::UnknownCreaseEdge, crease.index,
                     formatted("crease {} names {}-{}, which is no edge of the mesh", crease.index,
                               crease.file_v0, crease.file_v1)});
  }
  for (const PartCorner& corner : part.corners) {
    if (!part.around(corner.vertex).empty()) continue;
    found.push_back({Kind::UnknownCornerVertex, corner.index,
                     formatted("corner {} names vertex {}, which no face uses", corner.index,
                               part.file_ids[corner.vertex])});
  }
  return found;
}

void require_none(const Ranks& ranks, const std::vector<FoundProblem>& found,
                  const std::string& name) {
  constexpr std::int64_t kNamed = 10;
  constexpr const char* kRemedy = "; planish-mpi mends nothing, planish fit mends what it can";
  const std::int64_t count = sum_over(ranks, static_cast<std::int64_t>(found.size()));
  if (count == 0) return;
  const std::vector<FoundProblem> first = first_of_all(ranks, found, kNamed);
  agree(ranks, [&] {
    if (ranks.rank != 0) return;
    std::string message = name + ": ";
    if (count == 1) {
      message += first.front().message;
    } else {
      message += formatted("{} problems", count);
      if (count > kNamed) message += formatted(", the first {} being", kNamed);
      message += ":";
      for (std::int64_t i = 0; i < std::min(count, kNamed); ++i)
        message += "\n  " + first[i].message;
    }
    // A mesh without faces is beyond mending.
    if (first.front().element >= 0) message += kRemedy;
    throw Error(ErrorCode::UnusableMesh, message, first.front().element);
  });
}

namespace {

// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", equation (1): the
// rows of B, made by the same functions as on one machine, block by block.

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
