#include <opensubdiv/sdc/catmarkScheme.h>
#include <opensubdiv/sdc/crease.h>
#include <opensubdiv/sdc/loopScheme.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/portable_math.h"
#include "planish/primal/primal_stencils.h"
#include "planish/solve/refiner.h"

namespace planish {

namespace Far = OpenSubdiv::Far;

namespace {

void require_triangles(const PolygonMesh& mesh) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (mesh.face_size(f) == 3) continue;
    throw Error(ErrorCode::UnusableMesh,
                formatted("face {} has {} corners, and Loop subdivision knows triangles only; "
                          "split the faces into triangles, or take catmull-clark or doo-sabin",
                          f, mesh.face_size(f)),
                f);
  }
}

// Every vertex and edge of a face has a weight for each of its corners, about 60 bytes for a pair
// of them in step and limits: so many pairs in large faces take 1 GiB.
constexpr std::int64_t kMostPairs = 1 << 24;
constexpr std::int64_t kLargeFace = 64;

void require_small_faces(const PolygonMesh& mesh) {
  std::int64_t pairs = 0;
  std::int32_t largest = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int64_t size = mesh.face_size(f);
    if (size > kLargeFace) pairs += size * size;
    if (size > mesh.face_size(largest)) largest = f;
  }
  if (pairs <= kMostPairs) return;
  throw Error(ErrorCode::UnusableMesh,
              formatted("face {} has {} corners: Catmull-Clark's stencils take the square of a "
                        "face's corners, {} here and {} at most; split its large faces, or take "
                        "doo-sabin",
                        largest, mesh.face_size(largest), pairs, kMostPairs),
              largest);
}

}  // namespace

PrimalSplit::PrimalSplit(const PolygonMesh& mesh, const PrimalSplitOptions& options)
    : scheme_(options.scheme) {
  if (scheme_ == PrimalScheme::Loop) {
    require_triangles(mesh);
  } else {
    require_small_faces(mesh);
  }
  const RefinerOptions refined{scheme_ == PrimalScheme::Loop ? OpenSubdiv::Sdc::SCHEME_LOOP
                                                             : OpenSubdiv::Sdc::SCHEME_CATMARK,
                               options.sharp};
  refiner_ = options.topology != nullptr ? make_refiner(mesh, refined, *options.topology)
                                         : make_refiner(mesh, refined, MeshTopology(mesh));
}

PrimalSplit::~PrimalSplit() = default;

void PrimalSplit::refine(int levels) {
  refiner_->Unrefine();
  if (levels == 0) return;
  Far::TopologyRefiner::UniformOptions options(levels);
  // A vertex's limit needs the faces around it, on the last level too.
  options.fullTopologyInLastLevel = true;
  refiner_->RefineUniform(options);

  for (int l = 0; l < levels; ++l) {
    const Far::TopologyLevel& parent = level(l);
    const int vertices = parent.GetNumVertices();
    const int faces = scheme_ == PrimalScheme::Loop ? 0 : parent.GetNumFaces();
    PLANISH_ASSERT(parent.GetVertexChildVertex(vertices - 1) == vertices - 1);
    PLANISH_ASSERT(faces == 0 || parent.GetFaceChildVertex(faces - 1) == vertices + faces - 1);
    PLANISH_ASSERT(parent.GetEdgeChildVertex(0) == vertices + faces);
    const auto children = parent.GetFaceChildFaces(parent.GetNumFaces() - 1);
    PLANISH_ASSERT(children[children.size() - 1] == level(l + 1).GetNumFaces() - 1);
  }
}

int PrimalSplit::sharp_edge_count() const {
  int count = 0;
  for (int e = 0; e < level(0).GetNumEdges(); ++e) count += level(0).GetEdgeSharpness(e) > 0;
  return count;
}

int PrimalSplit::boundary_edge_count() const {
  int count = 0;
  for (int e = 0; e < level(0).GetNumEdges(); ++e) count += level(0).IsEdgeBoundary(e);
  return count;
}

