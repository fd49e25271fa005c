#include "fuzz/fuzz_read.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "files/gltf/glb_bytes.h"
#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/files/obj/read_obj.h"
#include "planish/files/ply/read_ply.h"
#include "planish/files/readers.h"
#include "planish/mesh/check.h"
#include "planish/mesh/statistics.h"
#include "support/files.h"

namespace planish::test {

namespace {

bool is_finite(const glm::dvec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

bool is_visible(const std::string& message) { return visible_lines(message) == message; }

// FNV-1a of the bytes of arrays, and of how many they are.
class Digest {
 public:
  template <class... Array>
  void add(const Array&... arrays) {
    (add_bytes(std::as_bytes(std::span(arrays))), ...);
  }
  void add_attributes(const std::vector<VertexAttribute>& attributes) {
    for (const VertexAttribute& attribute : attributes) add(attribute.name, attribute.values);
  }
  [[nodiscard]] std::uint64_t sum() const { return sum_; }

 private:
  void add_bytes(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) take(std::to_integer<std::uint8_t>(byte));
    for (std::uint64_t size = bytes.size(), i = 0; i < 8; ++i, size >>= 8)
      take(static_cast<std::uint8_t>(size));
  }
  void take(std::uint8_t byte) { sum_ = (sum_ ^ byte) * 1099511628211u; }
  std::uint64_t sum_ = 14695981039346656037u;
};

std::string messages_of(const std::vector<Warning>& warnings) {
  std::string text;
  for (const Warning& warning : warnings) text += "; " + warning.message;
  return text;
}

int count_at(std::span<const std::byte> bytes, std::size_t i) {
  return std::to_integer<int>(bytes[i]) + 256 * std::to_integer<int>(bytes[i + 1]);
}

// What was read, in words: of equal bits equal ones.
std::string told(const MeshFile& found) {
  require_visible(found.warnings);
  const PolygonMesh& mesh = found.mesh;
  for (const glm::dvec3& p : mesh.positions) require(is_finite(p));
  const std::vector<MeshProblem> problems = check(mesh);
  for (const MeshProblem& problem : problems)
    require(problem.kind != MeshProblemKind::IndexOutOfRange);
  require(!problems.empty() || statistics(mesh).genus >= 0);
  Digest digest;
  digest.add(mesh.positions, mesh.face_offsets, mesh.face_vertices, mesh.creases, mesh.corners,
             mesh.uvs, mesh.face_uvs, mesh.colors, mesh.face_groups, mesh.hole_faces,
             found.normals);
  digest.add_attributes(mesh.attributes);
  for (const FaceGroup& group : mesh.groups) digest.add(group.name, group.material);
  return std::to_string(mesh.vertex_count()) + " vertices, " + std::to_string(mesh.face_count()) +
         " faces, " + std::to_string(digest.sum()) + messages_of(found.warnings);
}

std::string told(const PointCloud& cloud) {
  require_visible(cloud.warnings);
  require(is_finite(cloud.origin) && cloud.missing_count >= 0);
  for (const glm::dvec3& p : cloud.points) require(is_finite(p) && is_finite(p + cloud.origin));
  Digest digest;
  digest.add(cloud.points, cloud.normals, cloud.colors, std::array{cloud.origin});
  digest.add_attributes(cloud.attributes);
  return std::to_string(cloud.points.size()) + " points, " + std::to_string(cloud.missing_count) +
         " missing, " + std::to_string(digest.sum()) + messages_of(cloud.warnings);
}

// The same, or the message of an error.
template <class Read>
std::string told_of(const Read& read) {
  try {
    return told(read());
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::UnreadableInput});
    return error.what();
  }
}

// Text is read in parts of about so many bytes, on which nothing depends.
template <class Found>
using ReadInParts = Found (*)(const FileBytes&, std::size_t part_bytes);

ReadInParts<MeshFile> mesh_in_parts(FileFormat format) {
  switch (format) {
    case FileFormat::Obj:
      return read_obj;
    case FileFormat::Ply:
      return read_ply;
    case FileFormat::Off:
      return read_off;
    case FileFormat::Stl:
      return read_stl;
    default:
      return nullptr;
  }
}

ReadInParts<PointCloud> points_in_parts(FileFormat format) {
  switch (format) {
    case FileFormat::Xyz:
      return read_xyz;
    case FileFormat::Pts:
      return read_pts;
    case FileFormat::Pcd:
      return read_pcd;
    case FileFormat::Ptx:
      return read_ptx;
    default:
      return nullptr;
  }
}

std::uint64_t inputs_of_one_asked_all = 1;

bool is_drawn(std::span<const std::byte> bytes) {
  Digest digest;
  digest.add(bytes);
  return digest.sum() % inputs_of_one_asked_all == 0;
}

// Of text what a reader makes of small parts, and of those drawn the same of one part and of the
// file as programs read it.
template <class Found, class Read>
std::string told_in_parts(ReadInParts<Found> read_parts, const FileBytes& file, const Read& read) {
  const std::size_t size = file.bytes.size();
  const auto in_parts = [&](std::size_t bytes) {
    return told_of([&] { return read_parts(file, bytes); });
  };
  if (read_parts != nullptr) {
    std::string small = in_parts(1 + size % 61);
    if (!is_drawn(file.bytes)) return small;
    require(in_parts(size + 1) == small);
  }
  return told_of(read);
}

}  // namespace

