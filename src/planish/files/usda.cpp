#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/files/materials.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/writers.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

// Based on: Pixar, "Universal Scene Description: UsdGeomMesh", 2016-2023.

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

// The same of a part that comes in pieces: values(view) is what a piece has, write(out, value) one.
template <class Values, class Write>
void stream_list(const PolygonStream& stream, const std::string& name, PolygonPart part,
                 const Values& values, const Write& write) {
  stream.text("    " + name + " = [");
  stream.part(part, [&](FileBuffer& out, const PolygonPiece& piece, RowRange range) {
    bool is_first = range.first == 0;
    for (const auto& value : values(piece.view)) {
      if (!is_first) out.text(", ");
      is_first = false;
      write(out, value);
    }
  });
  stream.text("]");
}

std::string interpolation(const char* name, int element_size = 1) {
  const std::string size =
      element_size > 1 ? formatted("        elementSize = {}\n", element_size) : "";
  return formatted(" (\n{}        interpolation = \"{}\"\n    )\n", size, name);
}

void write_triple(FileBuffer& out, const glm::vec3& v) {
  out.text("(").number(v.x).text(", ").number(v.y).text(", ").number(v.z).text(")");
}

void write_number(FileBuffer& out, float value) { out.number(value); }

void write_shape(const PolygonStream& stream) {
  stream.text("    int[] faceVertexCounts = [");
  stream.part(PolygonPart::Faces, [](FileBuffer& out, const PolygonPiece& piece, RowRange range) {
    for (std::size_t f = 0; f < piece.view.face_count(); ++f) {
      if (range.first > 0 || f > 0) out.text(", ");
      out.number(piece.view.face(f).size());
    }
  });
  stream.text("]\n");
  stream_list(
      stream, "int[] faceVertexIndices", PolygonPart::Faces,
      [](const PolygonView& view) { return view.face_vertices; },
      [](FileBuffer& out, std::int32_t vertex) { out.number(vertex); });
  stream.text("\n");
  stream_list(
      stream, "point3f[] points", PolygonPart::Positions,
      [](const PolygonView& view) { return view.positions; },
      [](FileBuffer& out, const glm::dvec3& p) { write_triple(out, glm::vec3(p)); });
  stream.text("\n");
  if (!stream.totals().has_normals) return;
  stream_list(
      stream, "normal3f[] normals", PolygonPart::Normals,
      [](const PolygonView& view) { return view.normals; }, write_triple);
  stream.text(interpolation("vertex"));
}

void write_colors(const PolygonStream& stream) {
  if (!stream.totals().has_colors) return;
  const auto colors = [](const PolygonView& view) { return view.colors; };
  stream_list(stream, "color3f[] primvars:displayColor", PolygonPart::Colors, colors,
              [](FileBuffer& out, const glm::vec4& color) { write_triple(out, glm::vec3(color)); });
  stream.text(interpolation("vertex"));
  std::atomic<bool> is_opaque{true};
  stream.look(PolygonPart::Colors, [&](const PolygonPiece& piece, RowRange) {
    if (!std::ranges::all_of(piece.view.colors, [](const glm::vec4& c) { return c.a == 1; }))
      is_opaque = false;
  });
  if (is_opaque) return;
  stream_list(stream, "float[] primvars:displayOpacity", PolygonPart::Colors, colors,
              [](FileBuffer& out, const glm::vec4& color) { out.number(color.a); });
  stream.text(interpolation("vertex"));
}

void write_texture_coordinates(const PolygonStream& stream) {
  if (!stream.totals().has_uvs) return;
  const auto uvs = static_cast<std::size_t>(stream.totals().uv_count);
  std::atomic<bool> has_gaps{false};
  stream.look(PolygonPart::Faces, [&](const PolygonPiece& piece, RowRange) {
    if (std::ranges::any_of(piece.view.face_uvs, [](std::int32_t uv) { return uv < 0; }))
      has_gaps = true;
  });
  stream.text("    texCoord2f[] primvars:st = [");
  stream.part(PolygonPart::Uvs, [](FileBuffer& out, const PolygonPiece& piece, RowRange range) {
    for (std::size_t i = 0; i < piece.view.uvs.size(); ++i) {
      const glm::vec2 uv(piece.view.uvs[i]);
      out.text(range.first > 0 || i > 0 ? ", (" : "(").number(uv.x).text(", ").number(uv.y);
      out.text(")");
    }
  });
  if (has_gaps) stream.text(uvs > 0 ? ", (0, 0)" : "(0, 0)");
  stream.text("]" + interpolation("faceVarying"));
  stream_list(
      stream, "int[] primvars:st:indices", PolygonPart::Faces,
      [](const PolygonView& view) { return view.face_uvs; },
      [&](FileBuffer& out, std::int32_t uv) {
        out.number(uv < 0 ? uvs : static_cast<std::size_t>(uv));
      });
  stream.text("\n");
}

