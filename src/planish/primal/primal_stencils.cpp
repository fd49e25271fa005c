#include "planish/primal/primal_stencils.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/solve/stencil_builder.h"

namespace planish {
namespace {

// Based on: Catmull & Clark 1978, Loop 1987. Limits are taken on a refined level, whose faces are
// quads (or triangles), and B is carried back to the mesh through one step: Sdc's limit masks are
// wrong next to faces of other sizes.

using OpenSubdiv::Far::TopologyLevel;

// Rows of one step of the scheme.
class StepEmitter {
 public:
  StepEmitter(const PrimalSplit& split, int level)
      : split_(split),
        level_(level),
        topology_(split.level(level)),
        quads_(split.scheme() == PrimalScheme::CatmullClark),
        first_edge_(topology_.GetNumVertices() + (quads_ ? topology_.GetNumFaces() : 0)) {}

  // Adds `scale` times vertex `child` of the next level.
  void add(std::int32_t child, double scale, StencilRow& row) {
    if (child < topology_.GetNumVertices()) {
      add_vertex(child, scale, row);
    } else if (child < first_edge_) {
      add_centre(child - topology_.GetNumVertices(), scale, row);
    } else {
      add_edge(child - first_edge_, scale, row);
    }
  }
  void operator()(std::int32_t child, StencilRow& row) { add(child, 1.0, row); }

 private:
  void add_vertex(std::int32_t vertex, double scale, StencilRow& row) {
    gather_star(split_, level_, vertex, star_);
    vertex_mask(split_.scheme(), star_, mask_);
    add_weight(vertex, scale * mask_.vertex(0), row);
    for (std::int32_t i = 0; i < star_.edge_count(); ++i) {
      add_weight(star_.edge_ends[i], scale * mask_.edge(i), row);
    }
    const auto faces = topology_.GetVertexFaces(vertex);
    for (int i = 0; quads_ && i < faces.size(); ++i) {
      add_centre(faces[i], scale * mask_.face(i), row);
    }
  }

  void add_edge(std::int32_t edge, double scale, StencilRow& row) {
    const auto ends = topology_.GetEdgeVertices(edge);
    const auto faces = topology_.GetEdgeFaces(edge);
    edge_mask(split_.scheme(), topology_.GetEdgeSharpness(edge), faces.size(), mask_);
    for (int i = 0; i < 2; ++i) add_weight(ends[i], scale * mask_.vertex(i), row);
    const auto places = topology_.GetEdgeFaceLocalIndices(edge);
    for (int i = 0; i < faces.size(); ++i) {
      if (quads_) {
        add_centre(faces[i], scale * mask_.face(i), row);
      } else {
        // Edge i of a face runs from corner i to corner i + 1.
        const auto corners = topology_.GetFaceVertices(faces[i]);
        add_weight(corners[(places[i] + 2) % 3], scale * mask_.face(i), row);
      }
    }
  }

  void add_centre(std::int32_t face, double scale, StencilRow& row) const {
    if (scale == 0) return;
    const auto corners = topology_.GetFaceVertices(face);
    for (int i = 0; i < corners.size(); ++i) row.add(corners[i], scale / corners.size());
  }

  static void add_weight(std::int32_t vertex, double weight, StencilRow& row) {
    if (weight != 0) row.add(vertex, weight);
  }

  const PrimalSplit& split_;
  int level_;
  const TopologyLevel& topology_;
  bool quads_;
  std::int32_t first_edge_;
  VertexStar star_{};
  SubdivisionMask mask_{};
};

// Limits on one level.
class LimitEmitter {
 public:
  LimitEmitter(const PrimalSplit& split, int level)
      : split_(split), level_(level), limits_(split.scheme()) {}

  // Calls add(vertex of the level, weight, du, dv) for all points of the limit.
  template <class Add>
  void for_points(SectorRows::Place place, const Add& add) {
    gather_star(split_, level_, place.vertex, star_);
    const StarLimit& limit = limits_.limit(star_, place.sector);
    const auto visit = [&](std::int32_t vertex, double weight, double du, double dv) {
      if (weight != 0 || du != 0 || dv != 0) add(vertex, weight, du, dv);
    };
    visit(place.vertex, limit.position.vertex, limit.du.vertex, limit.dv.vertex);
    for (std::size_t i = 0; i < star_.edge_ends.size(); ++i) {
      visit(star_.edge_ends[i], limit.position.edges[i], limit.du.edges[i], limit.dv.edges[i]);
    }
    for (std::size_t i = 0; i < star_.face_ends.size(); ++i) {
      visit(star_.face_ends[i], limit.position.faces[i], limit.du.faces[i], limit.dv.faces[i]);
    }
  }

