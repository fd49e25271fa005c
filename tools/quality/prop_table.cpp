#include "quality/prop_table.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <glm/geometric.hpp>
#include <set>
#include <stdexcept>
#include <utility>

#include "make_scenes/random_numbers.h"
#include "planish/backend/cpu_backend.h"
#include "planish/features/find_features.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/placement.h"
#include "planish/pipeline/fit_mesh.h"
#include "quality/outcome_table.h"
#include "quality/prop_shapes.h"
#include "quality/true_pieces.h"
#include "quality/truth.h"

namespace planish::quality {

namespace {

// Segments of the true shape, and how many times those of the prop they are at least.
constexpr std::int32_t kTrueSegments = 256, kLeastFineness = 8;

// A figure against another body would say nothing: the prop's vertices lie on the true shape, but
// for what its facets cut off beside a vertex between two of its meridians.
void check_truth(const Case& made) {
  constexpr double kOff = 1e-3;  // of the diagonal
  const Truth truth = true_mesh(made.source);
  const double most = kOff * placement_of(made.mesh).diagonal;
  for (const glm::dvec3& p : made.mesh.positions)
    if (glm::distance(truth(p).point, p) > most)
      throw std::logic_error(made.name + " is not coarsely what it is finely");
}

Case case_of(const Prop& prop, bool is_held_out) {
  Case made{prop.name, prop.make(1), {}};
  // One number for all of a thing's parts: what is smaller has fewer segments, coarse and fine.
  made.source = prop.make(std::max(kLeastFineness, kTrueSegments / prop.segments));
  made.has_smooth_source = true;
  made.is_held_out = is_held_out;
  check_truth(made);
  return made;
}

std::vector<std::pair<std::string, MeshFitOptions>> all_flags() {
  auto all = mesh_flags();
  for (const double degrees : {20.0, 35.0}) {
    for (const QuadChoice quads : {QuadChoice::Off, QuadChoice::On}) {
      MeshFitOptions options;
      options.method = InterpolationMethod::Fair;
      options.chooses_creases = false;
      options.crease_degrees = degrees;
      options.quads = quads;
      all.emplace_back("fair, creases from " + std::to_string(static_cast<int>(degrees)) +
                           (quads == QuadChoice::On ? ", quads" : ""),
                       options);
    }
  }
  return all;
}

// Edges that are sharp in the shapes, and others, by what is found in the props.
struct EdgeTally {
  std::int64_t found = 0, missed = 0, more = 0;

  void add(const Case& made) {
    const TruePieces pieces(made.source, made.mesh);
    const MeshTopology topology(made.mesh);
    std::set<std::pair<std::int32_t, std::int32_t>> sharp;
    for (const CreaseEdge& edge : find_features(made.mesh, topology).sharp_edges())
      sharp.insert(std::minmax(edge.v0, edge.v1));
    for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
      const std::int32_t corner = topology.corner_of(e), twin = topology.twin(corner);
      if (twin < 0) continue;
      const auto [v, w] = topology.edge_vertices(e);
      const bool is_found = sharp.contains(std::minmax(v, w));
      const bool is_sharp = pieces.are_apart(topology.face_of(corner), topology.face_of(twin));
      found += is_sharp && is_found ? 1 : 0;
      missed += is_sharp && !is_found ? 1 : 0;
      more += !is_sharp && is_found ? 1 : 0;
    }
  }
};

}  // namespace

std::vector<NamedCase> prop_cases() {
  // Of each two in a row one: those that are added at the end leave the others where they are.
  shapes::RandomNumbers lot(1941);
  std::vector<NamedCase> cases;
  std::int32_t held_out = 0;
  for (auto* list : {&game_props, &machine_props}) {
    std::int32_t place = 0;
    for (const Prop& prop : list()) {
      if (place % 2 == 0) held_out = lot.below(2);
      const bool is_held_out = place++ % 2 == held_out;
      cases.push_back({prop.name, [prop, is_held_out] { return case_of(prop, is_held_out); }});
    }
  }
  return cases;
}

std::vector<std::string> print_prop_table(const std::vector<NamedCase>& cases) {
  const auto backend = make_cpu_backend();
  OutcomeTable table(false);
  std::array<EdgeTally, 2> edges;
  for (const NamedCase& named : cases) {
    const Case made = named.make();
    std::vector<Outcome> others;
    for (const auto& [flags, options] : all_flags())
      others.push_back(fitted(made, flags, options, *backend));
    table.add(made, nullptr, fitted(made, "", {}, *backend), others);
    edges[made.is_held_out ? 1 : 0].add(made);
  }
  std::vector<std::string> wrong = table.finish();
  for (const bool is_held_out : {false, true}) {
    const EdgeTally& tally = edges[is_held_out ? 1 : 0];
    std::printf("%s: %lld sharp edges found, %lld missed, %lld more\n",
                is_held_out ? "held out (*)" : "others", static_cast<long long>(tally.found),
                static_cast<long long>(tally.missed), static_cast<long long>(tally.more));
  }
  return wrong;
}

}  // namespace planish::quality
