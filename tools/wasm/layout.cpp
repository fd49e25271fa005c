// Where the members of the C header's structs lie, told to JavaScript by the compiler that knows
// it.
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>

#include "planish/c/editor.h"

namespace {

template <class Member>
const char* type_name() {
  if constexpr (std::is_same_v<Member, double>) return "f64";
  if constexpr (std::is_same_v<Member, std::int64_t>) return "i64";
  if constexpr (std::is_pointer_v<Member>) return "ptr";
  static_assert(sizeof(Member) == 4 || std::is_same_v<Member, double> ||
                std::is_same_v<Member, std::int64_t>);
  return std::is_signed_v<Member> ? "i32" : "u32";
}

template <class Member>
void add(std::string& text, const char* name, std::size_t offset) {
  text += std::string(name) + ' ' + type_name<Member>() + ' ' + std::to_string(offset) + '\n';
}

}  // namespace

// NOLINTBEGIN(cppcoreguidelines-macro-usage): offsetof() wants names
#define STRUCT(S) text += "struct planish_" #S " " + std::to_string(sizeof(planish_##S)) + '\n'
#define MEMBER(S, M) add<decltype(planish_##S::M)>(text, #M, offsetof(planish_##S, M))
// NOLINTEND(cppcoreguidelines-macro-usage)

/// Lines "struct NAME BYTES", each followed by its members' "NAME TYPE OFFSET".
extern "C" const char* planish_wasm_layout() {
  static const std::string layout = [] {
    std::string text;
    STRUCT(mesh_arrays);
    MEMBER(mesh_arrays, positions);
    MEMBER(mesh_arrays, vertex_count);
    MEMBER(mesh_arrays, face_sizes);
    MEMBER(mesh_arrays, face_count);
    MEMBER(mesh_arrays, corners_per_face);
    MEMBER(mesh_arrays, face_vertices);
    MEMBER(mesh_arrays, corner_count);
    MEMBER(mesh_arrays, crease_edges);
    MEMBER(mesh_arrays, crease_count);
    MEMBER(mesh_arrays, corner_vertices);
    MEMBER(mesh_arrays, sharp_corner_count);
    MEMBER(mesh_arrays, uvs);
    MEMBER(mesh_arrays, uv_count);
    MEMBER(mesh_arrays, face_uvs);
    MEMBER(mesh_arrays, colors);
    MEMBER(mesh_arrays, group_names);
    MEMBER(mesh_arrays, group_materials);
    MEMBER(mesh_arrays, group_count);
    MEMBER(mesh_arrays, face_groups);
    STRUCT(fit_info);
    MEMBER(fit_info, converged);
    MEMBER(fit_info, iterations);
    MEMBER(fit_info, interpolation);
    MEMBER(fit_info, max_error);
    MEMBER(fit_info, rms_error);
    MEMBER(fit_info, diagonal);
    MEMBER(fit_info, vertex_count);
    MEMBER(fit_info, face_count);
    MEMBER(fit_info, crease_degrees);
    MEMBER(fit_info, finds_features);
    MEMBER(fit_info, within);
    STRUCT(surface_arrays);
    MEMBER(surface_arrays, positions);
    MEMBER(surface_arrays, normals);
    MEMBER(surface_arrays, vertex_count);
    MEMBER(surface_arrays, face_vertices);
    MEMBER(surface_arrays, corner_count);
    MEMBER(surface_arrays, face_offsets);
    MEMBER(surface_arrays, face_count);
    MEMBER(surface_arrays, base_vertices);
    MEMBER(surface_arrays, base_count);
    MEMBER(surface_arrays, uvs);
    MEMBER(surface_arrays, uv_count);
    MEMBER(surface_arrays, face_uvs);
    MEMBER(surface_arrays, colors);
    MEMBER(surface_arrays, group_names);
    MEMBER(surface_arrays, group_materials);
    MEMBER(surface_arrays, group_count);
    MEMBER(surface_arrays, face_groups);
    STRUCT(place);
    MEMBER(place, face);
    MEMBER(place, u);
    MEMBER(place, v);
    STRUCT(closest_answers);
    MEMBER(closest_answers, places);
    MEMBER(closest_answers, positions);
    MEMBER(closest_answers, normals);
    MEMBER(closest_answers, distances);
    STRUCT(ray_answers);
    MEMBER(ray_answers, places);
    MEMBER(ray_answers, positions);
    MEMBER(ray_answers, normals);
    MEMBER(ray_answers, t);
    STRUCT(row_range);
    MEMBER(row_range, first);
    MEMBER(row_range, count);
    STRUCT(edit_change);
    MEMBER(edit_change, vertices);
    MEMBER(edit_change, vertex_count);
    MEMBER(edit_change, rows);
    MEMBER(edit_change, range_count);
    MEMBER(edit_change, is_whole);
    STRUCT(editor_arrays);
    MEMBER(editor_arrays, points);
    MEMBER(editor_arrays, point_count);
    MEMBER(editor_arrays, positions);
    MEMBER(editor_arrays, normals);
    MEMBER(editor_arrays, row_count);
    MEMBER(editor_arrays, error_bound);
    MEMBER(editor_arrays, can_undo);
    MEMBER(editor_arrays, can_redo);
    return text;
  }();
  return layout.c_str();
}
