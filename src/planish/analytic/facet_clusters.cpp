#include "planish/analytic/facet_clusters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "planish/analytic/face_patches.h"
#include "planish/core/vectors.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

class ClusterMaker {
 public:
  ClusterMaker(std::span<const glm::dvec3> positions, const MeshTopology& topology,
               std::span<const char> is_sharp, double tolerance)
      : positions_(positions),
        topology_(topology),
        tolerance_(tolerance),
        patches_(positions, topology, is_sharp) {}

  FacetClusters make() && {
    measure();
    gather();
    join();
    return std::move(result_);
  }

 private:
  void measure() {
    for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
      const auto vertices = topology_.face(f);
      double longest = 0;
      glm::dvec3 centre(0.0);
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        const glm::dvec3 &from = positions_[vertices[i]],
                         &to = positions_[vertices[(i + 1) % vertices.size()]];
        longest = std::max(longest, glm::length(to - from));
        centre += from / static_cast<double>(vertices.size());
      }
      const glm::dvec3 area = area_vector(positions_, vertices);
      result_.facets.push_back({unit_or_zero(area), glm::length(area), centre});
      // What an error of the vertices turns the normal by, at most.
      const double height = longest > 0 ? 2 * glm::length(area) / longest : 0;
      result_.doubt.push_back(height > 0 ? std::min(2 * tolerance_ / height, std::numbers::pi)
                                         : std::numbers::pi);
    }
  }

  [[nodiscard]] double height_over(std::int32_t face, const glm::dvec3& origin,
                                   const glm::dvec3& normal) const {
    double largest = 0;
    for (const std::int32_t v : topology_.face(face))
      largest = std::max(largest, std::abs(glm::dot(positions_[v] - origin, normal)));
    return largest;
  }

  void gather() {
    const std::vector<Facet>& facets = result_.facets;
    std::vector<std::int32_t>& cluster_of = result_.cluster_of;
    cluster_of.assign(facets.size(), -1);
    std::vector<std::int32_t> order(facets.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::greater<>(),
                             [&](std::int32_t f) { return facets[f].area; });
    for (const std::int32_t first : order) {
      if (cluster_of[first] >= 0) continue;
      const auto index = static_cast<std::int32_t>(result_.clusters.size());
      FacetCluster cluster;
      cluster.faces.push_back(first);
      cluster_of[first] = index;
      const glm::dvec3 origin = positions_[topology_.face(first)[0]];
      glm::dvec3 sum = facets[first].area * facets[first].normal;
      for (std::size_t i = 0; i < cluster.faces.size(); ++i) {
        patches_.each_neighbour(cluster.faces[i], [&](std::int32_t next) {
          if (cluster_of[next] >= 0) return;
          const Facet& facet = facets[next];
          const glm::dvec3 normal = sum / std::max(glm::length(sum), 1e-300);
          const double turn = angle_between(normal, facet.normal);
          if (turn > result_.doubt[next] + 1e-6 && facet.area > 0) return;
          if (height_over(next, origin, normal) > tolerance_) return;
          cluster_of[next] = index;
          cluster.faces.push_back(next);
          sum += facet.area * facet.normal;
        });
      }
      cluster.facet.normal = sum / std::max(glm::length(sum), 1e-300);
      cluster.facet.area = glm::length(sum);
      result_.clusters.push_back(std::move(cluster));
    }
  }

  void join() {
    for (std::int32_t c = 0; c < std::ssize(result_.clusters); ++c) {
      auto& neighbours = result_.clusters[c].neighbours;
      for (const std::int32_t f : result_.clusters[c].faces)
        patches_.each_neighbour(f, [&](std::int32_t other) {
          if (result_.cluster_of[other] != c) neighbours.push_back(result_.cluster_of[other]);
        });
      std::ranges::sort(neighbours);
      const auto rest = std::ranges::unique(neighbours);
      neighbours.erase(rest.begin(), rest.end());
    }
  }

  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  double tolerance_;
  FacePatches patches_;
  FacetClusters result_;
};

}  // namespace

FacetClusters make_facet_clusters(std::span<const glm::dvec3> positions,
                                  const MeshTopology& topology, std::span<const char> is_sharp,
                                  double tolerance) {
  return ClusterMaker(positions, topology, is_sharp, tolerance).make();
}

}  // namespace planish