 private:
  const PrimalSplit& split_;
  int level_;
  StarLimits limits_;
  VertexStar star_{};
};

}  // namespace

StencilTable primal_refinement_table(const PrimalSplit& split, int level, RowRange rows) {
  return build_rows(split.level(level).GetNumVertices(), rows, Derivatives::No,
                    [&] { return StepEmitter(split, level); });
}

SectorRows primal_sector_rows(const PrimalSplit& split, int level, std::int64_t vertex_count) {
  std::vector<SectorRows::Place> extra;
  const TopologyLevel& base = split.level(0);
  bool has_creases = false;
  for (int e = 0; e < base.GetNumEdges() && !has_creases; ++e) {
    has_creases = base.IsEdgeInfSharp(e) && !base.IsEdgeBoundary(e);
  }
  if (!has_creases) return {vertex_count, {}};
  VertexStar star;
  for (std::int32_t v = 0; v < vertex_count; ++v) {
    gather_star(split, level, v, star);
    const std::int32_t sectors = sector_count(star);
    for (std::int32_t s = 1; s < sectors; ++s) extra.push_back({v, s});
  }
  return {vertex_count, std::move(extra)};
}

StencilTable primal_limit_table(const PrimalSplit& split, int level, const SectorRows& sectors,
                                RowRange rows) {
  return build_rows(split.level(level).GetNumVertices(), rows, Derivatives::Yes, [&] {
    return [&, emitter = LimitEmitter(split, level)](std::int32_t index, StencilRow& row) mutable {
      emitter.for_points(sectors.place(index), [&](std::int32_t vertex, double weight, double du,
                                                   double dv) { row.add(vertex, weight, du, dv); });
    };
  });
}

StencilTable primal_limit_masks(const PrimalSplit& split) {
  const std::int32_t count = split.level(0).GetNumVertices();
  return build_rows(count, {0, count}, Derivatives::No, [&] {
    return [&, limits = LimitEmitter(split, 1), step = StepEmitter(split, 0)](
               std::int32_t vertex, StencilRow& row) mutable {
      limits.for_points({vertex, 0}, [&](std::int32_t point, double weight, double, double) {
        if (weight != 0) step.add(point, weight, row);
      });
    };
  });
}

namespace {

// Derivations of our own. With x supported on the smooth vertices, whose rows scaled by w_v are
// those of a symmetric matrix, and sums over edges and faces,
//   Catmull-Clark, w = n (n + 5): x' W B x = sum_v n (n - 3) x_v^2 + 2 sum_e (x_v + x_w)^2
//                                            + 4 sum_f (sum of x in f)^2 / m,
//   Loop, w = s + n, s = 3 / (8 beta): x' W B x = sum_v (s - n / 2) x_v^2
//                                            + 1/2 sum_f (sum of x in f)^2.
// Both are at least min_v (first factor / w) x' W x.
// The estimate: Lanczos, "An iteration method for the solution of the eigenvalue problem", 1950.

// Of the curve (1/6, 4/6, 1/6) along creases and boundaries.
constexpr double kCreaseBound = 1.0 / 3.0;

// The smallest Ritz value settles to two digits well within these.
constexpr int kLanczosSteps = 40;

// 3 / (8 beta), after Loop's beta.
double loop_ratio(int valence) {
  VertexStar star;
  star.face_count = valence;
  star.edge_ends.assign(static_cast<std::size_t>(valence), 0);
  star.edge_sharpness.assign(static_cast<std::size_t>(valence), 0.0f);
  SubdivisionMask mask;
  vertex_mask(PrimalScheme::Loop, star, mask);
  return 3.0 / (8.0 * mask.edge(0));
}

struct VertexFacts {
  std::vector<bool> smooth;  // no sharpness at the vertex and its edges
  bool any_sharp = false;
  bool any_semi_sharp_or_dart = false;
};

VertexFacts vertex_facts(const PrimalSplit& split) {
  const TopologyLevel& base = split.level(0);
  VertexFacts facts;
  facts.smooth.resize(static_cast<std::size_t>(base.GetNumVertices()));
  for (int v = 0; v < base.GetNumVertices(); ++v) {
    using OpenSubdiv::Sdc::Crease;
    const Crease::Rule rule = base.GetVertexRule(v);
    facts.smooth[v] = rule == Crease::RULE_SMOOTH;
    facts.any_sharp = facts.any_sharp || !facts.smooth[v];
    facts.any_semi_sharp_or_dart =
        facts.any_semi_sharp_or_dart || base.IsVertexSemiSharp(v) || rule == Crease::RULE_DART;
  }
  return facts;
}

// The least of the quotients in the comment on top.
double bound_by_valence(const PrimalSplit& split, const VertexFacts& facts,
                        std::span<const double> weights) {
  double bound = facts.any_sharp ? kCreaseBound : 1.0;
  for (std::size_t v = 0; v < weights.size(); ++v) {
    if (!facts.smooth[v]) continue;
    const double n = split.level(0).GetVertexEdges(static_cast<int>(v)).size();
    const double factor = split.scheme() == PrimalScheme::Loop ? weights[v] - 1.5 * n : n * (n - 3);
    bound = std::min(bound, factor / weights[v]);
  }
  return bound;
}

// B on the smooth vertices, the others held at 0.
class SmoothPart {
 public:
  SmoothPart(const StencilView<double>& masks, const VertexFacts& facts,
             std::span<const double> weights)
      : masks_(masks), facts_(facts), weights_(weights) {}

