#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "limit/limit_case.h"
#include "limit/tessellation_error.h"
#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/queries/surface_queries.h"

namespace planish::test {
namespace {

// A tree whose corners have moved, against one made anew and against unions one by one.

bool same(const CornerBox& a, const CornerBox& b) { return a.low == b.low && a.high == b.high; }

// A surface whose control points of level 1 can be changed.
struct MovedCase {
  explicit MovedCase(const PolygonMesh& cage)
      : mesh(cage), placement(placement_of(mesh.positions)) {
    std::vector<glm::dvec3> unit;
    const auto prepared = prepare_mesh(mesh, "mesh");
    for (const std::int32_t v : prepared->vertices)
      unit.push_back(placement.to_unit(mesh.positions[v]));
    surface = std::make_shared<DooSabinSurface>(mesh, placement, unit,
                                                std::span<const glm::dvec3>{}, EvaluateOptions{});
    limit = std::make_unique<LimitSurface>(surface);
    (void)changed_corners();
  }
  // Moves some control points; returns the corners whose patches have others.
  std::vector<std::int32_t> move(std::mt19937& random, int count) {
    const PatchMesh& patches = surface->patches();
    std::uniform_int_distribution<std::int32_t> any(0, patches.state_size() - 1);
    std::normal_distribution<double> way(0, 0.1);
    for (int i = 0; i < count; ++i)
      surface->own_state()[any(random)] += glm::dvec3(way(random), way(random), way(random));
    patches.update_sums(surface->own_state());
    return changed_corners();
  }
  std::vector<std::int32_t> changed_corners() {
    const auto count = static_cast<std::size_t>(surface->topology().corner_count());
    last.resize(count);
    std::vector<std::int32_t> corners;
    LimitSurface::Corner corner(*limit);
    for (std::size_t c = count; c-- > 0;) {
      corner.move_to(static_cast<std::int32_t>(c));
      std::vector<glm::dvec3> points(corner.points().begin(), corner.points().end());
      points.push_back(corner.own());
      if (points != last[c]) corners.push_back(static_cast<std::int32_t>(c));
      last[c] = std::move(points);
    }
    return corners;
  }

  PolygonMesh mesh;
  Placement placement;
  std::shared_ptr<DooSabinSurface> surface;
  std::unique_ptr<LimitSurface> limit;
  std::vector<std::vector<glm::dvec3>> last;
};

// Every node holds what is below it, no more.
std::int64_t check_node(const CornerTree& tree, std::int32_t index) {
  const CornerTree::Node& node = tree.nodes()[index];
  CornerBox box{glm::vec3(1e30f), glm::vec3(-1e30f)};
  const auto add = [&](const CornerBox& other) {
    box = {glm::min(box.low, other.low), glm::max(box.high, other.high)};
  };
  std::int64_t count = 1;
  if (node.count > 0) {
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) add(tree.boxes()[i]);
  } else {
    for (const std::int32_t child : {index + 1, node.right}) {
      count += check_node(tree, child);
      add(tree.nodes()[child].box);
    }
  }
  EXPECT_TRUE(same(node.box, box)) << index;
  return count;
}

TEST(CornerTree, RefitsWhatHasMoved) {
  std::mt19937 random(6);
  for (const auto& [name, mesh] : limit_meshes()) {
    SCOPED_TRACE(name);
    MovedCase c(mesh);
    CornerTree tree(*c.limit);
    if (tree.nodes().empty()) continue;
    for (int i = 0; i < 4; ++i) {
      const std::vector<std::int32_t> corners = c.move(random, 3);
      const std::int64_t looked = tree.refit(corners);
      EXPECT_LE(looked, std::ssize(tree.nodes()));
      EXPECT_EQ(check_node(tree, 0), std::ssize(tree.nodes()));
    }
    const CornerTree fresh(*c.limit);
    ASSERT_EQ(fresh.corners().size(), tree.corners().size());
    std::vector<CornerBox> boxes(static_cast<std::size_t>(c.surface->topology().corner_count()));
    for (std::size_t i = 0; i < fresh.corners().size(); ++i)
      boxes[fresh.corners()[i]] = fresh.boxes()[i];
    for (std::size_t i = 0; i < tree.corners().size(); ++i)
      ASSERT_TRUE(same(tree.boxes()[i], boxes[tree.corners()[i]])) << i;
    tree.rebuild();
    EXPECT_EQ(tree.corners(), fresh.corners());
    for (std::size_t n = 0; n < fresh.nodes().size(); ++n)
      ASSERT_TRUE(same(tree.nodes()[n].box, fresh.nodes()[n].box)) << n;
    EXPECT_EQ(tree.refit({}), 0);
  }
}

TEST(CornerTree, LooksAtAsManyNodesAsAreAboveACorner) {
  for (const int size : {20, 80}) {
    const LimitCase c(torus(size, size, 1, 0.4));
    CornerTree tree(c.limit);
    const double height = std::log2(static_cast<double>(tree.corners().size()));
    for (const std::int32_t corner : {0, 7, size * size})
      EXPECT_LE(tree.refit(std::span(&corner, 1)), std::lround(std::ceil(height)) + 1);
    EXPECT_EQ(tree.refit(tree.corners()), std::ssize(tree.nodes()));
  }
}

template <class Random>
glm::dvec3 any_direction(Random& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random);
  return glm::normalize(glm::dvec3(x, y, normal(random)));
}

