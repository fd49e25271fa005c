#include "make_scenes/scan.h"

#include "make_scenes/mesh_builder.h"
#include "make_scenes/rocker_arm.h"
#include "make_scenes/sample_points.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish::shapes {

PolygonMesh scan(const PolygonMesh& shape, const Field& field, const Mesher& mesher,
                 const ScanOptions& options) {
  constexpr double kLongestStep = 0.01;  // facets lie that near to the surface they stand for
  PointCloud cloud;
  cloud.points = options.sampling == Sampling::Uniform
                     ? sample_uniform(shape, options.point_count, options.seed)
                     : sample_poisson_disk(shape, options.point_count, options.seed);
  for (glm::dvec3& p : cloud.points) {
    if (field) p = projected(field, p, kLongestStep);
    p = {rounded(p.x), rounded(p.y), rounded(p.z)};
  }
  ReconstructOptions reconstruction;
  reconstruction.tolerance = options.tolerance;
  reconstruction.least_angle = options.least_angle;
  reconstruction.pair_quads = options.pair_quads;
  reconstruction.clean.outliers = OutlierRule::Off;
  return reconstruct(cloud, mesher, reconstruction).mesh;
}

PolygonMesh scanned_rocker_arm(const Mesher& mesher) {
  ScanOptions options;
  options.point_count = 100'000;
  options.tolerance = 3e-4;
  options.least_angle = 3;  // a mesh that is hard to interpolate
  return scan(rocker_arm(), rocker_arm_field, mesher, options);
}

}  // namespace planish::shapes
