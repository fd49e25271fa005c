#include "planish/files/write_surface.h"

#include "planish/files/write_polygons.h"

namespace planish {

void write_surface(const std::filesystem::path& path, FileFormat format, const SurfaceMesh& surface,
                   const std::vector<std::string>& header, std::span<const NamedField> fields) {
  PolygonView view;
  view.positions = surface.positions;
  view.normals = surface.normals;
  view.face_offsets = surface.face_offsets;
  view.face_vertices = surface.face_vertices;
  view.uvs = surface.uvs;
  view.face_uvs = surface.face_uvs;
  view.colors = surface.colors;
  view.groups = surface.groups;
  view.face_groups = surface.face_groups;
  view.header = header;
  view.fields = fields;
  write_polygons(path, format, view);
}

}  // namespace planish