void write_fields(const PolygonStream& stream) {
  std::vector<AttributeName> names;
  stream.look(PolygonPart::Head, [&](const PolygonPiece& piece, RowRange) {
    for (const NamedField& field : piece.view.fields) names.push_back({field.name, field.width});
  });
  for (std::size_t k = 0; k < names.size(); ++k) {
    stream_list(
        stream, "float[] primvars:" + names[k].name, PolygonPart::Fields,
        [k](const PolygonView& view) { return view.fields[k].values; }, write_number);
    stream.text(interpolation("vertex", names[k].width));
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
               [&](std::size_t i) { out.number(written_sharpness(view.creases[i].sharpness)); });
    out.text("\n");
  }
  if (!view.corners.empty()) {
    out.text("    int[] cornerIndices = ");
    write_list(out, view.corners.size(),
               [&](std::size_t i) { out.number(view.corners[i].vertex); });
    out.text("\n    float[] cornerSharpnesses = ");
    write_list(out, view.corners.size(),
               [&](std::size_t i) { out.number(written_sharpness(view.corners[i].sharpness)); });
    out.text("\n");
  }
  if (!view.hole_faces.empty()) {
    out.text("    int[] holeIndices = ");
    write_list(out, view.hole_faces.size(), [&](std::size_t i) { out.number(view.hole_faces[i]); });
    out.text("\n");
  }
}

// Names of prims are identifiers; the number keeps them apart.
std::string prim_name(const FaceGroup& group, std::size_t index) {
  const std::string& given = group.name.empty() ? group.material : group.name;
  return formatted("group_{}{}", index, given.empty() ? "" : identifier_of("_" + given));
}

// Where the faces of a group are.
struct GroupPlaces {
  FaceGroup group;
  std::vector<RowRange> ranges;  // those with any
  std::int64_t first = -1;
};

std::vector<GroupPlaces> places_of_groups(const PolygonStream& stream) {
  std::vector<GroupPlaces> places;
  std::mutex mutex;
  stream.look(PolygonPart::Faces, [&](const PolygonPiece& piece, RowRange range) {
    std::vector<std::int64_t> first(piece.view.groups.size(), -1);
    for (std::size_t f = piece.view.face_groups.size(); f-- > 0;)
      first[piece.view.face_groups[f]] = range.first + static_cast<std::int64_t>(f);
    const std::lock_guard lock(mutex);
    places.resize(first.size());
    for (std::size_t g = 0; g < first.size(); ++g) {
      places[g].group = piece.view.groups[g];
      if (first[g] < 0) continue;
      places[g].ranges.push_back(range);
      if (places[g].first < 0 || first[g] < places[g].first) places[g].first = first[g];
    }
  });
  for (GroupPlaces& group : places) group.ranges = sorted(std::move(group.ranges));
  return places;
}

// Empty: it has none.
std::string material_path(const UsdMaterials* materials, const std::string& name) {
  if (materials == nullptr) return "";
  const auto found = materials->paths.find(name);
  return found == materials->paths.end() ? "" : found->second;
}

void write_groups(const PolygonStream& stream) {
  if (!stream.totals().has_groups) return;
  const std::vector<GroupPlaces> places = places_of_groups(stream);
  const UsdMaterials* const materials = stream.materials();
  if (materials != nullptr && !materials->paths.empty())
    stream.text("    uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"\n");
  for (std::size_t g = 0; g < places.size(); ++g) {
    if (places[g].ranges.empty()) continue;
    const std::string bound = material_path(materials, places[g].group.material);
    stream.text("    def GeomSubset \"" + prim_name(places[g].group, g) + "\"");
    if (!bound.empty())
      stream.text(" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )");
    stream.text("\n    {\n        uniform token elementType = \"face\"\n");
    stream.text("        uniform token familyName = \"");
    stream.text(bound.empty() ? "planish\"\n" : "materialBind\"\n");
    if (!bound.empty()) stream.text("        rel material:binding = <" + bound + ">\n");
    stream.text("        int[] indices = [");
    stream.pieces(PolygonPart::Faces, places[g].ranges,
                  [&](FileBuffer& out, const PolygonPiece& piece, RowRange range) {
                    for (std::size_t f = 0; f < piece.view.face_groups.size(); ++f) {
                      if (piece.view.face_groups[f] != static_cast<std::int32_t>(g)) continue;
                      const std::int64_t face = range.first + static_cast<std::int64_t>(f);
                      if (face > places[g].first) out.text(", ");
                      out.number(face);
                    }
                  });
    stream.text("]\n    }\n");
  }
}

void write_head(FileBuffer& out, const PolygonView& view) {
  out.text("#usda 1.0\n(\n    defaultPrim = \"surface\"\n    metersPerUnit = 1\n");
  out.text("    upAxis = \"").text(view.is_z_up ? "Z" : "Y").text("\"\n)\n\n");
  for (const std::string& line : view.header) out.text("# ").text(line).text("\n");
  out.text(
      "def Xform \"surface\"\n{\ndef Mesh \"mesh\"\n{\n    uniform token subdivisionScheme = \"");
  out.text(view.subdivision.scheme).text("\"\n");
  if (view.subdivision.scheme != "none") {
    out.text("    uniform token interpolateBoundary = \"");
    out.text(boundary_of(view.subdivision));
    out.text("\"\n");
  }
}

}  // namespace

// A Mesh within an Xform: some readers look for meshes nowhere else.
void write_usda(const PolygonStream& stream) {
  const auto of_view = [&](PolygonPart part, const auto& write) {
    stream.part(part, [&](FileBuffer& out, const PolygonPiece& piece, RowRange) {
      write(out, piece.view);
    });
  };
  of_view(PolygonPart::Head, write_head);
  write_shape(stream);
  write_colors(stream);
  write_texture_coordinates(stream);
  write_fields(stream);
  of_view(PolygonPart::Tail, write_sharp_features);
  write_groups(stream);
  stream.text("}\n");
  if (stream.materials() != nullptr && !stream.materials()->text.empty())
    stream.text("def Scope \"materials\"\n{\n" + stream.materials()->text + "}\n");
  stream.text("}\n");
}

}  // namespace planish
