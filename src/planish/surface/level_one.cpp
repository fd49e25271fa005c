// The polygons of level 1 are the rings of control points around the vertices of Q_1, which come in
// the order: vertices, faces, edges of the mesh.
#include "planish/surface/level_one.h"

#include <algorithm>
#include <string>

#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/surface/subdivided_mesh.h"

namespace planish {

namespace {

EvaluateOptions first_level(const SharpFeatureOptions& sharp) {
  EvaluateOptions options{.level = 0};
  options.sharp = sharp;
  return options;
}

class MeshBuilder {
 public:
  MeshBuilder(const SubdividedMesh& base, PolygonMesh& result) : base_(base), result_(result) {}

  void add_polygons() {
    const auto count = base_.split.counts(1).vertices;
    for (std::int32_t v = 0; v < count; ++v) {
      gather_ring(base_.subdivision, 1, v, ring_);
      if (!ring_.sectors.empty()) {
        for (const VertexRing::Sector& sector : ring_.sectors) add_sector(sector);
        if (ring_.kind == VertexKind::Crease && ring_.sectors.size() == 2) {
          tag_crease(ring_.sectors[0].curve0, ring_.sectors[0].curve1);
        }
      } else if (ring_.kind == VertexKind::Corner) {
        add_cone();
      } else if (ring_.kind == VertexKind::Dart) {
        polygon_ = {curve_point_at(v)};
        polygon_.insert(polygon_.end(), ring_.faces.begin(), ring_.faces.end());
        add_polygon(ring_.faces.front());
      } else if (ring_.faces.size() >= 3) {
        polygon_ = ring_.faces;
        add_polygon(ring_.faces.front());
      }
    }
  }

 private:
  // `face`: of Q_1, whose group the polygon takes.
  void add_polygon(std::int32_t face) {
    result_.add_face(polygon_);
    const PolygonMesh& mesh = base_.used.mesh;
    if (!mesh.face_groups.empty()) {
      const auto& offsets = mesh.face_offsets;
      const auto above = std::upper_bound(offsets.begin(), offsets.end(), face);
      result_.face_groups.push_back(mesh.face_groups[above - offsets.begin() - 1]);
    }
  }

  void add_sector(const VertexRing::Sector& sector) {
    polygon_.clear();
    if (ring_.kind == VertexKind::Corner) {
      polygon_.push_back(ring_.corner_point);
      if (is_interior(sector.curve0)) tag_crease(ring_.corner_point, sector.curve0);
    }
    polygon_.push_back(sector.curve0);
    const auto first = ring_.faces.begin() + sector.first;
    polygon_.insert(polygon_.end(), first, first + sector.count);
    polygon_.push_back(sector.curve1);
    add_polygon(*first);
  }

  // A tagged vertex without sharp edges.
  void add_cone() {
    const std::size_t n = ring_.faces.size();
    for (std::size_t i = 0; i < n; ++i) {
      polygon_ = {ring_.corner_point, ring_.faces[i], ring_.faces[(i + 1) % n]};
      add_polygon(ring_.faces[i]);
    }
  }

  // The curve point at a vertex of the mesh where one sharp edge ends.
  [[nodiscard]] std::int32_t curve_point_at(std::int32_t vertex) const {
    const auto& topology = base_.split.level(0);
    const auto edges = topology.GetVertexEdges(vertex);
    for (int i = 0; i < edges.size(); ++i) {
      const std::int32_t sharp = base_.subdivision.sharp_of_edge(0, edges[i]);
      if (sharp < 0) continue;
      const int end = topology.GetEdgeVertices(edges[i])[0] == vertex ? 0 : 1;
      return static_cast<std::int32_t>(base_.subdivision.state_layout(1).first_sharp) + 2 * sharp +
             end;
    }
    PLANISH_ASSERT(!"no sharp edge ends here");
    return -1;
  }

  [[nodiscard]] bool is_interior(std::int32_t curve_point) const {
    const auto first = static_cast<std::int32_t>(base_.subdivision.state_layout(1).first_sharp);
    const int edge = base_.subdivision.edge_of_sharp(0, (curve_point - first) / 2);
    return base_.split.level(0).GetEdgeFaces(edge).size() == 2;
  }

  void tag_crease(std::int32_t a, std::int32_t b) {
    result_.creases.push_back({a, b, kInfiniteSharpness});
  }

