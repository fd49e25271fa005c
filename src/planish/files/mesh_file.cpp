#include "planish/files/mesh_file.h"

#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/files/input_files.h"
#include "planish/files/read_file.h"
#include "planish/files/shared/read_counted.h"
#include "planish/files/write_polygons.h"

namespace planish {

MeshFile read_mesh(const FileBytes& file, FileFormat format, const Callbacks& callbacks) {
  const FormatInfo& info = info_of(format);
  if (!info.read_mesh && !info.read_points)
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: .{} is written, not read", file.name, info.name));
  if (!info.read_mesh) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: .{} holds points, and a polygon mesh is wanted; read_points() and "
                          "reconstruct() make one of them",
                          file.name, info.name));
  }
  return read_counted(file, format, callbacks, info.read_mesh);
}

MeshFile read_mesh(std::span<const std::byte> bytes, std::string_view name, FileFormat format) {
  return read_mesh(FileBytes{.bytes = bytes, .name = name, .path = {}}, format);
}

MeshFile read_mesh(const std::filesystem::path& path, const MeshReadOptions& options) {
  const auto format = options.format ? options.format : format_of(path);
  if (!format) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: the extension \"{}\" names no format of meshes that is read ({})",
                          visible(path), visible(path.extension()), names_of(FormatUse::ReadMesh)));
  }
  const RawVector<std::byte> bytes = read_file(path, share_of(options.callbacks, 0, kFileLoaded));
  const std::string name = visible(path);
  return read_mesh(FileBytes{.bytes = bytes,
                             .name = name,
                             .path = path,
                             .split_normals_crease = options.split_normals_crease,
                             .is_strict = options.is_strict,
                             .reach = options.reach},
                   *format, share_of(options.callbacks, kFileLoaded, 1));
}

void write_mesh(const std::filesystem::path& path, FileFormat format, const PolygonMesh& mesh,
                const MeshWriteOptions& options) {
  if (options.inputs != nullptr) require_apart(*options.inputs, path, format);
  std::vector<NamedField> fields;
  for (const VertexAttribute& attribute : mesh.attributes)
    fields.push_back({attribute.name, attribute.values, attribute.width});
  const PolygonView view{.positions = mesh.positions,
                         .normals = {},
                         .face_offsets = mesh.face_offsets,
                         .face_vertices = mesh.face_vertices,
                         .creases = mesh.creases,
                         .corners = mesh.corners,
                         .uvs = mesh.uvs,
                         .face_uvs = mesh.face_uvs,
                         .colors = mesh.colors,
                         .groups = mesh.groups,
                         .face_groups = mesh.face_groups,
                         .hole_faces = mesh.hole_faces,
                         .fields = fields,
                         .subdivision = options.subdivision,
                         .is_z_up = options.is_z_up,
                         .header = options.header};
  write_polygons(path, format, view, {}, options.materials);
}

}  // namespace planish
