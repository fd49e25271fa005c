// Based on: surface/level_one_mesh.cpp, whose vertices are numbered in the order of the file:
// corners, two points on each sharp edge, corner vertices; and whose polygons lie around vertices,
// faces, edges. An edge stands where its first corner does.
#include "planish/distributed/fair_cage.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/distributed/sub_mesh.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/surface/level_one_mesh.h"

namespace planish {

namespace {

// Counts the keys of all ranks in their order.
class DenseNumbers {
 public:
  // Each key once, on any rank.
  DenseNumbers(const Ranks& ranks, std::int64_t key_total, std::span<const std::int64_t> own)
      : ranks_(ranks), layout_(even_layout(key_total, ranks.size)) {
    const auto got = route<std::int64_t>(
        ranks, own, [&](std::int64_t key, std::size_t) { return owner_of(layout_, key); });
    keys_.assign(got.begin(), got.end());
    std::ranges::sort(keys_);
    const std::int64_t count = std::ssize(keys_);
    before_ = sum_before(ranks, count);
    total_ = sum_over(ranks, count);
  }

  [[nodiscard]] std::int64_t total() const { return total_; }
  // Of ascending keys that are among all. All ranks together.
  [[nodiscard]] RawVector<std::int64_t> numbers_of(std::span<const std::int64_t> keys) const {
    return fetch<std::int64_t>(ranks_, keys, layout_, [&](std::int64_t place) {
      const std::int64_t key = layout_[ranks_.rank] + place;
      return before_ + (std::ranges::lower_bound(keys_, key) - keys_.begin());
    });
  }

 private:
  const Ranks& ranks_;
  Layout layout_;
  std::vector<std::int64_t> keys_;  // of this rank's run, ascending
  std::int64_t before_ = 0, total_ = 0;
};

class FairCageMaker {
 public:
  FairCageMaker(const Ranks& ranks, const MeshPart& part, const CornerStarts& corners)
      : ranks_(ranks), part_(part), corners_(corners) {}

  FairCage make(const PartFair& fair, const SharpFeatureOptions& sharp) {
    agree(ranks_, [&] { make_net(fair, sharp); });
    number_state();
    FairCage cage;
    place_points(cage);
    place_polygons(cage);
    return cage;
  }

 private:
  void make_net(const PartFair& fair, const SharpFeatureOptions& sharp) {
    sub_ = SubMeshMaker(part_).make(0, part_.owned_count(), Rings::TwoTagged);
    topology_ = topology_of_sound(sub_.mesh);
    features_ = find_sharp_features(sub_.mesh, *topology_, sub_.mesh.positions, sharp);
    LevelOne level_one;
    level_one.state = fair.state;
    level_one.placement = fair.placement;
    if (sub_.mesh.face_count() == 0) return;  // a rank that owns nothing
    // At the rim a tagged edge may end at another copy of its vertex.
    std::erase_if(sub_.mesh.creases, [&](const CreaseEdge& crease) {
      return topology_->find_edge(crease.v0, crease.v1) < 0;
    });
    net_ = level_one_mesh(sub_.mesh, level_one, sharp, &around_);
  }

  [[nodiscard]] bool is_owned(std::int32_t sub_vertex) const {
    return sub_.vertices[sub_vertex] < part_.owned_count();
  }
  [[nodiscard]] std::int64_t number_of(std::int32_t sub_vertex) const {
    return part_.number_of(sub_.vertices[sub_vertex]);
  }
  [[nodiscard]] bool is_mine(std::int64_t number) const {
    return owner_of(part_.layout, number) == ranks_.rank;
  }
  [[nodiscard]] bool is_my_edge(std::int32_t edge) const {
    const auto [v0, v1] = topology_->edge_vertices(edge);
    return is_mine(std::min(number_of(v0), number_of(v1)));
  }
  [[nodiscard]] bool touches_mine(std::int32_t edge) const {
    const auto [v0, v1] = topology_->edge_vertices(edge);
    return is_owned(v0) || is_owned(v1);
  }
  // Of the corner that an edge leads from, in the file.
  [[nodiscard]] std::int64_t place_of_edge(std::int32_t edge) const {
    return numbers_[topology_->corner_of(edge)];
  }

