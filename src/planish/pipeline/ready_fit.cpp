#include "planish/pipeline/ready_fit.h"

#include <algorithm>
#include <string>
#include <utility>

namespace planish {

void WarningList::add(const Warning& warning) const {
  const auto same = [&](const Warning& other) {
    return other.code == warning.code && other.message == warning.message;
  };
  if (std::ranges::any_of(list_, same)) return;
  list_.push_back(warning);
  caller_.warn(warning);
}

Preparation preparation_of(const MeshFitOptions& options, InterpolationMethod method,
                           std::span<const std::uint8_t> may_join) {
  return {.repairs = options.repairs,
          .uses_tags = options.fit.sharp.use_tags,
          .finds_features = options.finds_features,
          .crease_degrees = options.crease_degrees,
          .method = method,
          .weld = options.weld,
          .found = nullptr,
          .pairs_triangles = options.quads == QuadChoice::On,
          .may_join = may_join,
          .stands_alone = options.stands_alone};
}

void take(FittedMesh& result, ReadyMesh&& ready, std::string_view name,
          const WarningList& warnings) {
  for (Warning change : ready.changes) {
    change.message = std::string(name) + ": " + change.message;
    warnings.add(change);
  }
  result.mesh = std::move(ready.mesh);
  result.welded_count = ready.welded_count;
  result.paired_count = ready.paired_count;
  result.changed_faces = std::move(ready.changed_faces);
  result.separated_edges = std::move(ready.separated_edges);
  result.source_vertices = std::move(ready.source_vertices);
  result.source_faces = std::move(ready.source_faces);
  result.options.prepared = std::move(ready.prepared);
  result.found = std::move(ready.found);
}

FittedMesh without_fit(const FittedMesh& fitted) {
  FittedMesh result;
  result.options = fitted.options;
  result.repairs = fitted.repairs;
  result.uses_tags = fitted.uses_tags;
  result.finds_features = fitted.finds_features;
  result.crease_degrees = fitted.crease_degrees;
  result.weld = fitted.weld;
  result.split_normals = fitted.split_normals;
  result.pairs_triangles = fitted.pairs_triangles;
  result.welded_count = fitted.welded_count;
  result.density = fitted.density;
  result.changed_faces = fitted.changed_faces;
  result.separated_edges = fitted.separated_edges;
  result.warnings = fitted.warnings;
  return result;
}

ReadyMesh ready_again(const FittedMesh& fitted) {
  ReadyMesh ready;
  ready.mesh = fitted.mesh;
  ready.welded_count = fitted.welded_count;
  ready.paired_count = fitted.paired_count;
  ready.changed_faces = fitted.changed_faces;
  ready.separated_edges = fitted.separated_edges;
  ready.source_vertices = fitted.source_vertices;
  ready.source_faces = fitted.source_faces;
  ready.prepared = fitted.options.prepared;
  ready.found = fitted.found;
  return ready;
}

}  // namespace planish