TEST(SurfaceRays, HitsLieOnTheSurfaceAndOnTheRay) {
  std::mt19937 random(21);
  int hits = 0;
  for (const auto& [name, mesh] : limit_meshes()) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const double size = c.surface->placement().diagonal;
    for (int i = 0; i < 20; ++i) {
      const SurfacePoint on = c.limit.evaluate(c.any_place(random));
      const glm::dvec3 direction = any_direction(random);
      const SurfaceRay ray{on.position - size * direction, 2.0 * direction};
      const auto all = queries.all_hits(ray);
      double nearest = 1e300;
      double last = -1;
      for (const SurfaceHit& hit : all) {
        ++hits;
        ASSERT_GE(hit.t, last);
        last = hit.t;
        ASSERT_LT(glm::length(ray.origin + hit.t * ray.direction - hit.position), 1e-10 * size);
        ASSERT_LT(glm::length(c.limit.evaluate(hit.at).position - hit.position), 1e-14 * size);
        nearest = std::min(nearest, std::abs(hit.t - 0.5 * size));
      }
      const bool is_steep = std::abs(glm::dot(on.normal, direction)) > 1e-3;
      const bool is_hidden =
          !c.surface->hidden().empty() || glm::length(glm::cross(on.du, on.dv)) == 0;
      if (is_steep && !is_hidden) {
        ASSERT_LT(nearest, 1e-9 * size) << "the place that was aimed at";
      }
      const auto first = queries.first_hit(ray);
      ASSERT_EQ(first.has_value(), !all.empty());
      ASSERT_EQ(queries.is_occluded(ray), !all.empty());
      if (first) {
        ASSERT_NEAR(first->t, all.front().t, 1e-9);
      }
    }
  }
  EXPECT_GT(hits, 500);
}

// Through a closed surface as often in as out.
TEST(SurfaceRays, EnterClosedSurfacesAsOftenAsTheyLeave) {
  std::mt19937 random(22);
  int tangent = 0, rays = 0;
  const int each = run_length(10'000) / 5;  // PLANISH_LONG_RUN=1000000 sends as many
  for (const auto& mesh :
       {cube(), torus(8, 6, 2, 1), icosphere(1), random_closed_mesh(2), random_closed_mesh(7)}) {
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const double size = c.surface->placement().diagonal;
    for (int i = 0; i < each; ++i, ++rays) {
      const glm::dvec3 through = c.surface->placement().centre + 0.4 * size * any_direction(random);
      const glm::dvec3 direction = any_direction(random);
      const auto hits = queries.all_hits({through - 3 * size * direction, direction});
      int entered = 0, touched = 0;
      for (const SurfaceHit& hit : hits) {
        touched += hit.is_tangent ? 1 : 0;
        entered += glm::dot(hit.normal, direction) < 0 ? 1 : -1;
      }
      tangent += touched;
      if (touched == 0) {
        ASSERT_EQ(hits.size() % 2, 0u) << i;
        ASSERT_EQ(entered, 0) << i;
      }
    }
  }
  RecordProperty("tangent", tangent);
  EXPECT_LT(tangent, rays / 1000);
}

// Which it does over many of a patch's smallest pieces, seen from their edge.
TEST(SurfaceRays, AlongTheSurfaceTouchIt) {
  std::mt19937 random(23);
  for (const auto& mesh : {cube(), torus(8, 6, 2, 1), random_closed_mesh(2)}) {
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const double size = c.surface->placement().diagonal;
    for (int i = 0; i < 40; ++i) {
      const SurfacePoint on = c.limit.evaluate(c.any_place(random));
      const double angle = 0.37 * i;
      const glm::dvec3 along = glm::normalize(std::cos(angle) * on.du + std::sin(angle) * on.dv);
      double nearest = 1e300;
      for (const SurfaceHit& hit : queries.all_hits({on.position - 2 * size * along, along})) {
        if (hit.is_tangent) nearest = std::min(nearest, glm::length(hit.position - on.position));
      }
      EXPECT_LT(nearest, 1e-4 * size) << i;
    }
  }
}

// At vertices, edges and centres, where many patches meet: each place once.
TEST(SurfaceRays, BordersOfPatchesAreHitOnce) {
  for (const auto& mesh : {cube(), torus(8, 6, 2, 1), icosphere(1), dodecahedron()}) {
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const double size = c.surface->placement().diagonal;
    for (std::int32_t corner = 0; corner < c.limit.topology().corner_count(); ++corner) {
      for (const auto& [u, v] :
           {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.5, 0.0}, {0.5, 0.5}}) {
        const SurfacePoint on =
            c.limit.evaluate(surface_parameter(c.limit.topology(), corner, u, v));
        const SurfaceRay ray{on.position + 0.01 * size * on.normal, -on.normal, 0, 0.02 * size};
        const auto hits = queries.all_hits(ray);
        ASSERT_EQ(hits.size(), 1u) << corner << " " << u << " " << v;
        ASSERT_NEAR(hits[0].t, 0.01 * size, 1e-7 * size);
      }
    }
  }
}

