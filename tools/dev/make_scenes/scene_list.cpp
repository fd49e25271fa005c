#include "make_scenes/scene_list.h"

#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "make_scenes/models.h"
#include "make_scenes/shapes.h"
#include "planish/files/shared/attributes.h"

namespace planish::shapes {
namespace {

template <typename Number>
void append(std::string& text, Number number) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  text += ' ';
  text.append(digits.data(), end);
}

}  // namespace

std::string obj_text(const PolygonMesh& mesh, std::string_view comment) {
  std::string text = "# ";
  text.append(comment);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    text += "\nv";
    for (int axis = 0; axis < 3; ++axis) append(text, mesh.positions[v][axis]);
    if (mesh.colors.empty()) continue;
    const glm::dvec4 color = srgb_of_linear(mesh.colors[v]);
    for (int i = 0; i < 3; ++i) append(text, rounded(color[i]));
  }
  for (const glm::dvec2& uv : mesh.uvs) {
    text += "\nvt";
    append(text, uv.x);
    append(text, uv.y);
  }
  std::int32_t group = -1;
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    if (!mesh.face_groups.empty() && mesh.face_groups[face] != group) {
      group = mesh.face_groups[face];
      text += "\ng " + mesh.groups[group].name + "\nusemtl " + mesh.groups[group].material;
    }
    text += "\nf";
    for (std::int32_t c = mesh.face_offsets[face]; c < mesh.face_offsets[face + 1]; ++c) {
      append(text, mesh.face_vertices[c] + 1);
      if (!mesh.face_uvs.empty()) (text += '/') += std::to_string(mesh.face_uvs[c] + 1);
    }
  }
  // Tags count vertices from 0, faces from 1.
  for (const CreaseEdge& crease : mesh.creases) {
    text += "\nt crease 2/1/0";
    append(text, crease.v0);
    append(text, crease.v1);
    append(text, crease.sharpness);
  }
  for (const CornerVertex& corner : mesh.corners) {
    text += "\nt corner 1/1/0";
    append(text, corner.vertex);
    append(text, corner.sharpness);
  }
  for (const std::int32_t face : mesh.hole_faces) {
    text += "\nt hole 1/0/0";
    append(text, face);
  }
  return text + "\n";
}

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> kScenes{
      {"cube_with_holes.obj", "Cube with three crossing tunnels, genus 5",
       [] { return cube_with_tunnels(31, 11); }},
      {"goblet.obj", "Wine goblet, genus 0", [] { return goblet(); }},
      {"rocker_arm.obj", "Rocker arm of an engine, genus 1", [] { return rocker_arm(); }},
      {"bust.obj", "Bust of a composer, genus 0", [] { return bust(); }},
      {"torus.obj", "Torus, R = 1, r = 0.4, 64 x 32 quads", [] { return torus(); }},
      {"icosphere.obj", "Icosphere of level 4", [] { return icosphere(4); }},
      {"pole64.obj", "Sphere with a pole of valence 64 and a cap of 64 corners",
       [] { return pole_sphere(64, 30); }},
      {"mixed_polygons.obj", "Ellipsoid of 3- to 12-gons", [] { return mixed_polygons(); }},
      {"plate_with_holes.obj", "Open planar plate with four round holes",
       [] { return plate_with_holes(); }},
      {"open_grid.obj", "Open planar grid of 16 x 12 quads", [] { return open_grid(16, 12); }},
      {"wavy_patch.obj", "Open patch of 24 x 24 quads, z = 0.1 sin(2 pi x) cos(2 pi y)",
       [] { return wavy_patch(24, 24); }},
      {"bearing_block.obj", "Bearing block with tagged creases, genus 1",
       [] { return bearing_block(); }},
      {"l_bracket.obj", "L-bracket with two concave faces", [] { return l_bracket(); }},
      {"cube.obj", "Cube of six quads", [] { return cube(); }},
      {"mapped_cube.obj", "Cube with six charts, two materials and colours",
       [] { return mapped_cube(4); }},
      {"cube_with_windows.obj", "Cube with a hole in every side",
       [] { return cube_with_windows(); }},
  };
  return kScenes;
}

PolygonMesh scene_mesh(const Scene& scene) {
  PolygonMesh mesh = scene.make();
  round_positions(mesh);
  return mesh;
}

std::string scene_text(const Scene& scene) { return obj_text(scene_mesh(scene), scene.comment); }

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
