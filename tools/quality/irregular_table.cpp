#include "quality/irregular_table.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "planish/backend/cpu_backend.h"
#include "planish/mesh/placement.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/evaluate.h"
#include "quality/facet_figures.h"
#include "quality/manifold_peer.h"
#include "quality/verdict.h"

namespace planish::quality {

namespace {

// Of the flat triangles', so much is left at most.
constexpr double kOfFlatNormals = 0.5;
// Of manifold's.
constexpr double kOfManifoldNormals = 0.9;

struct Measured {
  FacetFigures figures;
  double milliseconds = 0;
};

Measured by_planish(const Case& what, int more_levels, Backend& backend) {
  Measured measured;
  const auto start = std::chrono::steady_clock::now();
  const FittedMesh fitted = fit_mesh(what.mesh, what.name, backend);
  const SurfaceMesh surface =
      evaluate(fitted.mesh, fitted.fit, backend,
               fitted.evaluate_options(fitted.density.level() + more_levels));
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  measured.milliseconds = took.count();
  measured.figures = facet_figures(facets_of(surface), what.truth);
  return measured;
}

std::optional<Measured> by_manifold(const Case& what, std::int64_t facets,
                                    const std::filesystem::path& folder) {
  if (folder.empty()) return std::nullopt;
  const double share = static_cast<double>(facets) / what.mesh.face_count();
  const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(share))));
  const std::optional<PeerSurface> made = smoothed_by_manifold(what.mesh, n, folder);
  if (!made) return std::nullopt;
  return Measured{facet_figures(made->facets, what.truth), made->milliseconds};
}

void print(const FacetFigures& f, double diagonal) {
  std::printf(" %.2f, %.1e, %.2f |", f.normals, f.distance / diagonal, 100 * f.turning);
}

void print(const Measured& m, double diagonal) {
  std::printf(" %.2f, %.1e, %.2f; %.4f; %lld; %.0f |", m.figures.normals,
              m.figures.distance / diagonal, 100 * m.figures.turning, 100 * m.figures.folded,
              static_cast<long long>(m.figures.facets), m.milliseconds);
}

// What is worse than the peer.
std::string behind(const FacetFigures& own, const FacetFigures& peer) {
  std::string text;
  const auto note = [&](bool is_behind, const char* name) {
    if (is_behind) text += (text.empty() ? "" : ", ") + std::string(name);
  };
  note(own.normals > kOfManifoldNormals * peer.normals, "normals");
  note(own.distance > peer.distance, "distance");
  note(own.turning > peer.turning, "turning");
  note(own.folded > peer.folded, "folds");
  return text;
}

}  // namespace

std::vector<std::string> print_irregular_table(const std::vector<NamedCase>& cases,
                                               const IrregularOptions& options) {
  std::printf(
      "| shape (triangles) | flat: normals, distance, turning %% | planish: the same; folded %%; "
      "facets; ms | manifold | of flat | of manifold | behind |\n|---|--:|--:|--:|--:|--:|---|\n");
  const auto backend = make_cpu_backend();
  std::vector<std::string> wrong;
  for (const NamedCase& named : cases) {
    const Case made = named.make();
    const double diagonal = placement_of(made.mesh).diagonal;
    const FacetFigures flat = facet_figures(made.mesh, made.truth);
    const Measured own = by_planish(made, options.more_levels, *backend);
    const std::optional<Measured> peer = by_manifold(made, own.figures.facets, options.manifold);
    std::printf("| %s%s (%d) |", made.name.c_str(), made.is_held_out ? "*" : "",
                made.mesh.face_count());
    print(flat, diagonal);
    print(own, diagonal);
    if (peer) {
      print(*peer, diagonal);
    } else {
      std::printf(" - |");
    }
    std::printf(" %.2f |", own.figures.normals / flat.normals);
    if (peer) {
      std::printf(" %.2f | %s |\n", own.figures.normals / peer->figures.normals,
                  behind(own.figures, peer->figures).c_str());
    } else {
      std::printf(" - | |\n");
    }
    std::fflush(stdout);
    const auto require = [&](const char* figure, double value, double limit) {
      if (!(value <= limit)) wrong.push_back(shortfall(made, figure, value, limit));
    };
    require("normals", own.figures.normals, kOfFlatNormals * flat.normals);
    require("distance", own.figures.distance, flat.distance);
    require("folded area", own.figures.folded, flat.folded);
    require("turning", own.figures.turning, flat.turning);
  }
  return wrong;
}

}  // namespace planish::quality
