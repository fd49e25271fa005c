#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/check.h"
#include "planish/primal/scheme.h"
#include "support/meshes.h"

namespace planish::test {

inline constexpr Weights kBothWeights[] = {Weights::DooSabin, Weights::Averaged};

/// Small closed meshes without tags: every platonic kind, prisms, poles, valence 2, random ones.
[[nodiscard]] std::vector<NamedMesh> closed_meshes();

/// Small open meshes without tags.
[[nodiscard]] std::vector<NamedMesh> open_meshes();

/// Meshes with creases, corners and darts, open and closed.
[[nodiscard]] std::vector<NamedMesh> sharp_meshes();

/// All three.
[[nodiscard]] std::vector<NamedMesh> all_meshes();

inline constexpr PrimalScheme kBothPrimalSchemes[] = {PrimalScheme::CatmullClark,
                                                      PrimalScheme::Loop};

/// Every face of more than three corners as a fan of triangles from its first corner.
[[nodiscard]] PolygonMesh as_triangles(const PolygonMesh& mesh);

/// Tags each edge, and each vertex with a tenth of that, with the given probability and a
/// sharpness between 0 and 4.
[[nodiscard]] PolygonMesh with_random_sharpness(PolygonMesh mesh, double probability,
                                                std::uint32_t seed);

/// The catalogue's closed, open and sharp meshes, some with semi-sharp tags and one with
/// a tagged tip; as triangles for Loop.
[[nodiscard]] std::vector<NamedMesh> primal_meshes(PrimalScheme scheme);

/// A cube with all that may ride on a mesh; it passes check().
inline PolygonMesh laden_cube() {
  PolygonMesh mesh = cube();
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c)
    mesh.face_uvs.push_back(static_cast<std::int32_t>(c % 4));
  mesh.colors.assign(mesh.positions.size(), glm::vec4(1, 0.5f, 0, 1));
  mesh.groups = {{"a", "x"}, {"b", "y"}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) mesh.face_groups.push_back(f % 2);
  mesh.hole_faces = {3};
  mesh.creases = {{mesh.face_vertices[0], mesh.face_vertices[1]}};
  mesh.corners = {{5}};
  return mesh;
}

struct FaultyMesh {
  std::string name;
  PolygonMesh mesh;
  MeshProblemKind kind;
};

/// Meshes as nobody reads them from a file: each with one count, index or number that would lead
/// outside an array or through all arithmetic.
inline std::vector<FaultyMesh> faulty_meshes() {
  using Kind = MeshProblemKind;
  constexpr std::int32_t kFar = 1'000'000'000;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::vector<FaultyMesh> all;
  const auto add = [&](const std::string& name, Kind kind, const auto& spoil) {
    all.push_back({name, laden_cube(), kind});
    spoil(all.back().mesh);
  };
  for (const std::int32_t wild : {-2, -1, kFar}) {
    const std::string number = " " + std::to_string(wild);
    add("vertex" + number, Kind::IndexOutOfRange, [&](auto& m) { m.face_vertices[7] = wild; });
    add("offset" + number, Kind::IndexOutOfRange, [&](auto& m) { m.face_offsets[2] = wild; });
    if (wild != -1)
      add("texture coordinate" + number, Kind::UnknownTextureCoordinate,
          [&](auto& m) { m.face_uvs[7] = wild; });
    add("group" + number, Kind::UnknownGroup, [&](auto& m) { m.face_groups[1] = wild; });
    add("hole" + number, Kind::UnknownHole, [&](auto& m) { m.hole_faces[0] = wild; });
    add("crease" + number, Kind::UnknownCreaseEdge, [&](auto& m) { m.creases[0].v1 = wild; });
    add("corner" + number, Kind::UnknownCornerVertex, [&](auto& m) { m.corners[0].vertex = wild; });
  }
  add("all offsets", Kind::IndexOutOfRange, [&](auto& m) {
    for (std::int32_t& offset : m.face_offsets) offset += kFar;  // faces have the sizes they had
  });
  for (const bool more : {false, true}) {
    const std::string number = more ? " more" : " fewer";
    const auto spoil = [&](auto& values) { more ? values.resize(200) : values.resize(1); };
    add("colours," + number, Kind::WrongAttributeCount, [&](auto& m) { spoil(m.colors); });
    add("texture corners," + number, Kind::WrongAttributeCount,
        [&](auto& m) { spoil(m.face_uvs); });
    add("groups of faces," + number, Kind::WrongAttributeCount,
        [&](auto& m) { spoil(m.face_groups); });
  }
  add("no uvs", Kind::UnknownTextureCoordinate, [](auto& m) { m.uvs.clear(); });
  add("no groups", Kind::UnknownGroup, [](auto& m) { m.groups.clear(); });
  add("crease of nan", Kind::UnknownCreaseEdge, [&](auto& m) { m.creases[0].sharpness = kNan; });
  add("corner of nan", Kind::UnknownCornerVertex, [&](auto& m) { m.corners[0].sharpness = kNan; });
  add("offsets end early", Kind::IndexOutOfRange, [](auto& m) {
    m.face_offsets.pop_back();
    m.face_groups.pop_back();
  });
  return all;
}

}  // namespace planish::test
