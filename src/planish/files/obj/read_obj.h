#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/mesh_file.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The greatest index met, with its line: what it names may follow.
struct LargestIndex {
  std::int64_t index = -1, line = 0, element = -1;

  /// Notes a zero-based index and returns it in 32 bits, which a wrong one may not fit.
  std::int32_t note(std::int64_t value, std::int64_t at_line, std::int64_t at_element = -1);
  /// Takes up that of the lines behind, whose lines and elements count from these.
  void join(const LargestIndex& behind, std::int64_t lines_before, std::int64_t elements_before);
};

/// What tags name, and tags that say nothing to the reader.
struct ObjTagNotes {
  LargestIndex largest_vertex, largest_face;
  LineNote unknown;
};

/// The tags `t crease`, `t corner` and `t hole` of OpenSubdiv's shapes, which count from 0:
/// `t name integers/numbers/strings values...`. Throws Error{UnreadableInput}.
class ObjTags {
 public:
  ObjTags(const TextLines& lines, PolygonMesh& mesh, ObjTagNotes& notes)
      : lines_(lines), mesh_(mesh), notes_(notes) {}

  /// The rest of a line behind its `t`.
  void read(Words words);

 private:
  std::array<std::int64_t, 3> read_counts(std::string_view word) const;
  void add_creases(std::span<const std::int32_t> vertices, std::span<const float> values);
  void add_corners(std::span<const std::int32_t> vertices, std::span<const float> values);

  const TextLines& lines_;
  PolygonMesh& mesh_;
  ObjTagNotes& notes_;
};

/// The colour of a vertex that has none; colours are not negative.
inline constexpr glm::vec4 kNoObjColor(-1.0f);

/// How much of an OBJ file stands before a place.
struct ObjCounts {
  std::int64_t line = 0, vertex = 0, uv = 0, face = 0, corner = 0;
};

/// Indices that count backwards from where nobody knows what stands before: from the part's first
/// vertex (coordinate), and below 0 before it.
struct ObjBackward {
  std::vector<std::size_t> corners;  ///< places in face_vertices or face_uvs
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
};

/// What the reader of an OBJ file made the best of.
struct ObjNotes {
  LineNote unknown_keyword, bad_colors, bad_uvs, missing_uvs, continued_names, bad_positions;
  std::int64_t clamped_colors = 0;
};

/// What the lines of a part of an OBJ file say.
struct ObjPart {
  PolygonMesh mesh;  ///< offsets count from 0; colours and texture corners up to the last given
  std::vector<glm::dvec2> uvs;  ///< NaN: none
  ObjBackward backward_vertices, backward_uvs;

  struct Naming {
    enum class What : std::uint8_t { Object, Group, Material } what;
    std::int64_t faces_before;
    std::string name;
  };
  std::vector<Naming> namings;

  LargestIndex largest_vertex, largest_uv;
  ObjTagNotes tags;
  ObjNotes notes;
  std::vector<std::string> header;
  std::int64_t dropped_element_count = 0, line_count = 0;
  bool is_settled = false;  ///< what stands before was known: lines count from the file's beginning

  [[nodiscard]] ObjCounts counts() const;
};

/// Reads a part. `before`: what stands before it in the file; null where nobody knows yet, then
/// lines and elements count from the part, and indices may count back behind it.
/// Throws Error{UnreadableInput}.
[[nodiscard]] ObjPart read_obj_part(const TextLines& lines, const ObjCounts* before);

/// The parts of an OBJ file, or of a range of one, read side by side. A part does not know what
/// stands before it; one for which that matters is read again when it is known.
class ObjParts {
 public:
  /// Calls use(lines) with the lines of a part; from several threads at once.
  using LinesOf =
      std::function<void(std::size_t part, const std::function<void(const TextLines&)>& use)>;

  /// Reads `count` parts on all threads; `is_start`: the first is the beginning of the file.
  ObjParts(std::size_t count, LinesOf lines_of, bool is_start);

  /// Of the parts before the first that is wrong.
  [[nodiscard]] ObjCounts counts() const;
  /// All parts as one, whose indices, lines of notes and elements count from the file's beginning
  /// and whose offsets and namings from its own. Throws Error{UnreadableInput} as reading the file
  /// from its beginning on would. Once only.
  [[nodiscard]] ObjPart join(const ObjCounts& before);

 private:
  void read_again(std::size_t part, const ObjCounts& before);
  void settle(const std::vector<ObjCounts>& before);
  void gather_notes(const std::vector<ObjCounts>& before, ObjPart& all) const;
  void gather(const std::vector<ObjCounts>& before, ObjPart& all);

  LinesOf lines_of_;
  std::vector<ObjPart> parts_;
  FirstFailure failure_;
};

/// Throws Error{UnreadableInput} for a file of unknown words without vertices, and for faces and
/// tags that name what the file with these counts has not; texture coordinates are noted, unless
/// the file is strict.
void require_obj(ObjPart& part, const ObjCounts& all, const TextLines& lines);

/// The warnings of all notes.
void warn_of(const ObjPart& part, std::string_view name, std::vector<Warning>& warnings);

/// The names that lines of an OBJ file have given; what none has given holds on from before.
struct ObjNames {
  std::optional<std::string> object, group, material;

  /// An object ends the group before it.
  void take(const ObjPart::Naming& naming) {
    switch (naming.what) {
      case ObjPart::Naming::What::Object:
        object = naming.name;
        group = std::string();
        break;
      case ObjPart::Naming::What::Group:
        group = naming.name;
        break;
      case ObjPart::Naming::What::Material:
        material = naming.name;
        break;
    }
  }
  /// That of the faces that follow: a face without a group has its object's name.
  [[nodiscard]] FaceGroup face_group() const {
    const std::string own = group.value_or("");
    return {.name = own.empty() ? object.value_or("") : own, .material = material.value_or("")};
  }
};

/// Wavefront OBJ: v, vt, f (n-gons, negative indices), g, o, usemtl and the tags `t crease`,
/// `t corner` and `t hole` of OpenSubdiv's shapes. Three numbers behind a position are its colour
/// in sRGB, as other programs read and write it, a fourth is its alpha. A face's group takes its
/// name from g, or from o where g names none. Lines, points and free-form elements are counted as
/// dropped. Normals are passed over but for `split_normals_crease`, and in files without faces,
/// which have as many as vertices or none. Conditions and exceptions as read_mesh().
[[nodiscard]] MeshFile read_obj(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

}  // namespace planish