  // The number in the file of each control point of level 1 that polygons of this rank name.
  void number_state() {
    numbers_.assign(net_.positions.size(), -1);
    const auto starts =
        fetch<std::int64_t>(ranks_, part_.face_ids, corners_.faces,
                            [&](std::int64_t place) { return corners_.starts[place]; });
    for (std::int32_t f = 0; f < part_.face_count(); ++f)
      for (std::int32_t c = part_.face_offsets[f]; c < part_.face_offsets[f + 1]; ++c)
        numbers_[c] = starts[f] + c - part_.face_offsets[f];
    const std::int64_t curves = number_curves();
    const std::int64_t points = number_corners(corners_.total + curves);
    total_ = corners_.total + curves + points;
  }

  std::int64_t number_curves() {
    std::vector<std::int64_t> own, named;
    std::vector<std::int32_t> edges;
    for (std::int32_t e = 0; e < std::ssize(features_.sharp_of_edge); ++e) {
      if (features_.sharp_of_edge[e] < 0 || !touches_mine(e)) continue;
      edges.push_back(e);
      if (is_my_edge(e)) own.push_back(place_of_edge(e));
    }
    // Edges ascend with their first corners, here and in the file.
    for (const std::int32_t edge : edges) named.push_back(place_of_edge(edge));
    const DenseNumbers sharp(ranks_, corners_.total, own);
    const auto numbers = sharp.numbers_of(named);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const std::int32_t point = topology_->corner_count() + 2 * features_.sharp_of_edge[edges[i]];
      numbers_[point] = corners_.total + 2 * numbers[i];
      numbers_[point + 1] = numbers_[point] + 1;
    }
    return 2 * sharp.total();
  }

  std::int64_t number_corners(std::int64_t before) {
    std::vector<std::int64_t> own;
    std::vector<std::int32_t> points;
    const std::int32_t first = topology_->corner_count() + 2 * features_.sharp_edge_count;
    for (std::int32_t c = 0; c < features_.corner_count; ++c) {
      const std::int32_t vertex = features_.corner_vertices[c];
      if (!is_owned(vertex)) continue;
      own.push_back(part_.file_ids[sub_.vertices[vertex]]);
      points.push_back(first + c);
    }
    const DenseNumbers corners(ranks_, vertex_total(), own);
    // A sub mesh has its vertices in the order of the file.
    const auto numbers = corners.numbers_of(own);
    for (std::size_t i = 0; i < points.size(); ++i) numbers_[points[i]] = before + numbers[i];
    return corners.total();
  }

  // Each point by the owner of its vertex.
  void place_points(FairCage& cage) const {
    std::vector<std::int64_t> ids;
    std::vector<glm::dvec3> points;
    const auto add = [&](std::int32_t point, std::int32_t vertex) {
      if (!is_owned(vertex)) return;
      ids.push_back(numbers_[point]);
      points.push_back(net_.positions[point]);
    };
    for (std::int32_t c = 0; c < topology_->corner_count(); ++c) add(c, sub_.mesh.face_vertices[c]);
    for (std::int32_t e = 0; e < std::ssize(features_.sharp_of_edge); ++e) {
      if (features_.sharp_of_edge[e] < 0) continue;
      const std::int32_t point = topology_->corner_count() + 2 * features_.sharp_of_edge[e];
      const auto [v0, v1] = topology_->edge_vertices(e);
      add(point, v0);
      add(point + 1, v1);
    }
    const std::int32_t first = topology_->corner_count() + 2 * features_.sharp_edge_count;
    for (std::int32_t c = 0; c < features_.corner_count; ++c)
      add(first + c, features_.corner_vertices[c]);
    cage.vertices = even_layout(total_, ranks_.size);
    cage.positions = in_file_order(ranks_, cage.vertices, ids, points);
  }

