// The limit of subdivision at a vertex. With quads (Catmull-Clark) or triangles (Loop) around it
// the star of a vertex determines the star of its child: p' = M p, where M depends on the sharpness
// of this step alone. Once all semi-sharpness has decayed M stays the same, and the limit is M's
// left eigenvector of eigenvalue 1, the tangents those of the next largest. Sdc knows them but for
// the cases below; before that the weights are pulled back through the semi-sharp steps.
// Based on: DeRose, Kass & Truong, "Subdivision surfaces in character animation", 1998 (creases);
// Halstead, Kass & DeRose, "Efficient, fair interpolation using Catmull-Clark surfaces", 1993.
#include "planish/primal/star_limit.h"

#include <opensubdiv/sdc/crease.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace planish {

namespace {

using OpenSubdiv::Sdc::Crease;

// A step takes 1 off a semi-sharp edge, so that these are enough for every sharpness below 10.
constexpr int kMaxSemiSharpSteps = 10;

bool is_semi_sharp(const VertexStar& star) {
  return Crease::IsSemiSharp(star.sharpness) ||
         std::ranges::any_of(star.edge_sharpness, Crease::IsSemiSharp);
}

void subdivide_sharpness(VertexStar& star) {
  const Crease crease;
  star.sharpness = crease.SubdivideVertexSharpness(star.sharpness);
  for (float& sharpness : star.edge_sharpness) {
    sharpness = crease.SubdivideUniformSharpness(sharpness);
  }
}

void clear(const VertexStar& star, StarWeights& weights) {
  weights.vertex = 0;
  weights.edges.assign(star.edge_ends.size(), 0.0);
  weights.faces.assign(star.face_ends.size(), 0.0);
}

// A mask of the whole star, whose first edge Sdc was shown as `first_edge`.
void take(const SubdivisionMask& mask, const VertexStar& star, std::int32_t first_edge,
          StarWeights& weights) {
  const std::int32_t n = star.edge_count();
  clear(star, weights);
  weights.vertex = mask.vertex(0);
  for (std::int32_t i = 0; i < n; ++i) weights.edges[(first_edge + i) % n] = mask.edge(i);
  for (std::size_t i = 0; i < weights.faces.size(); ++i) {
    weights.faces[(first_edge + i) % n] = mask.face(static_cast<int>(i));
  }
}

template <class Change>
void for_each_weight(StarWeights& weights, const Change& change) {
  change(weights.vertex);
  for (double& weight : weights.edges) change(weight);
  for (double& weight : weights.faces) change(weight);
}

double largest(StarWeights& weights) {
  double size = 0;
  for_each_weight(weights, [&](double w) { size = std::max(size, std::abs(w)); });
  return size;
}

void add_scaled(const StarWeights& added, double scale, StarWeights& weights) {
  weights.vertex += scale * added.vertex;
  for (std::size_t i = 0; i < added.edges.size(); ++i) weights.edges[i] += scale * added.edges[i];
  for (std::size_t i = 0; i < added.faces.size(); ++i) weights.faces[i] += scale * added.faces[i];
}

double largest_change(const StarWeights& before, StarWeights after) {
  add_scaled(before, -1.0, after);
  return largest(after);
}

}  // namespace

// weights <- weights M
void StarLimits::pull_back(const VertexStar& star, StarWeights& weights) {
  const std::int32_t n = star.edge_count();
  clear(star, pulled_);
  const auto add_centre = [&](std::int32_t face, double weight) {
    pulled_.vertex += weight / 4;
    pulled_.edges[face] += weight / 4;
    pulled_.edges[(face + 1) % n] += weight / 4;
    pulled_.faces[face] += weight / 4;
  };
  const bool quads = scheme_ == PrimalScheme::CatmullClark;
  vertex_mask(scheme_, star, mask_);
  pulled_.vertex += weights.vertex * mask_.vertex(0);
  for (std::int32_t i = 0; i < n; ++i) pulled_.edges[i] += weights.vertex * mask_.edge(i);
  for (std::int32_t i = 0; quads && i < star.face_count; ++i) {
    add_centre(i, weights.vertex * mask_.face(i));
  }
  for (std::int32_t i = 0; i < n; ++i) {
    const bool outer = star.is_boundary() && (i == 0 || i == n - 1);
    edge_mask(scheme_, star.edge_sharpness[i], outer ? 1 : 2, mask_);
    pulled_.vertex += weights.edges[i] * mask_.vertex(0);
    pulled_.edges[i] += weights.edges[i] * mask_.vertex(1);
    if (outer) continue;  // a boundary edge is sharp: its faces do not count
    const std::int32_t before = (i + n - 1) % n;
    if (quads) {
      add_centre(before, weights.edges[i] * mask_.face(0));
      add_centre(i, weights.edges[i] * mask_.face(1));
    } else {
      pulled_.edges[before] += weights.edges[i] * mask_.face(0);
      pulled_.edges[(i + 1) % n] += weights.edges[i] * mask_.face(1);
    }
  }
  for (std::size_t i = 0; i < weights.faces.size(); ++i) {
    add_centre(static_cast<std::int32_t>(i), weights.faces[i]);
  }
  std::swap(weights, pulled_);
}