void ask_all_of_one_in(std::uint64_t inputs) { inputs_of_one_asked_all = inputs; }

void require_refusal(const Error& error, std::initializer_list<ErrorCode> codes) {
  require(std::ranges::find(codes, error.code()) != codes.end());
  require(is_visible(error.what()));
}

void require_visible(const std::vector<Warning>& warnings) {
  for (const Warning& warning : warnings) require(is_visible(warning.message));
}

std::string fuzz_read_mesh(std::span<const std::byte> bytes, FileFormat format) {
  // Every second size as `--creases normals` reads it.
  const FileBytes file{
      .bytes = bytes, .name = "fuzz", .path = {}, .split_normals_crease = bytes.size() % 2 == 1};
  return told_in_parts(mesh_in_parts(format), file, [&] { return read_mesh(file, format); });
}

std::string fuzz_read_draco(std::span<const std::byte> bytes, FileFormat format) {
  constexpr std::size_t kCounts = 4;
  if (bytes.size() < kCounts) return {};
  const std::string size = std::to_string(bytes.size() - kCounts);
  const std::string json =
      R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":)"
      R"({"POSITION":1},"indices":0,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,)"
      R"("attributes":{"POSITION":0}}}}]}],"accessors":[{"componentType":5125,"type":"SCALAR",)"
      R"("count":)" +
      std::to_string(3 * count_at(bytes, 2)) + R"(},{"componentType":5126,"type":"VEC3","count":)" +
      std::to_string(count_at(bytes, 0)) + R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + size +
      R"(}],"buffers":[{"byteLength":)" + size + "}]}";
  const std::string glb = glb_of(json, std::string(text_of(bytes.subspan(kCounts))));
  return fuzz_read_mesh(std::as_bytes(std::span(glb)), format);
}

std::string fuzz_read_meshopt(std::span<const std::byte> bytes, FileFormat format) {
  constexpr std::size_t kHead = 4;
  if (bytes.size() < kHead) return {};
  const int kind = std::to_integer<int>(bytes[3]);
  const int stride = std::to_integer<int>(bytes[2]);
  const char* const mode = std::array{"ATTRIBUTES", "TRIANGLES", "INDICES"}[kind % 3];
  const char* const filter =
      std::array{"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"}[kind / 3 % 4];
  const bool is_positions = kind % 3 == 0;
  const std::string size = std::to_string(bytes.size() - kHead),
                    count = std::to_string(count_at(bytes, 0));
  const std::string length = std::to_string(stride * count_at(bytes, 0)),
                    of_view = R"("byteStride":)" + std::to_string(stride);
  const int component = is_positions  ? stride == 4   ? 5120
                                        : stride == 8 ? 5122
                                                      : 5126
                        : stride == 2 ? 5123
                                      : 5125;
  const std::string packed =
      R"({"bufferView":0,"componentType":)" + std::to_string(component) + R"(,"count":)" + count;
  const std::string accessors = is_positions
                                    ? packed + R"(,"type":"VEC3"})"
                                    : R"({"componentType":5126,"type":"VEC3","count":300},)" +
                                          packed + R"(,"type":"SCALAR"})";
  const std::string json =
      R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":)"
      R"({"POSITION":0})" +
      std::string(is_positions ? "" : R"(,"indices":1)") + R"(}]}],"accessors":[)" + accessors +
      R"(],"bufferViews":[{"buffer":0,"byteLength":)" + length + "," +
      (is_positions ? of_view + "," : "") +
      R"("extensions":{"EXT_meshopt_compression":{"buffer":0,"byteLength":)" + size + "," +
      of_view + R"(,"count":)" + count + R"(,"mode":")" + mode + R"(","filter":")" + filter +
      R"("}}}],"buffers":[{"byteLength":)" + size + "}]}";
  const std::string glb = glb_of(json, std::string(text_of(bytes.subspan(kHead))));
  return fuzz_read_mesh(std::as_bytes(std::span(glb)), format);
}

std::string fuzz_read_points(std::span<const std::byte> bytes, FileFormat format) {
  const FileBytes file{.bytes = bytes, .name = "fuzz", .path = {}};
  return told_in_parts(points_in_parts(format), file, [&] { return read_points(file, format); });
}

std::string fuzz_read_lzf(std::span<const std::byte> bytes, FileFormat format) {
  constexpr std::size_t kCount = 2;
  if (bytes.size() < kCount) return {};
  const int count = count_at(bytes, 0);
  std::string pcd =
      "FIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nHEIGHT 1\nWIDTH " +
      std::to_string(count) + "\nDATA binary_compressed\n";
  append<std::uint32_t>(pcd, static_cast<std::uint32_t>(bytes.size() - kCount));
  append<std::uint32_t>(pcd, static_cast<std::uint32_t>(16 * count));
  pcd += text_of(bytes.subspan(kCount));
  return fuzz_read_points(std::as_bytes(std::span(pcd)), format);
}

}  // namespace planish::test