  // Where the polygons around an element stand among all; -1: another rank has them.
  [[nodiscard]] std::int64_t place_of_ring(std::int32_t ring) const {
    const std::int32_t vertices = sub_.mesh.vertex_count(), faces = sub_.mesh.face_count();
    if (ring < vertices) return is_owned(ring) ? part_.file_ids[sub_.vertices[ring]] : -1;
    if (ring < vertices + faces) {
      const std::int32_t face = ring - vertices;
      std::int64_t first = number_of(sub_.mesh.face(face).front());
      for (const std::int32_t v : sub_.mesh.face(face)) first = std::min(first, number_of(v));
      return is_mine(first) ? vertex_total() + part_.face_ids[sub_.faces[face]] : -1;
    }
    const std::int32_t edge = ring - vertices - faces;
    return is_my_edge(edge) ? vertex_total() + face_total() + place_of_edge(edge) : -1;
  }

  void place_polygons(FairCage& cage) const {
    const Layout layout = even_layout(vertex_total() + face_total() + corners_.total, ranks_.size);
    // Place, size, corners; place, size, ...
    std::vector<std::pair<std::int64_t, std::int32_t>> own;
    for (std::int32_t f = 0; f < net_.face_count(); ++f)
      if (const std::int64_t place = place_of_ring(around_[f]); place >= 0)
        own.emplace_back(place, f);
    std::ranges::stable_sort(own, {}, &std::pair<std::int64_t, std::int32_t>::first);
    std::vector<std::int64_t> stream, counts(static_cast<std::size_t>(ranks_.size), 0);
    for (const auto& [place, face] : own) {
      const auto named = net_.face(face);
      counts[owner_of(layout, place)] += 2 + std::ssize(named);
      stream.insert(stream.end(), {place, std::ssize(named)});
      for (const std::int32_t point : named) stream.push_back(numbers_[point]);
    }
    const auto got = all_to_all<std::int64_t>(ranks_, stream, counts);
    std::vector<std::size_t> begins;
    for (std::size_t at = 0; at < got.size(); at += 2 + got[at + 1]) begins.push_back(at);
    // All polygons around an element come from one rank, in their order.
    std::ranges::stable_sort(begins, {}, [&](std::size_t at) { return got[at]; });
    std::vector<std::int64_t> sizes, corners;
    for (const std::size_t at : begins) {
      sizes.push_back(got[at + 1]);
      corners.insert(corners.end(), got.begin() + at + 2, got.begin() + at + 2 + got[at + 1]);
    }
    cage.face_total = sum_over(ranks_, std::ssize(sizes));
    cage.faces = encode_faces(ranks_, sizes, corners, total_);
  }

  [[nodiscard]] std::int64_t vertex_total() const { return part_.layout.back(); }
  [[nodiscard]] std::int64_t face_total() const { return corners_.faces.back(); }

  const Ranks& ranks_;
  const MeshPart& part_;
  const CornerStarts& corners_;
  SubMesh sub_;
  std::shared_ptr<const MeshTopology> topology_;
  SharpFeatures features_;
  PolygonMesh net_;
  std::vector<std::int32_t> around_;   // of each polygon of the net: its ring
  std::vector<std::int64_t> numbers_;  // of each point of the net: that in the file; -1: not named
  std::int64_t total_ = 0;             // points of all ranks
};

}  // namespace

CornerStarts corner_starts_of(const Ranks& ranks, const MeshSlice& slice) {
  const std::int64_t holes = sum_over(ranks, std::ssize(slice.holes));
  if (holes > 0)
    throw AgreedError(ErrorCode::InvalidArgument,
                      formatted("--cage: ranks write no cage of a fair surface with holes, and {} "
                                "faces are tagged so; leave it out, or take planish on one machine",
                                holes));
  CornerStarts corners;
  corners.faces = slice.faces;
  const auto own = static_cast<std::int64_t>(slice.face_vertices.size());
  corners.total = sum_over(ranks, own);
  const std::int64_t before = sum_before(ranks, own);
  corners.starts.assign(slice.face_offsets.begin(), slice.face_offsets.end() - 1);
  for (std::int64_t& start : corners.starts) start += before;
  return corners;
}

FairCage make_fair_cage(const Ranks& ranks, const MeshPart& part, const PartFair& fair,
                        const CornerStarts& corners, const SharpFeatureOptions& sharp) {
  return FairCageMaker(ranks, part, corners).make(fair, sharp);
}

}  // namespace planish