bool StarLimits::has_one_sharp_edge() const {
  return !star_.is_boundary() && std::ranges::count_if(star_.edge_sharpness, Crease::IsSharp) == 1;
}

// Power iterations end when nothing changes by more than this. The ratio to the next eigenvalue is
// about 1/2 for small valences and grows towards 1 with the valence.
constexpr double kSettled = 1e-16;
constexpr int kMaxSettleSteps = 2000;

void StarLimits::settle_position() {
  for (int step = 0; step < kMaxSettleSteps; ++step) {
    StarWeights before = limit_.position;
    pull_back(star_, limit_.position);
    if (largest_change(before, limit_.position) <= kSettled) return;
  }
}

// Towards the eigenvector of the largest eigenvalue but 1, among those of the tangent's symmetry.
// Weights of a tangent sum to 0; what rounding adds to that sum grows and is taken off again.
void StarLimits::settle_tangent(const VertexStar& star, const StarWeights& position,
                                StarWeights& tangent) {
  for (int step = 0; step < kMaxSettleSteps; ++step) {
    const StarWeights before = tangent;
    pull_back(star, tangent);
    double sum = 0;
    for_each_weight(tangent, [&](double weight) { sum += weight; });
    add_scaled(position, -sum, tangent);
    const double scale = 1.0 / largest(tangent);
    for_each_weight(tangent, [&](double& weight) { weight *= scale; });
    if (largest_change(before, tangent) <= kSettled) return;
  }
}

void StarLimits::stationary_position() {
  limit_mask(scheme_, star_, masks_);
  take(masks_.position, star_, 0, limit_.position);
  // Sdc takes the smooth mask at a dart, whose sharp edge has another rule, and a vertex of valence
  // 2 for its own limit.
  const bool fixed = Crease::IsSharp(star_.sharpness);
  const bool valence_2 = !star_.is_boundary() && star_.edge_count() == 2;
  if (!fixed && (has_one_sharp_edge() || valence_2)) settle_position();
}

// Of a tangent that is even or odd about an edge, or a sum of both.
void StarLimits::take_odd_part(std::int32_t edge, StarWeights& tangent) {
  const std::int32_t n = star_.edge_count();
  const StarWeights whole = tangent;
  for (std::int32_t i = 0; i < n; ++i) {
    tangent.edges[i] -= whole.edges[(2 * edge - i + 2 * n) % n];
  }
  for (std::size_t i = 0; i < whole.faces.size(); ++i) {
    tangent.faces[i] -= whole.faces[(2 * edge - static_cast<std::int32_t>(i) - 1 + 2 * n) % n];
  }
  tangent.vertex = 0;
}

// Tangents of the ring of a smooth vertex, the first of them towards an edge.
void StarLimits::ring_tangents(std::int32_t first_edge) {
  if (scheme_ == PrimalScheme::CatmullClark && star_.edge_count() == 2) {
    // Symmetry leaves nothing else.
    clear(star_, limit_.du);
    limit_.dv = limit_.du;
    limit_.du.edges = {1.0, -1.0};
    limit_.dv.faces = {1.0, -1.0};
    return;
  }
  part_ = star_;
  part_.sharpness = 0;
  std::ranges::fill(part_.edge_sharpness, 0.0f);
  limit_mask(scheme_, part_, masks_);
  take(masks_.du, star_, first_edge, limit_.du);
  take(masks_.dv, star_, first_edge, limit_.dv);
}

