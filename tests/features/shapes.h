#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// A shape whose sharp edges are known: those between places for which `is_sharp` holds.
struct FeatureCase {
  std::string name;
  PolygonMesh mesh;
  std::function<bool(const glm::dvec3& a, const glm::dvec3& b)> is_sharp;
};

using Outline2 = std::vector<glm::dvec2>;

/// A polygon of n corners on an ellipse.
[[nodiscard]] Outline2 ellipse(int n, double a, double b);

/// The body over an outline from z = 0 to `height`, the upper outline scaled by `taper`.
[[nodiscard]] PolygonMesh extruded(const Outline2& outline, double height, double taper = 1);
/// The same with a hole of `inner`, which has as many corners.
[[nodiscard]] PolygonMesh hollow(const Outline2& outer, const Outline2& inner, double height);

/// Each face in triangles from its first corner; of concave ones ears are cut off.
[[nodiscard]] PolygonMesh in_fans(const PolygonMesh& mesh);
/// Each face in triangles by ears that are drawn by lot.
[[nodiscard]] PolygonMesh cut_by_lot(const PolygonMesh& mesh, std::uint32_t seed);

/// Families that the constants were looked at with, and such as were held out.
[[nodiscard]] std::vector<FeatureCase> tuned_cases();
[[nodiscard]] std::vector<FeatureCase> held_out_cases();

template <class Change>
[[nodiscard]] PolygonMesh moved(PolygonMesh mesh, const Change& change) {
  for (glm::dvec3& p : mesh.positions) p = change(p);
  return mesh;
}
/// Turned, about an axis that goes with nothing.
[[nodiscard]] PolygonMesh turned(PolygonMesh mesh);
/// The other way round, which turns its faces, too.
[[nodiscard]] PolygonMesh mirrored(const PolygonMesh& mesh);
/// An edge is named by the lower of its vertices first.
using EdgeSet = std::set<std::pair<std::int32_t, std::int32_t>>;
[[nodiscard]] EdgeSet set_of(const std::vector<CreaseEdge>& edges);

/// Numbers by lot.
class Lot {
 public:
  explicit Lot(std::uint32_t seed) : random_(seed) {}
  /// From `least` to `most`, both of them included.
  [[nodiscard]] int whole(int least, int most);
  [[nodiscard]] double real(double least, double most);
  /// Evenly by its logarithm.
  [[nodiscard]] double ratio(double least, double most);
  [[nodiscard]] bool chance(double probability) { return real(0, 1) < probability; }

 private:
  std::mt19937 random_;
};

/// A mesh that is made of smooth surfaces: where two of them meet its edges are sharp.
struct Body {
  PolygonMesh mesh;
  std::vector<std::int32_t> surfaces;  ///< of each face which; kFacet: one of its own
};
inline constexpr std::int32_t kFacet = -1;

/// Bodies of a kind, with sizes, angles and counts by lot.
struct BodyFamily {
  const char* name;
  std::function<Body(Lot& lot)> draw;
};
/// Those that the rules were looked at with; those that were written afterwards; those of which
/// edges are lost.
[[nodiscard]] const std::vector<BodyFamily>& known_families();
[[nodiscard]] const std::vector<BodyFamily>& held_out_families();
[[nodiscard]] const std::vector<BodyFamily>& weak_families();

/// A mesh whose sharp edges are known.
struct KnownMesh {
  PolygonMesh mesh;
  std::vector<CreaseEdge> sharp;
};
[[nodiscard]] KnownMesh known_mesh(const Body& body);

/// The same body in another mesh, `what` says how: edges and faces with more vertices, faces cut in
/// other ways, in another order, mirrored, turned, of another size, elsewhere, moved by rounding,
/// beside another.
[[nodiscard]] KnownMesh presented(const Body& body, Lot& lot, std::string& what);

}  // namespace planish::test
