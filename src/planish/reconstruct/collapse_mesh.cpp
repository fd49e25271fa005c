// Based on: H. Hoppe, T. DeRose, T. Duchamp, J. McDonald, W. Stuetzle, "Mesh Optimization", 1993
// (when a collapse keeps the topology).
#include "planish/reconstruct/collapse_mesh.h"

#include <utility>

namespace planish {

CollapseMesh::CollapseMesh(std::span<const Triangle> triangles, std::size_t vertex_count)
    : twins_(twins_of(triangles, vertex_count)),
      outgoing_(vertex_count, -1),
      valences_(vertex_count, 0),
      marks_(vertex_count, 0) {
  corners_.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles)
    corners_.insert(corners_.end(), triangle.begin(), triangle.end());
  for (std::size_t h = 0; h < corners_.size(); ++h) {
    const std::int32_t vertex = corners_[h];
    if (outgoing_[vertex] < 0 || twins_[h] < 0) outgoing_[vertex] = static_cast<std::int32_t>(h);
    ++valences_[vertex];
    // An inner edge is counted by the half-edge out of the vertex, a boundary edge also here.
    if (twins_[h] < 0) ++valences_[end(static_cast<std::int32_t>(h))];
  }
}

void CollapseMesh::get_fan(std::int32_t vertex, Fan& fan) const {
  fan.spokes.clear();
  fan.ring.clear();
  const std::int32_t first = outgoing_[vertex];
  fan.closed = twins_[first] >= 0;
  std::int32_t h = first;
  do {
    fan.spokes.push_back(h);
    fan.ring.push_back(end(h));
    const std::int32_t before = previous_half_edge(h);
    h = twins_[before];
    if (h < 0) fan.ring.push_back(start(before));
  } while (h >= 0 && h != first);
}

bool CollapseMesh::are_neighbours(std::int32_t a, std::int32_t b) const {
  bool found = false;
  for_each_neighbour(a, [&](std::int32_t neighbour) { found |= neighbour == b; });
  return found;
}

bool CollapseMesh::can_collapse(std::int32_t vertex, const Fan& fan, std::size_t target) {
  const std::int32_t other = fan.ring[target];
  // A boundary vertex may only run along the boundary, or the loops would change.
  if (!fan.closed && target != 0 && target + 1 != fan.ring.size()) return false;
  if (fan.closed && fan.ring.size() < 3) return false;
  if (!fan.closed && fan.spokes.size() < 2) return false;
  ++mark_;
  for (const std::int32_t neighbour : fan.ring) marks_[neighbour] = mark_;
  std::int32_t shared = 0;
  for_each_neighbour(other, [&](std::int32_t n) { shared += marks_[n] == mark_; });
  if (shared != (fan.closed ? 2 : 1)) return false;
  // Three neighbours: the triangle that is left must not exist on the other side.
  const std::size_t count = fan.ring.size();
  const auto keeps_valence = [&](std::size_t at) {
    const std::int32_t v = fan.ring[at % count];
    return valences_[v] - 1 >= (is_boundary(v) ? 2 : 3);
  };
  if (fan.closed)
    return keeps_valence(target + 1) && keeps_valence(target + count - 1) &&
           valences_[vertex] + valences_[other] - 4 >= (is_boundary(other) ? 2 : 3);
  return keeps_valence(target == 0 ? 1 : count - 2) &&
         valences_[vertex] + valences_[other] - 3 >= 2;
}

void CollapseMesh::glue(std::int32_t a, std::int32_t b) {
  if (a >= 0) twins_[a] = b;
  if (b >= 0) twins_[b] = a;
}

// The first half-edge of an open fan is the one without a twin.
void CollapseMesh::set_outgoing(std::int32_t vertex, std::int32_t half_edge) {
  std::int32_t h = half_edge;
  while (twins_[h] >= 0) {
    h = next_half_edge(twins_[h]);
    if (h == half_edge) break;
  }
  outgoing_[vertex] = h;
}

