#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

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