int PrimalSplit::corner_count() const {
  int count = 0;
  for (int v = 0; v < level(0).GetNumVertices(); ++v) {
    count += level(0).GetVertexRule(v) == OpenSubdiv::Sdc::Crease::RULE_CORNER;
  }
  return count;
}

std::vector<LevelCounts> PrimalSplit::counts_to(int last) const {
  const Far::TopologyLevel& base = level(0);
  std::vector<LevelCounts> counts{{base.GetNumVertices(), base.GetNumEdges(), base.GetNumFaces()}};
  std::int64_t corners = base.GetNumFaceVertices();
  for (int l = 0; l < last; ++l) {
    const LevelCounts& c = counts.back();
    const bool loop = scheme_ == PrimalScheme::Loop;
    counts.push_back(
        loop ? LevelCounts{c.vertices + c.edges, 2 * c.edges + corners, 4 * c.faces}
             : LevelCounts{c.vertices + c.edges + c.faces, 2 * c.edges + corners, corners});
    corners *= 4;
  }
  return counts;
}

namespace {

bool is_infinite(float sharpness) { return sharpness >= kInfiniteSharpness; }

// Where the first sector begins: at the first sharp edge.
std::int32_t first_sharp_edge(const VertexStar& star) {
  const auto found = std::ranges::find_if(star.edge_sharpness, is_infinite);
  PLANISH_ASSERT(found != star.edge_sharpness.end());
  return static_cast<std::int32_t>(found - star.edge_sharpness.begin());
}

}  // namespace

void gather_star(const PrimalSplit& split, int level, std::int32_t vertex, VertexStar& star) {
  const auto& topology = split.level(level);
  const auto edges = topology.GetVertexEdges(vertex);
  const auto faces = topology.GetVertexFaces(vertex);
  star.vertex = vertex;
  star.sharpness = topology.GetVertexSharpness(vertex);
  star.face_count = faces.size();
  star.edge_ends.clear();
  star.edge_sharpness.clear();
  star.face_ends.clear();
  for (int i = 0; i < edges.size(); ++i) {
    const auto ends = topology.GetEdgeVertices(edges[i]);
    star.edge_ends.push_back(ends[0] == vertex ? ends[1] : ends[0]);
    star.edge_sharpness.push_back(topology.GetEdgeSharpness(edges[i]));
  }
  if (split.scheme() == PrimalScheme::Loop || level == 0) return;
  const auto corners = topology.GetVertexFaceLocalIndices(vertex);
  for (int i = 0; i < faces.size(); ++i) {
    star.face_ends.push_back(topology.GetFaceVertices(faces[i])[(corners[i] + 2) % 4]);
  }
}

std::int32_t sector_count(const VertexStar& star) {
  const auto sharp =
      static_cast<std::int32_t>(std::ranges::count_if(star.edge_sharpness, is_infinite));
  return std::max(star.is_boundary() ? sharp - 1 : sharp, 1);
}

std::int32_t sector_of(const VertexStar& star, std::int32_t face) {
  const std::int32_t count = sector_count(star);
  if (count == 1) return 0;
  for (std::int32_t index = 0; index < count; ++index) {
    const Sector faces = sector(star, index);
    const std::int32_t place = (face - faces.first_edge + star.edge_count()) % star.edge_count();
    if (place < faces.face_count) return index;
  }
  PLANISH_ASSERT(!"every face lies in a sector");
  return -1;
}

Sector sector(const VertexStar& star, std::int32_t index) {
  const std::int32_t n = star.edge_count();
  std::int32_t edge = first_sharp_edge(star);
  for (std::int32_t passed = 0;; ++passed) {
    std::int32_t faces = 1;
    while (!is_infinite(star.edge_sharpness[(edge + faces) % n])) ++faces;
    if (passed == index) return {edge, faces};
    edge = (edge + faces) % n;
  }
}

// Based on: Catmull & Clark 1978, Loop 1987, and OpenSubdiv's Sdc, which computes every mask.

