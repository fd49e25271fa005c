#include "planish/pipeline/look_halved.h"

#include <cstdint>

#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/pair_triangles.h"
#include "planish/pipeline/make_ready.h"

namespace planish {

namespace {

// Where fewer vertices tell anything, the mesh is one of flat and sharp parts.
constexpr double kFewTell = 0.05;

bool are_mostly_triangles(const PolygonMesh& mesh) {
  std::int64_t count = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) count += mesh.face_size(f) == 3 ? 1 : 0;
  return 2 * count >= mesh.face_count();
}

}  // namespace

Halves look_halved(const PolygonMesh& mesh, const PreparedMesh& prepared,
                   std::optional<double> crease_degrees) {
  if (!are_mostly_triangles(mesh)) return Halves::No;
  const HalvedVertices found = halved_vertices(mesh, prepared, pair_options(crease_degrees));
  const auto tell = static_cast<double>(found.telling);
  if (tell <= kFewTell * static_cast<double>(found.looked_at)) return Halves::Maybe;
  const double share = static_cast<double>(found.regular) / tell;
  if (share >= kPlainShare && found.telling >= kPlainCount) return Halves::Plain;
  if (found.regular == found.telling && found.telling >= kPlainAll) return Halves::Plain;
  return share >= kHalvedShare ? Halves::Maybe : Halves::No;
}

std::vector<Halves> look_halved_by_parts(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                         std::optional<double> crease_degrees) {
  const MeshParts parts = mesh_parts(mesh);
  if (parts.count <= 1) return {look_halved(mesh, prepared, crease_degrees)};
  std::vector<Halves> looks;
  for (const PolygonMesh& part : meshes_of(parts, mesh))
    looks.push_back(look_halved(part, *prepare_mesh(part, "part"), crease_degrees));
  return looks;
}

}  // namespace planish