  const SubdividedMesh& base_;
  PolygonMesh& result_;
  VertexRing ring_;
  std::vector<std::int32_t> polygon_;
};

// A face's control point takes the mean of the colours at the corners of its face of Q_1.
void carry_colors(const SubdividedMesh& base, PolygonMesh& result) {
  const PolygonMesh& mesh = base.used.mesh;
  if (mesh.colors.empty()) return;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto vertices = mesh.face(f);
    const std::size_t m = vertices.size();
    glm::vec4 centre(0.0f);
    for (const std::int32_t v : vertices) centre += mesh.colors[v] / static_cast<float>(m);
    for (std::size_t i = 0; i < m; ++i) {
      result.colors.push_back(0.25f * centre + 0.5f * mesh.colors[vertices[i]] +
                              0.125f * mesh.colors[vertices[(i + 1) % m]] +
                              0.125f * mesh.colors[vertices[(i + m - 1) % m]]);
    }
  }
  for (std::int32_t s = 0; s < base.features.sharp_edge_count; ++s) {
    const auto ends = base.split.level(0).GetEdgeVertices(base.subdivision.edge_of_sharp(0, s));
    const glm::vec4 a = mesh.colors[ends[0]], b = mesh.colors[ends[1]];
    result.colors.push_back(0.75f * a + 0.25f * b);
    result.colors.push_back(0.75f * b + 0.25f * a);
  }
  for (const std::int32_t v : base.features.corner_vertices) {
    result.colors.push_back(mesh.colors[v]);
  }
}

}  // namespace

void require_state_of(const Subdivision& subdivision, const LevelOne& level_one) {
  const std::int64_t size = subdivision.state_layout(1).size;
  if (static_cast<std::int64_t>(level_one.state.size()) == size) return;
  throw Error(ErrorCode::InvalidArgument,
              "level 1 of this mesh with these creases has " + std::to_string(size) +
                  " control points, and " + std::to_string(level_one.state.size()) + " are given");
}

PolygonMesh level_one_mesh(const PolygonMesh& mesh, const LevelOne& level_one,
                           const SharpFeatureOptions& sharp) {
  const SubdividedMesh base(mesh, first_level(sharp));
  require_state_of(base.subdivision, level_one);
  PolygonMesh result;
  for (const glm::dvec3& point : level_one.state) {
    result.positions.push_back(level_one.placement.to_model(point));
  }
  MeshBuilder(base, result).add_polygons();
  const auto first_corner =
      static_cast<std::int32_t>(base.subdivision.state_layout(1).first_corner);
  for (std::int32_t c = 0; c < base.features.corner_count; ++c) {
    result.corners.push_back({first_corner + c, kInfiniteSharpness});
  }
  if (!base.used.mesh.face_groups.empty()) result.groups = base.used.mesh.groups;
  carry_colors(base, result);
  return result;
}

std::vector<glm::dvec3> limit_points(const Subdivision& subdivision,
                                     std::span<const glm::dvec3> state) {
  const auto count = static_cast<std::size_t>(subdivision.split().counts(0).vertices);
  std::vector<glm::dvec3> limits(count);
  parallel_for(count, 1024, [&](std::size_t begin, std::size_t end) {
    VertexRing ring;
    for (std::size_t v = begin; v < end; ++v) {
      gather_ring(subdivision, 1, static_cast<std::int32_t>(v), ring);
      if (ring.kind == VertexKind::Corner) {
        limits[v] = state[ring.corner_point];
      } else if (ring.kind == VertexKind::Crease) {
        const VertexRing::Sector& sector = ring.sectors.front();
        limits[v] = 0.5 * (state[sector.curve0] + state[sector.curve1]);
      } else {
        // About one of the points: far from the origin the sum would lose digits.
        const glm::dvec3 origin = state[ring.faces.front()];
        glm::dvec3 sum(0.0);
        for (const std::int32_t face : ring.faces) sum += state[face] - origin;
        limits[v] = origin + sum / static_cast<double>(ring.faces.size());
      }
    }
  });
  return limits;
}

std::vector<glm::dvec3> limit_positions(const PolygonMesh& mesh, const LevelOne& level_one,
                                        const SharpFeatureOptions& sharp) {
  const SubdividedMesh base(mesh, first_level(sharp));
  require_state_of(base.subdivision, level_one);
  const auto points = limit_points(base.subdivision, level_one.state);
  std::vector<glm::dvec3> limits = mesh.positions;
  for (std::size_t v = 0; v < points.size(); ++v) {
    limits[base.used.vertices[v]] = level_one.placement.to_model(points[v]);
  }
  return limits;
}

}  // namespace planish
