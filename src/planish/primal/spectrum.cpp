// Derivations of our own. With x supported on the smooth vertices, whose rows scaled by w_v are
// those of a symmetric matrix, and sums over edges and faces,
//   Catmull-Clark, w = n (n + 5): x' W B x = sum_v n (n - 3) x_v^2 + 2 sum_e (x_v + x_w)^2
//                                            + 4 sum_f (sum of x in f)^2 / m,
//   Loop, w = s + n, s = 3 / (8 beta): x' W B x = sum_v (s - n / 2) x_v^2
//                                            + 1/2 sum_f (sum of x in f)^2.
// Both are at least min_v (first factor / w) x' W x.
// The estimate: Lanczos, "An iteration method for the solution of the eigenvalue problem", 1950.
#include "planish/primal/spectrum.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>

#include "planish/core/parallel.h"
#include "planish/primal/star_masks.h"
#include "planish/primal/vertex_star.h"

namespace planish {

namespace {

using OpenSubdiv::Far::TopologyLevel;

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
