// How many bodies of many kinds, drawn by lot and meshed in many ways, lose or gain sharp edges:
// features_sweep [bodies of each kind] [meshes of each body] [kind]
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "features/shapes.h"
#include "planish/features/find_features.h"

namespace planish::test {
namespace {

struct Tally {
  int bodies = 0, lost = 0, uneven = 0;
};

// Whether all meshes of the body have its edges.
void look(const BodyFamily& family, std::uint32_t seed, int meshes, Tally& tally) {
  Lot lot(seed);
  const Body body = family.draw(lot);
  int wrong = 0;
  for (int k = 0; k < meshes; ++k) {
    std::string what;
    const KnownMesh known = k == 0 ? known_mesh(body) : presented(body, lot, what);
    const EdgeSet found = set_of(find_features(known.mesh).sharp_edges()),
                  expected = set_of(known.sharp);
    if (found == expected) continue;
    int missed = 0, more = 0;
    for (const auto& edge : expected) missed += found.contains(edge) ? 0 : 1;
    for (const auto& edge : found) more += expected.contains(edge) ? 0 : 1;
    if (wrong++ == 0)
      std::printf("  %s, seed %u: %d of %zu missed, %d more%s\n", family.name, seed, missed,
                  expected.size(), more, what.c_str());
  }
  ++tally.bodies;
  tally.lost += wrong > 0 ? 1 : 0;
  tally.uneven += wrong > 0 && wrong < meshes ? 1 : 0;
}

void sweep(const std::vector<BodyFamily>& families, int bodies, int meshes, const std::string& only,
           Tally& all) {
  for (const BodyFamily& family : families) {
    if (!only.empty() && only != family.name) continue;
    Tally tally;
    for (int i = 0; i < bodies; ++i) look(family, static_cast<std::uint32_t>(i + 1), meshes, tally);
    std::printf("%-24s lost %3d of %3d, %d in some meshes only\n", family.name, tally.lost,
                tally.bodies, tally.uneven);
    all.bodies += tally.bodies;
    all.lost += tally.lost;
    all.uneven += tally.uneven;
  }
}

}  // namespace
}  // namespace planish::test

int main(int count, char** values) {
  using namespace planish::test;
  const int bodies = count > 1 ? std::atoi(values[1]) : 10;
  const int meshes = count > 2 ? std::atoi(values[2]) : 4;
  const std::string only = count > 3 ? values[3] : "";
  for (const auto& [name, families] :
       {std::pair("known", known_families()), std::pair("held out", held_out_families()),
        std::pair("weak", weak_families())}) {
    Tally all;
    sweep(families, bodies, meshes, only, all);
    std::printf("%s: lost %d of %d bodies in %d meshes each, %d of them in some meshes only\n\n",
                name, all.lost, all.bodies, meshes, all.uneven);
  }
}