  void apply(const std::vector<double>& x, std::vector<double>& image) const {
    parallel_each(x.size(), [&](std::size_t i) {
      double sum = 0;
      const std::int32_t last = masks_.offsets[i] + masks_.sizes[i];
      for (std::int32_t k = masks_.offsets[i]; k < last; ++k) {
        sum += masks_.weights[k] * x[masks_.indices[k]];
      }
      image[i] = facts_.smooth[i] ? sum : 0.0;
    });
  }
  [[nodiscard]] double product(const std::vector<double>& x, const std::vector<double>& y) const {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += weights_[i] * x[i] * y[i];
    return sum;
  }

 private:
  const StencilView<double>& masks_;
  const VertexFacts& facts_;
  std::span<const double> weights_;
};

// The number of eigenvalues below `limit` of a symmetric tridiagonal matrix (Sturm).
int count_below(std::span<const double> diagonal, std::span<const double> beside, double limit) {
  int count = 0;
  double pivot = 1;
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    const double coupling = i == 0 ? 0.0 : beside[i - 1] * beside[i - 1] / pivot;
    pivot = diagonal[i] - limit - coupling;
    if (pivot == 0) pivot = 1e-300;
    if (pivot < 0) ++count;
  }
  return count;
}

double smallest_eigenvalue(std::span<const double> diagonal, std::span<const double> beside) {
  double low = -2, high = 2;  // rows of B sum to 1 and its few negative weights are small
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (count_below(diagonal, beside, middle) > 0 ? high : low) = middle;
  }
  return (low + high) / 2;
}

double lanczos_smallest(const SmoothPart& matrix, const VertexFacts& facts) {
  std::vector<double> vector(facts.smooth.size()), image(vector.size()), previous(vector.size());
  std::mt19937 random(1);  // any fixed start: results are the same from run to run
  for (std::size_t i = 0; i < vector.size(); ++i) {
    const double number = static_cast<double>(random()) / std::mt19937::max() - 0.5;
    vector[i] = facts.smooth[i] ? number : 0.0;
  }
  double norm = std::sqrt(matrix.product(vector, vector));
  if (!(norm > 0)) return kCreaseBound;  // no smooth vertex
  std::vector<double> diagonal, beside;
  for (double& x : vector) x /= norm;
  for (int step = 0; step < kLanczosSteps; ++step) {
    matrix.apply(vector, image);
    diagonal.push_back(matrix.product(vector, image));
    for (std::size_t i = 0; i < image.size(); ++i) {
      image[i] -= diagonal.back() * vector[i] + (step == 0 ? 0.0 : beside.back() * previous[i]);
    }
    norm = std::sqrt(matrix.product(image, image));
    constexpr double kInvariant = 1e-10;  // the whole space is exhausted
    if (!(norm > kInvariant)) break;
    beside.push_back(norm);
    previous.swap(vector);
    for (std::size_t i = 0; i < image.size(); ++i) vector[i] = image[i] / norm;
  }
  return smallest_eigenvalue(diagonal, beside);
}

}  // namespace

std::vector<double> primal_row_weights(const PrimalSplit& split) {
  const TopologyLevel& base = split.level(0);
  std::vector<double> weights(static_cast<std::size_t>(base.GetNumVertices()));
  std::map<int, double> ratios;  // few valences occur
  for (int v = 0; v < base.GetNumVertices(); ++v) {
    const int n = base.GetVertexEdges(v).size();
    if (split.scheme() == PrimalScheme::CatmullClark) {
      weights[v] = n * (n + 5.0);
      continue;
    }
    const auto [ratio, is_new] = ratios.try_emplace(n, 0.0);
    if (is_new) ratio->second = loop_ratio(n);
    weights[v] = ratio->second + n;
  }
  return weights;
}

Spectrum primal_spectrum(const PrimalSplit& split, const StencilView<double>& limit_masks) {
  const VertexFacts facts = vertex_facts(split);
  const std::vector<double> weights = primal_row_weights(split);
  Spectrum spectrum;
  spectrum.self_adjoint = !facts.any_sharp;
  spectrum.smallest = bound_by_valence(split, facts, weights);
  if (spectrum.smallest > 0) {
    spectrum.proven = !facts.any_semi_sharp_or_dart;
    return spectrum;
  }
  const double estimate = lanczos_smallest({limit_masks, facts, weights}, facts);
  spectrum.smallest = facts.any_sharp ? std::min(estimate, kCreaseBound) : estimate;
  return spectrum;
}

}  // namespace planish
