#include "save_edit.h"

#include "planish/core/error.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/job/cage_header.h"

namespace planish::viewer {
namespace {

// Scenes are shown with y up; files have the axes of the input.
void turn_back(const SaveOptions& options, PolygonMesh& mesh) {
  if (options.settings.up != UpAxis::Z) return;
  for (glm::dvec3& p : mesh.positions) p = {p.x, -p.z, p.y};
}

FileFormat format_for(const std::filesystem::path& path, SavedPart part) {
  const auto format = format_of(path);
  const bool is_surface = part == SavedPart::Surface;
  if (format && (is_surface ? info_of(*format).is_gltf : serves(*format, FormatUse::WriteCage)))
    return *format;
  throw Error(ErrorCode::InvalidArgument,
              path.string() + (is_surface ? ": surfaces are saved as .glb or .gltf"
                                          : ": meshes and cages are saved as " +
                                                extensions_in_words(FormatUse::WriteCage)));
}

void save_surface(const EditSession& session, const std::filesystem::path& path,
                  const SaveOptions& options) {
  GltfOptions gltf;
  gltf.name = std::filesystem::path(options.source).stem().string();
  if (gltf.name.empty()) gltf.name = "surface";
  write_gltf(path, *session.editor().blocks(options.level), gltf);
}

}  // namespace

SaveOptions save_options(const Scene& scene) {
  return {scene.settings, scene.source, scene.system.level};
}

void save(const EditSession& session, SavedPart part, const std::filesystem::path& path,
          const SaveOptions& options) {
  const FileFormat format = format_for(path, part);
  if (part == SavedPart::Surface) return save_surface(session, path, options);
  PolygonMesh mesh = session.editor().mesh();
  MeshWriteOptions write;
  write.is_z_up = options.settings.up == UpAxis::Z;
  if (part == SavedPart::Cage) {
    const FitSettings& settings = options.settings;
    const Fit fit = session.editor().fit();
    mesh = control_cage(mesh, fit, settings.sharp());
    write.header = cage_header_lines(
        settings, fit.fair ? InterpolationMethod::Fair : InterpolationMethod::Progressive,
        options.source);
    write.subdivision.has_sharp_boundary_corners = settings.boundary == BoundaryRule::EdgeAndCorner;
  }
  turn_back(options, mesh);
  write_mesh(path, format, mesh, write);
}

std::string save_all(const EditSession& session, const std::string& prefix,
                     const SaveOptions& options) {
  const std::string mesh = prefix + ".obj", cage = prefix + "_cage.obj", surface = prefix + ".glb";
  save(session, SavedPart::Mesh, mesh, options);
  save(session, SavedPart::Cage, cage, options);
  save(session, SavedPart::Surface, surface, options);
  return "saved " + mesh + ", " + cage + ", " + surface;
}

}  // namespace planish::viewer