TEST(SurfaceRays, RangesCut) {
  const LimitCase c(torus(12, 8, 2, 1));
  const SurfaceQueries queries(c.limit);
  const glm::dvec3 from(-10, 0.01, 0.02), along(1, 0, 0);
  const auto all = queries.all_hits({from, along});
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(queries.all_hits({from, along, all[0].t + 1e-6, all[3].t - 1e-6}).size(), 2u);
  EXPECT_FALSE(queries.is_occluded({from, along, 0, all[0].t - 1e-6}));
  EXPECT_NEAR(queries.first_hit({from, along, all[0].t + 1e-6})->t, all[1].t, 1e-12);
}

// How often a tessellation winds around a point: the solid angles of its triangles (Van Oosterom &
// Strackee 1983).
double winding_number(const SurfaceMesh& surface, const glm::dvec3& point) {
  double sum = 0;
  for (const Triangle& t : triangles_of_surface(surface)) {
    const auto at = [&](std::size_t k) { return surface.positions[t[k]] - point; };
    const glm::dvec3 a = at(0), b = at(1), c = at(2);
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += 2 * std::atan2(
                   glm::dot(a, glm::cross(b, c)),
                   la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

struct SignCase {
  explicit SignCase(const PolygonMesh& mesh)
      : c(mesh),
        queries(c.limit),
        surface(c.tessellated(3)),
        size(c.surface->placement().diagonal) {}

  // Of points that lie further off than the tessellation does.
  void expect_sign(const glm::dvec3& point) {
    const double distance = queries.closest(point).distance;
    if (distance < 4e-3 * size) return;
    const double winding = winding_number(surface, point);
    ASSERT_NEAR(winding, std::round(winding), 1e-6);
    const bool inside = std::abs(std::lround(winding)) % 2 == 1;
    ASSERT_EQ(queries.signed_distance(point), inside ? -distance : distance);
    ++(inside ? inside_count : outside_count);
  }

  LimitCase c;
  SurfaceQueries queries;
  SurfaceMesh surface;
  double size;
  int inside_count = 0, outside_count = 0;
};

PolygonMesh sharp_cube() {
  PolygonMesh mesh = cube();
  for (const auto& face : faces_of(mesh)) {
    for (std::size_t i = 0; i < face.size(); ++i)
      if (face[i] < face[(i + 1) % face.size()])
        mesh.creases.push_back({face[i], face[(i + 1) % face.size()], 10.0});
  }
  return mesh;
}

std::vector<NamedMesh> creased_meshes() {
  std::vector<NamedMesh> meshes{{"cube", sharp_cube()}};
  for (const std::uint32_t seed : {1u, 4u})
    meshes.push_back({"random " + std::to_string(seed),
                      with_random_creases(random_closed_mesh(seed), 0.3, seed)});
  meshes.push_back({"torus", with_random_creases(torus(7, 5, 2, 1), 0.3, 3)});
  return meshes;
}

TEST(SignedDistance, IsNegativeInside) {
  for (const bool creased : {false, true}) {
    PolygonMesh mesh = cube();
    const auto face = mesh.face(0);
    if (creased) mesh.creases = {{face[0], face[1], 10.0}, {face[1], face[2], 10.0}};
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    std::mt19937 random(13);
    for (int i = 0; i < 50; ++i) {
      const SurfacePoint on = c.limit.evaluate(c.any_place(random));
      EXPECT_NEAR(queries.signed_distance(on.position + 1e-3 * on.normal), 1e-3, 1e-4);
      EXPECT_NEAR(queries.signed_distance(on.position - 1e-3 * on.normal), -1e-3, 1e-4);
    }
    glm::dvec3 middle(0.0);
    for (const glm::dvec3& p : mesh.positions) middle += p / 8.0;
    EXPECT_LT(queries.signed_distance(middle), 0);
    EXPECT_GT(queries.signed_distance(middle + glm::dvec3(10, 11, 12)), 0);
  }
}

// Where the nearest place is one of a sharp edge, the normal of either side can be the wrong one.
TEST(SignedDistance, IsThatOfTheWindingNumberOppositeCreases) {
  for (const auto& [name, mesh] : creased_meshes()) {
    SCOPED_TRACE(name);
    SignCase of(mesh);
    const MeshTopology& topology = of.c.limit.topology();
    int edges = 0;
    for (std::int32_t corner = 0; corner < topology.corner_count() && edges < 12; ++corner) {
      const std::int32_t twin = topology.twin(corner);
      if (twin < 0 || !of.c.surface->patches().is_sharp(corner)) continue;
      ++edges;
      const double u = 0.05 + 0.9 * (edges % 7) / 6;
      const SurfacePoint here = of.c.limit.evaluate(surface_parameter(topology, corner, u, 0));
      const glm::dvec3 there =
          of.c.limit.evaluate(surface_parameter(topology, topology.next(twin), 0, u)).normal;
      // Across the edge in its own plane, between both normals and beyond them.
      for (const double share : {-0.4, 0.0, 0.3, 0.5, 0.9, 1.0, 1.4}) {
        const glm::dvec3 way = (1 - share) * here.normal + share * there;
        if (glm::length(way) < 0.1) continue;
        for (const double off : {6e-3, 0.05, 1.0}) {
          for (const double side : {1.0, -1.0})
            of.expect_sign(here.position + side * off * of.size * glm::normalize(way));
        }
      }
    }
    EXPECT_GT(edges, 5);
    EXPECT_GT(of.inside_count, 10);
    EXPECT_GT(of.outside_count, 50);
  }
}

// From points before the places where the first direction that is tried only touches the surface.
TEST(SignedDistance, IsThatOfTheWindingNumberWhereRaysGraze) {
  const glm::dvec3 along = glm::normalize(glm::dvec3(0.8191, 0.4233, 0.3874));
  for (const auto& [name, mesh] : creased_meshes()) {
    SCOPED_TRACE(name);
    SignCase of(mesh);
    const MeshTopology& topology = of.c.limit.topology();
    int places = 0;
    const auto on = [&](std::int32_t corner, double u, double v) {
      return of.c.limit.evaluate(surface_parameter(topology, corner, u, v));
    };
    const auto ask_before = [&](const glm::dvec3& position) {
      ++places;
      for (const double way : {0.02, 0.3, 1.1}) of.expect_sign(position - way * of.size * along);
    };
    for (std::int32_t corner = 0; corner < topology.corner_count() && places < 16; ++corner) {
      for (const double v : {0.23, 0.71}) {
        const auto facing = [&](double u) { return glm::dot(on(corner, u, v).normal, along) > 0; };
        double low = 0.01, high = 0.99;
        if (facing(low) == facing(high)) continue;
        for (int i = 0; i < 60; ++i) {
          const double middle = 0.5 * (low + high);
          (facing(middle) == facing(low) ? low : high) = middle;
        }
        ask_before(on(corner, low, v).position);
      }
      // And where it touches a sharp edge.
      const std::int32_t twin = topology.twin(corner);
      if (twin < 0 || !of.c.surface->patches().is_sharp(corner)) continue;
      const double u = 0.37;
      const bool here = glm::dot(on(corner, u, 0).normal, along) > 0;
      const bool there = glm::dot(on(topology.next(twin), 0, u).normal, along) > 0;
      if (here != there) ask_before(on(corner, u, 0).position);
    }
    EXPECT_GT(places, 5);
    EXPECT_GT(of.outside_count, 10);
  }
}

constexpr double kInfinite = std::numeric_limits<double>::infinity();

bool is_finite_vector(const glm::dvec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// Questions of every kind to one surface, near and far, on it, and with numbers that are none.
class Asker {
 public:
  Asker(const PolygonMesh& mesh, std::uint32_t seed) : case_(mesh), random_(seed) {}

  void ask() {
    switch (std::uniform_int_distribution<int>(0, 2)(random_)) {
      case 0:
        return evaluate();
      case 1:
        return closest();
      default:
        return rays();
    }
  }

 private:
  [[nodiscard]] double size() const { return case_.surface->placement().diagonal; }
  glm::dvec3 any_vector() {
    const double x = normal_(random_), y = normal_(random_);
    return {x, y, normal_(random_)};
  }
  // Also exactly on borders.
  double any_share() {
    constexpr double kOften[] = {0, 0.5, 1, 1e-9, 1 - 1e-9, 1e-300};
    const int kind = std::uniform_int_distribution<int>(0, 11)(random_);
    return kind < 6 ? kOften[kind] : std::uniform_real_distribution<double>(0, 1)(random_);
  }
  SurfaceParameter any_place() {
    const MeshTopology& topology = case_.limit.topology();
    const std::int32_t corner =
        std::uniform_int_distribution<std::int32_t>(0, topology.corner_count() - 1)(random_);
    const double u = any_share();
    return surface_parameter(topology, corner, u, any_share());
  }
  glm::dvec3 any_point() {
    const glm::dvec3 on = case_.limit.evaluate(any_place()).position;
    constexpr double kOff[] = {0, 1e-16, 1e-9, 1e-4, 1e-2, 0.3, 1, 1e3, 1e8, 1e100, 1e200};
    return on + kOff[std::uniform_int_distribution<int>(0, 10)(random_)] * size() * any_vector();
  }
  void evaluate() {
    const SurfacePoint p = case_.limit.evaluate(any_place());
    ASSERT_TRUE(is_finite_vector(p.position) && is_finite_vector(p.normal));
    ASSERT_NEAR(glm::length(p.normal), 1, 1e-12);
    for (const glm::dvec3& d : {p.du, p.dv, p.duu, p.duv, p.dvv}) ASSERT_TRUE(is_finite_vector(d));
    const PointCurvature curvature = p.curvature();
    if (curvature.is_known) {
      ASSERT_TRUE(std::isfinite(curvature.mean) && std::isfinite(curvature.gaussian));
    }
  }
  void closest() {
    glm::dvec3 point = any_point();
    const int kind = std::uniform_int_distribution<int>(0, 19)(random_);
    if (kind < 2) {
      point[kind] = kind == 0 ? std::nan("") : kInfinite;
      ASSERT_THROW((void)queries_.closest(point), Error);
      return;
    }
    const ClosestPoint found = queries_.closest(point);
    ASSERT_TRUE(is_finite_vector(found.position) && is_finite_vector(found.normal));
    ASSERT_TRUE(std::isfinite(found.distance));
    ASSERT_TRUE(case_.limit.evaluate(found.at).position == found.position);
  }
  void rays() {
    SurfaceRay ray{any_point(), any_vector()};
    const int kind = std::uniform_int_distribution<int>(0, 19)(random_);
    if (kind == 0) ray.direction = {};
    if (kind == 1) ray.direction.y = kInfinite;
    if (kind == 2) ray.origin.x = std::nan("");
    if (kind < 3) {
      ASSERT_THROW((void)queries_.first_hit(ray), Error);
      return;
    }
    if (kind == 3) ray.direction = {0, 0, 1};
    if (kind == 4) ray.direction *= 1e-200;
    if (kind == 5) ray.direction *= 1e150;
    if (kind == 6) ray.t_max = -1;
    const auto all = queries_.all_hits(ray);
    for (const SurfaceHit& hit : all) {
      ASSERT_TRUE(is_finite_vector(hit.position) && is_finite_vector(hit.normal));
      ASSERT_FALSE(std::isnan(hit.t));
    }
    ASSERT_EQ(queries_.first_hit(ray).has_value(), !all.empty());
    ASSERT_EQ(queries_.is_occluded(ray), !all.empty());
  }

  LimitCase case_;
  SurfaceQueries queries_{case_.limit};
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

// PLANISH_LONG_RUN=1000000 asks as often.
TEST(AnyQuestion, IsAnsweredOrRefused) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SCENES))
    if (entry.path().extension() == ".obj") paths.push_back(entry.path());
  std::ranges::sort(paths);
  ASSERT_GT(paths.size(), 10u);
  const int each = run_length(1'000) / static_cast<int>(paths.size());
  std::uint32_t seed = 1;
  for (const auto& path : paths) {
    SCOPED_TRACE(path.filename().string());
    const MeshFile file = read_mesh(path);
    Asker asker(file.mesh, seed++);
    for (int i = 0; i < each; ++i) {
      asker.ask();
      if (HasFatalFailure()) FAIL() << "question " << i;
    }
  }
}

}  // namespace
}  // namespace planish::test
