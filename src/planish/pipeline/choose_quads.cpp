#include "planish/pipeline/choose_quads.h"

#include <cstdint>

#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/mesh/pair_triangles.h"
#include "planish/pipeline/fit_best.h"
#include "planish/pipeline/make_ready.h"

namespace planish {

namespace {

// Where fewer vertices tell anything, the mesh is one of flat and sharp parts.
constexpr double kFewTell = 0.05;

}  // namespace

bool are_mostly_triangles(const PolygonMesh& mesh) {
  std::int64_t count = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) count += mesh.face_size(f) == 3 ? 1 : 0;
  return 2 * count >= mesh.face_count();
}

Halves look_halved(const PolygonMesh& mesh, const PreparedMesh& prepared,
                   std::optional<double> crease_degrees) {
  const HalvedVertices found = halved_vertices(mesh, prepared, pair_options(crease_degrees));
  const auto tell = static_cast<double>(found.telling);
  if (tell <= kFewTell * static_cast<double>(found.looked_at)) return Halves::Maybe;
  const double share = static_cast<double>(found.regular) / tell;
  if (share >= kPlainShare && found.telling >= kPlainCount) return Halves::Plain;
  if (found.regular == found.telling && found.telling >= kPlainAll) return Halves::Plain;
  return share >= kHalvedShare ? Halves::Maybe : Halves::No;
}

QuadReason choose_quads(const BendingFigures& triangles, const BendingFigures& quads) {
  QuadReason reason{.triangles = triangles, .quads = quads};
  const bool fold_more =
      quads.folded_area >= kSoundFoldedArea && quads.folded_area > triangles.folded_area;
  if (!quads.converged) {
    reason.text = "triangles: the surface of quads misses the tolerance";
  } else if (!triangles.converged) {
    reason.are_better = true;
    reason.text =
        "triangles joined to quads, without which it misses the tolerance (--quads off leaves "
        "them)";
  } else if (fold_more) {
    reason.text =
        formatted("triangles: that of quads folds {} of the area", percent(quads.folded_area));
  } else if (quads.bending < triangles.bending - kSameBending * (1 + triangles.bending)) {
    reason.are_better = true;
    reason.text =
        formatted("triangles joined to quads: the surface bends {} less (--quads off leaves them)",
                  percent(1 - quads.bending / triangles.bending));
  } else if (quads.bending <= kSameBending) {
    reason.are_better = true;
    reason.text = "triangles joined to quads: all is flat (--quads off leaves them)";
  } else {
    reason.text = "triangles: the surface of quads bends no less";
  }
  return reason;
}

}  // namespace planish