namespace Sdc = OpenSubdiv::Sdc;

namespace {

// What Sdc::Scheme asks of the neighbourhood of a vertex and of an edge, in its spelling.
class VertexNeighborhood {
 public:
  explicit VertexNeighborhood(const VertexStar& star) : star_(star) {}
  [[nodiscard]] int GetNumEdges() const { return star_.edge_count(); }
  [[nodiscard]] int GetNumFaces() const { return star_.face_count; }
  [[nodiscard]] float GetSharpness() const { return star_.sharpness; }
  float* GetSharpnessPerEdge(float* sharpness) const {
    std::ranges::copy(star_.edge_sharpness, sharpness);
    return sharpness;
  }
  [[nodiscard]] float GetChildSharpness(const Sdc::Crease& crease) const {
    return crease.SubdivideVertexSharpness(star_.sharpness);
  }
  float* GetChildSharpnessPerEdge(const Sdc::Crease& crease, float* sharpness) const {
    crease.SubdivideEdgeSharpnessesAroundVertex(star_.edge_count(), star_.edge_sharpness.data(),
                                                sharpness);
    return sharpness;
  }

 private:
  const VertexStar& star_;
};

struct EdgeNeighborhood {
  float sharpness;
  std::int32_t face_count;
  [[nodiscard]] int GetNumFaces() const { return face_count; }
  [[nodiscard]] float GetSharpness() const { return sharpness; }
  void GetChildSharpnesses(const Sdc::Crease& crease, float* children) const {
    children[0] = children[1] = crease.SubdivideUniformSharpness(sharpness);
  }
  // For the option that smooths triangles, which is off.
  void GetNumVerticesPerFace(int* counts) const { std::fill(counts, counts + face_count, 4); }
};

// Calls `use` with the scheme's rules.
template <class Use>
void with_rules(PrimalScheme scheme, const Use& use) {
  if (scheme == PrimalScheme::Loop) {
    use(Sdc::Scheme<Sdc::SCHEME_LOOP>());
  } else {
    use(Sdc::Scheme<Sdc::SCHEME_CATMARK>());
  }
}

}  // namespace

void vertex_mask(PrimalScheme scheme, const VertexStar& star, SubdivisionMask& mask) {
  with_rules(scheme, [&](const auto& rules) {
    rules.ComputeVertexVertexMask(VertexNeighborhood(star), mask);
  });
}

void edge_mask(PrimalScheme scheme, float sharpness, std::int32_t face_count,
               SubdivisionMask& mask) {
  mask.SetFaceWeightsForFaceCenters(scheme == PrimalScheme::CatmullClark);
  with_rules(scheme, [&](const auto& rules) {
    rules.ComputeEdgeVertexMask(EdgeNeighborhood{sharpness, face_count}, mask);
  });
}

void limit_mask(PrimalScheme scheme, const VertexStar& star, LimitMasks& masks) {
  const Sdc::Crease::Rule rule = Sdc::Crease().DetermineVertexVertexRule(
      star.sharpness, star.edge_count(), star.edge_sharpness.data());
  with_rules(scheme, [&](const auto& rules) {
    rules.ComputeVertexLimitMask(VertexNeighborhood(star), masks.position, masks.du, masks.dv,
                                 rule);
  });
}

namespace {

// The limit of subdivision at a vertex. With quads (Catmull-Clark) or triangles (Loop) around it
// the star of a vertex determines the star of its child: p' = M p, where M depends on the sharpness
// of this step alone. Once all semi-sharpness has decayed M stays the same, and the limit is M's
// left eigenvector of eigenvalue 1, the tangents those of the next largest. Sdc knows them but for
// the cases below; before that the weights are pulled back through the semi-sharp steps.
// Based on: DeRose, Kass & Truong, "Subdivision surfaces in character animation", 1998 (creases);
// Halstead, Kass & DeRose, "Efficient, fair interpolation using Catmull-Clark surfaces", 1993.

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
      const double weight = portable::sin(std::numbers::pi * i / k);
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
