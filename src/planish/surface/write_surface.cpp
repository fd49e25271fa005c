#include "planish/surface/write_surface.h"

#include "planish/mesh/write_polygons.h"

namespace planish {

void write_surface(const std::filesystem::path& path, MeshFormat format, const SurfaceMesh& surface,
                   const std::vector<std::string>& header) {
  PolygonView view;
  view.positions = surface.positions;
  view.normals = surface.normals;
  if (surface.level == 0) view.face_offsets = surface.face_offsets;
  view.face_vertices = surface.face_vertices;
  view.header = header;
  write_polygons(path, format, view);
}

}  // namespace planish
