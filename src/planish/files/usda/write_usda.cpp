// Based on: Pixar, "Universal Scene Description: UsdGeomMesh", 2016-2023.
#include "planish/files/usda/write_usda.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace planish {
namespace {

// [element(0), element(1), ...]
template <class Write>
void write_list(FileBuffer& out, std::size_t count, const Write& element) {
  out.text("[");
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) out.text(", ");
    element(i);
  }
  out.text("]");
}

void write_interpolation(FileBuffer& out, const char* name) {
  out.text(" (\n        interpolation = \"").text(name).text("\"\n    )\n");
}

void write_triple(FileBuffer& out, const glm::vec3& v) {
  out.text("(").number(v.x).text(", ").number(v.y).text(", ").number(v.z).text(")");
}

// Sharpness of at least 10 is infinite here as there.
float usd_sharpness(float sharpness) {
  return std::isfinite(sharpness) ? sharpness : kInfiniteSharpness;
}

void write_integers(FileBuffer& out, const char* name, std::span<const std::int32_t> values) {
  out.text("    int[] ").text(name).text(" = ");
  write_list(out, values.size(), [&](std::size_t i) { out.number(values[i]); });
  out.text("\n");
}

void write_shape(FileBuffer& out, const PolygonView& view) {
  out.text("    int[] faceVertexCounts = ");
  write_list(out, view.face_count(), [&](std::size_t f) { out.number(view.face(f).size()); });
  out.text("\n");
  write_integers(out, "faceVertexIndices", view.face_vertices);
  out.text("    point3f[] points = ");
  write_list(out, view.positions.size(),
             [&](std::size_t i) { write_triple(out, glm::vec3(view.positions[i])); });
  out.text("\n");
  if (view.normals.empty()) return;
  out.text("    normal3f[] normals = ");
  write_list(out, view.normals.size(), [&](std::size_t i) { write_triple(out, view.normals[i]); });
  write_interpolation(out, "vertex");
}

void write_colors(FileBuffer& out, const PolygonView& view) {
  if (view.colors.empty()) return;
  out.text("    color3f[] primvars:displayColor = ");
  write_list(out, view.colors.size(),
             [&](std::size_t i) { write_triple(out, glm::vec3(view.colors[i])); });
  write_interpolation(out, "vertex");
  if (std::ranges::all_of(view.colors, [](const glm::vec4& color) { return color.a == 1; })) return;
  out.text("    float[] primvars:displayOpacity = ");
  write_list(out, view.colors.size(), [&](std::size_t i) { out.number(view.colors[i].a); });
  write_interpolation(out, "vertex");
}

void write_texture_coordinates(FileBuffer& out, const PolygonView& view) {
  if (view.face_uvs.empty()) return;
  const bool has_gaps = std::ranges::any_of(view.face_uvs, [](std::int32_t uv) { return uv < 0; });
  out.text("    texCoord2f[] primvars:st = ");
  write_list(out, view.uvs.size() + (has_gaps ? 1 : 0), [&](std::size_t i) {
    const glm::vec2 uv = i < view.uvs.size() ? glm::vec2(view.uvs[i]) : glm::vec2(0.0f);
    out.text("(").number(uv.x).text(", ").number(uv.y).text(")");
  });
  write_interpolation(out, "faceVarying");
  out.text("    int[] primvars:st:indices = ");
  write_list(out, view.face_uvs.size(), [&](std::size_t i) {
    const std::int32_t uv = view.face_uvs[i];
    out.number(uv < 0 ? view.uvs.size() : static_cast<std::size_t>(uv));
  });
  out.text("\n");
}

void write_fields(FileBuffer& out, const PolygonView& view) {
  for (const NamedField& field : view.fields) {
    out.text("    float[] primvars:").text(field.name).text(" = ");
    write_list(out, field.values.size(), [&](std::size_t i) { out.number(field.values[i]); });
    write_interpolation(out, "vertex");
  }
}

void write_sharp_features(FileBuffer& out, const PolygonView& view) {
  if (!view.creases.empty()) {
    const std::size_t count = view.creases.size();
    out.text("    int[] creaseIndices = ");
    write_list(out, 2 * count, [&](std::size_t i) {
      const CreaseEdge& crease = view.creases[i / 2];
      out.number(i % 2 == 0 ? crease.v0 : crease.v1);
    });
    out.text("\n    int[] creaseLengths = ");
    write_list(out, count, [&](std::size_t) { out.number(2); });
    out.text("\n    float[] creaseSharpnesses = ");
    write_list(out, count,
               [&](std::size_t i) { out.number(usd_sharpness(view.creases[i].sharpness)); });
    out.text("\n");
  }
  if (!view.corners.empty()) {
    out.text("    int[] cornerIndices = ");
    write_list(out, view.corners.size(),
               [&](std::size_t i) { out.number(view.corners[i].vertex); });
    out.text("\n    float[] cornerSharpnesses = ");
    write_list(out, view.corners.size(),
               [&](std::size_t i) { out.number(usd_sharpness(view.corners[i].sharpness)); });
    out.text("\n");
  }
  if (!view.hole_faces.empty()) write_integers(out, "holeIndices", view.hole_faces);
}

// Names of prims are identifiers; the number keeps them apart.
std::string prim_name(const FaceGroup& group, std::size_t index) {
  std::string name = "_";
  for (const char c : group.name.empty() ? group.material : group.name) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    name += plain ? c : '_';
  }
  return "group_" + std::to_string(index) + (name.size() > 1 ? name : "");
}

void write_groups(FileBuffer& out, const PolygonView& view) {
  if (view.face_groups.empty()) return;
  std::vector<std::vector<std::int32_t>> faces(view.groups.size());
  for (std::size_t f = 0; f < view.face_groups.size(); ++f)
    faces[static_cast<std::size_t>(view.face_groups[f])].push_back(static_cast<std::int32_t>(f));
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (faces[i].empty()) continue;
    out.text("    def GeomSubset \"").text(prim_name(view.groups[i], i)).text("\"\n    {\n");
    out.text("        uniform token elementType = \"face\"\n");
    out.text("        uniform token familyName = \"planish\"\n    ");
    write_integers(out, "indices", faces[i]);
    out.text("    }\n");
  }
}

}  // namespace

// A Mesh within an Xform: some readers look for meshes nowhere else.
void write_usda(FileBuffer& out, const PolygonView& view) {
  out.text("#usda 1.0\n(\n    defaultPrim = \"surface\"\n    metersPerUnit = 1\n");
  out.text("    upAxis = \"Y\"\n)\n\n");
  for (const std::string& line : view.header) out.text("# ").text(line).text("\n");
  out.text(
      "def Xform \"surface\"\n{\ndef Mesh \"mesh\"\n{\n    uniform token subdivisionScheme = \"");
  out.text(view.subdivision.scheme).text("\"\n");
  if (view.subdivision.scheme != "none") {
    out.text("    uniform token interpolateBoundary = \"");
    out.text(view.subdivision.has_sharp_boundary_corners ? "edgeAndCorner" : "edgeOnly");
    out.text("\"\n");
  }
  write_shape(out, view);
  write_colors(out, view);
  write_texture_coordinates(out, view);
  write_fields(out, view);
  write_sharp_features(out, view);
  write_groups(out, view);
  out.text("}\n}\n");
}

}  // namespace planish