void CollapseMesh::collapse(std::int32_t vertex, const Fan& fan, std::size_t target) {
  const std::int32_t other = fan.ring[target];
  const std::size_t count = fan.ring.size();
  // Spoke i is the triangle (vertex, ring[i], ring[i + 1]); those with the target go.
  std::vector<std::int32_t> dropped;
  if (target < fan.spokes.size()) dropped.push_back(fan.spokes[target]);
  if (target > 0 || fan.closed) dropped.push_back(fan.spokes[(target + count - 1) % count]);
  std::int32_t kept = -1;  // a half-edge out of the target that stays
  std::vector<std::pair<std::int32_t, std::int32_t>> outgoing;
  for (const std::int32_t spoke : fan.spokes) corners_[spoke] = other;
  for (const std::int32_t spoke : dropped) {
    const std::int32_t across = next_half_edge(spoke), back = previous_half_edge(spoke);
    // The side with the target and the side with the vertex become one edge.
    const bool target_first = fan.ring[target] == corners_[across];
    const std::int32_t third = target_first ? corners_[back] : corners_[across];
    const std::int32_t target_side = twins_[across];
    const std::int32_t vertex_side = target_first ? twins_[back] : twins_[spoke];
    if (target_side >= 0) twins_[target_side] = vertex_side;
    if (vertex_side >= 0) twins_[vertex_side] = target_side;
    for (const std::int32_t side : {target_side, vertex_side}) {
      if (side < 0) continue;
      const bool from_third = corners_[side] == third;
      outgoing.emplace_back(third, from_third ? side : next_half_edge(side));
      kept = from_third ? next_half_edge(side) : side;
    }
    --valences_[third];
  }
  for (const std::int32_t spoke : dropped)
    for (int i = 0; i < 3; ++i) corners_[spoke - spoke % 3 + i] = -1;
  for (const auto& [third, half_edge] : outgoing) set_outgoing(third, half_edge);
  set_outgoing(other, kept);
  valences_[other] += valences_[vertex] - 2 - static_cast<std::int32_t>(dropped.size());
  outgoing_[vertex] = -1;
  valences_[vertex] = 0;
}

bool CollapseMesh::can_flip(std::int32_t half_edge) {
  const std::int32_t other = twins_[half_edge];
  if (other < 0) return false;
  const std::int32_t c = end(next_half_edge(half_edge)), d = end(next_half_edge(other));
  const auto loses_one = [&](std::int32_t v) { return valences_[v] > (is_boundary(v) ? 2 : 3); };
  return c != d && loses_one(start(half_edge)) && loses_one(end(half_edge)) &&
         !are_neighbours(c, d);
}

void CollapseMesh::flip(std::int32_t half_edge) {
  const std::int32_t h = half_edge, g = twins_[h];
  const std::int32_t h1 = next_half_edge(h), h2 = previous_half_edge(h);
  const std::int32_t g1 = next_half_edge(g), g2 = previous_half_edge(g);
  const std::int32_t a = corners_[h], b = corners_[g], c = corners_[h2], d = corners_[g2];
  const std::int32_t bc = twins_[h1], ca = twins_[h2], ad = twins_[g1], db = twins_[g2];
  corners_[h] = c, corners_[h1] = d, corners_[h2] = b;
  corners_[g] = d, corners_[g1] = c, corners_[g2] = a;
  glue(h, g);
  glue(h1, db);
  glue(h2, bc);
  glue(g1, ca);
  glue(g2, ad);
  // glue() leaves a stale twin where the far side is the boundary.
  twins_[h1] = db, twins_[h2] = bc, twins_[g1] = ca, twins_[g2] = ad;
  --valences_[a], --valences_[b], ++valences_[c], ++valences_[d];
  set_outgoing(a, g2);
  set_outgoing(b, h2);
  set_outgoing(c, h);
  set_outgoing(d, g);
}

}  // namespace planish
