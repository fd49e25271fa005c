#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "make_scenes/scene_list.h"

namespace planish::shapes {

namespace {

constexpr int kTaken = 0;
constexpr int kMalformed = 3;
constexpr int kUnusable = 4;

constexpr std::string_view kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

std::string obj(std::string_view comment, std::string_view body) {
  return "# " + std::string(comment) + "\n" + std::string(body);
}

void append_u32(std::string& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
}

void append_float(std::string& bytes, float value) {
  append_u32(bytes, std::bit_cast<std::uint32_t>(value));
}

std::string padded(std::string text, char fill) {
  while (text.size() % 4 != 0) text += fill;
  return text;
}

// One triangle as a GLB; `accessor_count` is what the position accessor claims to hold.
std::string triangle_glb(int accessor_count) {
  const std::string json = padded(
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":4}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
          std::to_string(accessor_count) +
          R"(,"min":[0,0,0],"max":[1,1,0]}],)"
          R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]})",
      ' ');
  std::string binary;
  for (const float coordinate : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) {
    append_float(binary, coordinate);
  }
  std::string bytes = "glTF";
  append_u32(bytes, 2);
  append_u32(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + binary.size()));
  append_u32(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  append_u32(bytes, static_cast<std::uint32_t>(binary.size()));
  return bytes + std::string("BIN\0", 4) + binary;
}

// A tetrahedron as binary PLY.
std::string tetrahedron_ply(std::string_view comment) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment " + std::string(comment) +
                      "\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                      "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
  for (int vertex = 0; vertex < 4; ++vertex) {
    for (int axis = 0; axis < 3; ++axis) append_float(bytes, axis + 1 == vertex ? 1.f : 0.f);
  }
  for (const std::uint32_t apex : {3u, 2u, 1u, 0u}) {
    bytes += '\3';
    // The triangle opposite to `apex`, outward.
    constexpr std::uint32_t kOpposite[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    for (const std::uint32_t vertex : kOpposite[apex]) append_u32(bytes, vertex);
  }
  return bytes;
}

void add_malformed(std::vector<BadFile>& files) {
  const auto add = [&](std::string file, std::string bytes) {
    files.push_back({std::move(file), kMalformed, kMalformed, std::move(bytes)});
  };
  add("index_out_of_range.obj",
      obj("A face names vertex 9 of 4", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 9\n"));
  add("index_zero.obj",
      obj("A face names vertex 0; OBJ counts from 1", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"));
  add("index_before_start.obj", obj("A relative index reaches back before the first vertex",
                                    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n"));
  add("nan.obj", obj("A coordinate is not a number", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  add("infinite.obj", obj("A coordinate is infinite", "v 0 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n"));
  add("decimal_comma.obj",
      obj("A coordinate has a comma for its point", "v 0 0 0\nv 1,5 0 0\nv 0 1 0\nf 1 2 3\n"));
  add("two_coordinates.obj",
      obj("A vertex has two coordinates", "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n"));
  add("garbage.obj", "This is a letter, not a mesh.\n");
  add("negative_index.off",
      "OFF\n# A face names vertex -1\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n");
  add("fewer_lines_than_promised.off",
      "OFF\n# The header promises 4 vertices, 3 follow\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n");
  add("negative_count.off", "OFF\n# The header promises -1 vertices\n-1 1 0\n0 0 0\n3 0 0 0\n");
  add("header_promises_too_much.ply",
      "ply\nformat ascii 1.0\ncomment The header promises 2000000000 vertices, 1 follows\n"
      "element vertex 2000000000\nproperty float x\nproperty float y\nproperty float z\n"
      "end_header\n0 0 0\n");
  add("index_out_of_range.ply",
      "ply\nformat ascii 1.0\ncomment A face names vertex 3 of 3\nelement vertex 3\n"
      "property float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n");
  add("no_positions.ply",
      "ply\nformat ascii 1.0\ncomment The vertices have no z\nelement vertex 1\n"
      "property float x\nproperty float y\nend_header\n0 0\n");
  const std::string ply = tetrahedron_ply("The file ends within the last face");
  add("truncated.ply", ply.substr(0, ply.size() - 6));
  const std::string glb = triangle_glb(3);
  add("truncated.glb", glb.substr(0, glb.size() - 12));
  add("accessor_beyond_buffer.glb", triangle_glb(1000000));
  std::string stl(80, ' ');
  append_u32(stl, 1000);
  add("truncated.stl", stl + std::string(50, '\0'));
}

void add_unusable(std::vector<BadFile>& files) {
  const auto add = [&](std::string file, std::string_view comment, std::string_view body) {
    files.push_back({std::move(file), kUnusable, kTaken, obj(comment, body)});
  };
  const std::string tetrahedron(kTetrahedron);
  files.push_back({"no_faces.obj", kUnusable, kUnusable,
                   obj("Vertices, but no face", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")});
  files.push_back({"empty.obj", kUnusable, kUnusable, ""});
  add("two_corners.obj", "The last face has two corners", tetrahedron + "f 1 2\n");
  add("repeated_corner.obj", "A face names vertex 2 twice",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 2 3\nf 1 3 4\n");
  add("duplicate_face.obj", "The last face repeats the first", tetrahedron + "f 3 2 1\n");
  add("inconsistent_winding.obj", "The last face is turned inside out",
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 4 1\n");
  add("non_manifold_edge.obj", "Three faces meet at the edge of vertices 1 and 2",
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  add("non_manifold_vertex.obj", "A bowtie: two faces meet in vertex 1 only",
      "v 0 0 0\nv 1 1 0\nv 1 -1 0\nv -1 1 0\nv -1 -1 0\nf 1 3 2\nf 1 4 5\n");
  add("crease_without_edge.obj", "A crease between vertices 0 and 2 of a quad, its diagonal",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nt crease 2/1/0 0 2 10\n");
  files.push_back({"unused_vertices_are_legal.obj", kTaken, kTaken,
                   obj("The fifth vertex belongs to no face: taken, with a warning",
                       "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 5 5\n"
                       "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")});
}

}  // namespace

std::vector<BadFile> bad_files() {
  std::vector<BadFile> files;
  add_malformed(files);
  add_unusable(files);
  return files;
}

}  // namespace planish::shapes
