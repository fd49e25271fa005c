#include "planish/distributed/read_slices.h"

#include <algorithm>
#include <utility>

#include "planish/core/error.h"
#include "planish/distributed/range_file.h"
#include "planish/files/mesh_file.h"
#include "planish/files/shared/text_encoding.h"

namespace planish {

namespace {

constexpr std::int64_t kHeaderBytes = 65536;

FileFormat format_for(const std::string& path, std::optional<FileFormat> given) {
  const std::optional<FileFormat> format = given ? given : format_of(path);
  if (!format)
    throw Error(ErrorCode::InvalidArgument, path + ": no format has that extension; " +
                                                names_of(FormatUse::ReadMesh) + " can be read");
  if (!serves(*format, FormatUse::ReadMesh))
    throw Error(ErrorCode::InvalidArgument,
                path +
                    ": points cannot be read over several ranks; make a mesh of them with "
                    "planish reconstruct");
  return *format;
}

void require_small(const std::string& path, FileFormat format) {
  const RangeFile file(path);
  if (file.size() <= kMostWholeBytes) return;
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: {} bytes of {} can only be read by one rank, at most 2 GiB; save it "
                        "as binary little-endian PLY or as OBJ",
                        path, file.size(), name_of(format)));
}

MeshSlice read_by_first_rank(const Ranks& ranks, const std::string& path, FileFormat format) {
  MeshFile file;
  agree(ranks, [&] {
    if (ranks.rank != 0) return;
    require_small(path, format);
    file = read_mesh(path, {.format = format, .is_strict = true});
  });
  MeshSlice slice = scatter_mesh(ranks, file.mesh);
  slice.warnings = std::move(file.warnings);  // rank 0 alone reports them
  return slice;
}

// Face sizes, then corners, each rank's in a run.
void scatter_faces(const Ranks& ranks, const PolygonMesh& mesh,
                   std::span<const std::int64_t> vertex_counts, MeshSlice& slice) {
  std::vector<std::int64_t> size_counts(ranks.size, 0), corner_counts(ranks.size, 0);
  RawVector<std::int64_t> sizes, corners;
  if (ranks.rank == 0) {
    for (int r = 0; r < ranks.size; ++r) {
      size_counts[r] = slice.faces[r + 1] - slice.faces[r];
      corner_counts[r] = mesh.face_offsets[slice.faces[r + 1]] - mesh.face_offsets[slice.faces[r]];
    }
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) sizes.push_back(mesh.face_size(f));
    corners.assign(mesh.face_vertices.begin(), mesh.face_vertices.end());
  }
  for (const std::int64_t size : all_to_all<std::int64_t>(ranks, sizes, size_counts))
    slice.face_offsets.push_back(slice.face_offsets.back() + size);
  const auto named = all_to_all<std::int64_t>(ranks, corners, corner_counts);
  slice.face_vertices.assign(named.begin(), named.end());
  slice.attributes = scatter_attributes(ranks, mesh, {vertex_counts, size_counts, corner_counts});
}

}  // namespace

MeshSlice scatter_mesh(const Ranks& ranks, const PolygonMesh& mesh) {
  MeshSlice slice;
  std::int64_t totals[2] = {mesh.vertex_count(), mesh.face_count()};
  MPI_Bcast(totals, 2, MPI_INT64_T, 0, ranks.comm);
  slice.vertices = even_layout(totals[0], ranks.size);
  slice.faces = even_layout(totals[1], ranks.size);
  std::vector<std::int64_t> counts(ranks.size, 0);
  std::span<const glm::dvec3> positions;
  if (ranks.rank == 0) {
    for (int r = 0; r < ranks.size; ++r) counts[r] = slice.vertices[r + 1] - slice.vertices[r];
    positions = mesh.positions;
    for (std::size_t i = 0; i < mesh.creases.size(); ++i)
      slice.creases.push_back({mesh.creases[i].v0, mesh.creases[i].v1, mesh.creases[i].sharpness,
                               static_cast<std::int64_t>(i)});
    for (std::size_t i = 0; i < mesh.corners.size(); ++i)
      slice.corners.push_back(
          {mesh.corners[i].vertex, mesh.corners[i].sharpness, static_cast<std::int64_t>(i)});
    slice.holes.assign(mesh.hole_faces.begin(), mesh.hole_faces.end());
  }
  const auto own = all_to_all<glm::dvec3>(ranks, positions, counts);
  slice.positions.assign(own.begin(), own.end());
  scatter_faces(ranks, mesh, counts, slice);
  return slice;
}

MeshSlice read_slices(const Ranks& ranks, const std::string& path,
                      std::optional<FileFormat> given) {
  FileFormat format{};
  PlyHeader header;
  bool is_plain = true;
  agree(ranks, [&] {
    format = format_for(path, given);
    const RangeFile file(path);
    // Text that has to be told from its beginning on is read whole, by rank 0.
    const auto start = file.read(0, 4);
    is_plain = !is_utf16(start) && !has_utf8_mark(start);
    if (format != FileFormat::Ply || !is_plain) return;
    const auto bytes = file.read(0, kHeaderBytes);
    try {
      header = read_ply_header({.bytes = bytes, .name = path, .path = {}, .is_strict = true});
    } catch (const Error&) {
      // A longer header is read whole, by rank 0.
      if (file.size() <= kHeaderBytes) throw;
    }
  });
  if (!is_plain) return read_by_first_rank(ranks, path, format);
  if (format == FileFormat::Obj) return read_obj_slices(ranks, path);
  if (format == FileFormat::Ply && has_sliceable_body(header))
    return read_ply_slices(ranks, path, header);
  return read_by_first_rank(ranks, path, format);
}

}  // namespace planish