// `part_` becomes a boundary vertex with so many faces.
void StarLimits::make_fan(std::int32_t face_count) {
  const auto faces = static_cast<std::size_t>(face_count);
  part_.face_count = face_count;
  part_.sharpness = 0;
  part_.edge_ends.resize(faces + 1);
  part_.edge_sharpness.assign(faces + 1, 0.0f);
  part_.edge_sharpness.front() = part_.edge_sharpness.back() = kInfiniteSharpness;
  part_.face_ends.resize(scheme_ == PrimalScheme::Loop ? 0 : faces);
}

// Tangents of the faces between two sharp edges, shown to Sdc as a boundary.
void StarLimits::fan_tangents(const Sector& faces, bool corner) {
  const std::int32_t n = star_.edge_count();
  const std::int32_t k = faces.face_count;
  const std::int32_t last = (faces.first_edge + k) % n;
  clear(star_, limit_.du);
  limit_.dv = limit_.du;
  if (corner) {
    limit_.du.edges[faces.first_edge] += 1.0;
    if (k == 1) {
      limit_.du.vertex = limit_.dv.vertex = -1.0;
      limit_.dv.edges[last] += 1.0;
      return;
    }
    limit_.du.edges[last] -= 1.0;
    for (std::int32_t i = 1; i < k; ++i) {
      const double weight = std::sin(std::numbers::pi * i / k);
      limit_.dv.edges[(faces.first_edge + i) % n] += weight;
      limit_.dv.vertex -= weight;
    }
    return;
  }
  make_fan(k);
  limit_mask(scheme_, part_, masks_);
  take(masks_.du, part_, 0, fan_.du);
  take(masks_.dv, part_, 0, fan_.dv);
  // Sdc's tangent across an irregular crease is that of other subdivision rules than its own.
  const std::int32_t regular = scheme_ == PrimalScheme::Loop ? 3 : 2;
  if (k > regular) {
    take(masks_.position, part_, 0, fan_.position);
    settle_tangent(part_, fan_.position, fan_.dv);
  }
  const auto spread = [&](const StarWeights& part, StarWeights& weights) {
    weights.vertex = part.vertex;
    for (std::int32_t i = 0; i <= k; ++i) {
      weights.edges[(faces.first_edge + i) % n] += part.edges[i];
    }
    for (std::size_t i = 0; i < part.faces.size(); ++i) {
      weights.faces[(faces.first_edge + i) % n] += part.faces[i];
    }
  };
  spread(fan_.du, limit_.du);
  spread(fan_.dv, limit_.dv);
}

void StarLimits::stationary_tangents(std::int32_t index) {
  const bool corner_tag = Crease::IsSharp(star_.sharpness);
  const auto sharp = std::ranges::count_if(star_.edge_sharpness, Crease::IsSharp);
  if (sharp >= 2) {
    fan_tangents(sector(star_, index), corner_tag || sharp > 2);
  } else if (sharp == 1 && !corner_tag) {
    const auto edge = std::ranges::find_if(star_.edge_sharpness, Crease::IsSharp);
    const auto first = static_cast<std::int32_t>(edge - star_.edge_sharpness.begin());
    ring_tangents(first);
    // A dart: its sharp edge has another rule, which leaves what is odd about it as it is.
    settle_tangent(star_, limit_.position, limit_.du);
    take_odd_part(first, limit_.dv);
  } else {
    ring_tangents(0);
  }
}

const StarLimit& StarLimits::limit(const VertexStar& star, std::int32_t sector_index) {
  star_ = star;
  int steps = 0;
  for (; is_semi_sharp(star_) && steps < kMaxSemiSharpSteps; ++steps) subdivide_sharpness(star_);
  stationary_position();
  stationary_tangents(sector_index);
  while (steps-- > 0) {
    star_.sharpness = star.sharpness;
    star_.edge_sharpness = star.edge_sharpness;
    for (int i = 0; i < steps; ++i) subdivide_sharpness(star_);
    pull_back(star_, limit_.position);
    pull_back(star_, limit_.du);
    pull_back(star_, limit_.dv);
  }
  return limit_;
}

}  // namespace planish
