#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/files/write_polygons.h"

namespace planish {

/// Throws Error{InvalidArgument} `name: what` for fields of another size than `row_count`.
void require_field_sizes(std::span<const NamedField> fields, std::int64_t row_count,
                         const std::string& name);

/// Throws Error{InvalidArgument} `name: what, where, value` where counts and indices of polygons do
/// not fit each other, and for faces of fewer than 3 corners.
void require_writable(const PolygonView& view, const std::string& name);

/// Writes polygons part by part, for formats that know the order of their parts: pieces are
/// formatted on all threads and reach the sinks in order, and few exist at once.
class PolygonStream {
 public:
  /// `name` is that of the file, for messages. What is referred to must outlive the stream.
  PolygonStream(const PolygonSource& source, std::span<const ByteSink> sinks,
                const FormatInfo& format, std::string name, std::string companion,
                const UsdMaterials* materials)
      : source_(source),
        sinks_(sinks),
        format_(format),
        name_(std::move(name)),
        companion_(std::move(companion)),
        materials_(materials) {}

  [[nodiscard]] const PolygonTotals& totals() const { return source_.totals(); }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// The file beside it that holds its materials; empty: none.
  [[nodiscard]] const std::string& companion() const { return companion_; }

  /// Those of groups, where USD has some; else null.
  [[nodiscard]] const UsdMaterials* materials() const { return materials_; }

  void text(std::string_view text) const {
    for (const ByteSink& sink : sinks_) sink(std::as_bytes(std::span(text)));
  }
  /// Calls format(out, piece, range) for the ranges of a part, or for some of them. Throws
  /// Error{InvalidArgument} for numbers that are not finite, or that float32 cannot hold where the
  /// format has no others.
  template <class Format>
  void part(PolygonPart part, const Format& format) const {
    pieces(part, source_.ranges(part), format);
  }
  template <class Format>
  void pieces(PolygonPart part, std::span<const RowRange> ranges, const Format& format) const {
    std::atomic<bool> fits{true};
    source_.prepare(part);
    stream(
        ranges,
        [&](RowRange range, RawVector<std::byte>& bytes) {
          source_.visit(part, range, [&](const PolygonPiece& piece) {
            if (!can_write(piece.view)) fits = false;
            FileBuffer out(bytes);
            format(out, piece, range);
            out.finish();
          });
        },
        sinks_);
    if (!fits) refuse(part);
  }
  /// Calls look(piece, range) for all ranges of a part on all threads at once.
  template <class Look>
  void look(PolygonPart part, const Look& look) const {
    const std::vector<RowRange> ranges = source_.ranges(part);
    source_.prepare(part);
    parallel_for(ranges.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        source_.visit(part, ranges[i], [&](const PolygonPiece& piece) { look(piece, ranges[i]); });
    });
  }

 private:
  [[nodiscard]] bool can_write(const PolygonView& view) const;
  [[noreturn]] void refuse(PolygonPart part) const;

  const PolygonSource& source_;
  std::span<const ByteSink> sinks_;
  const FormatInfo& format_;
  std::string name_, companion_;
  const UsdMaterials* materials_;
};

/// Binary STL: float32 triangles, as glTF has them (mesh/face_geometry.h), with the normals of
/// their planes, (0, 0, 0) where they have no area. Throws Error{InvalidArgument} for 2^32
/// triangles.
void write_stl(const PolygonStream& stream);

inline constexpr std::array kOffParts = {PolygonPart::Head, PolygonPart::Positions,
                                         PolygonPart::Faces};

/// OFF: positions and faces.
void write_off(const PolygonStream& stream);

/// USD as text: one Mesh with normals, colours (displayColor, displayOpacity), texture coordinates
/// (st), fields (primvars) and a GeomSubset for each group, bound to its material where that is
/// known (materials.h). Numbers are shortest round-trip text of the float32 that the format
/// has. A view with a subdivision is written as the cage of its scheme with creases, corners and
/// holes, so that readers draw the limit surface themselves.
void write_usda(const PolygonStream& stream);

inline constexpr std::array kObjParts = {PolygonPart::Head,  PolygonPart::Positions,
                                         PolygonPart::Uvs,   PolygonPart::Normals,
                                         PolygonPart::Faces, PolygonPart::Tail};

/// OBJ: `vn` for normals, `vt`, `g`, `usemtl`, colours in sRGB behind the positions, `t` tags for
/// creases, corners and holes. Names lose what OBJ cannot hold: control characters, `#` before a
/// word, `\` at the end. Holds all that a mesh has, so that reading it gives the same mesh.
void write_obj(const PolygonStream& stream);

inline constexpr std::array kPlyParts = {PolygonPart::Head, PolygonPart::Vertices,
                                         PolygonPart::Faces};

/// PLY: binary little endian, double positions, float `nx ny nz` for normals, sRGB colours of 8
/// bits. Texture coordinates are float `s t` of the vertices, which most readers know, where every
/// vertex has one; beside seams they are lists `texcoord` of the faces, of two numbers a corner, so
/// that no vertex has to be written twice. The list of a face that lacks any is empty.
void write_ply(const PolygonStream& stream);

// What writers ask of numbers before a file is in its place: readers refuse those that are not
// finite, or take them for anything.

[[nodiscard]] inline bool is_finite(double number) { return std::isfinite(number); }
template <glm::length_t kLength, class Number>
[[nodiscard]] bool is_finite(const glm::vec<kLength, Number>& vector) {
  bool all = true;
  for (glm::length_t k = 0; k < kLength; ++k) all = all && std::isfinite(vector[k]);
  return all;
}

template <class Value>
[[nodiscard]] bool all_finite(std::span<const Value> values) {
  for (const Value& value : values)
    if (!is_finite(value)) return false;
  return true;
}

/// As messages show them: "nan", "(0, nan, 1)".
[[nodiscard]] inline std::string number_words(double number) { return short_number(number); }
template <glm::length_t kLength, class Number>
[[nodiscard]] std::string number_words(const glm::vec<kLength, Number>& vector) {
  std::string words = "(";
  for (glm::length_t k = 0; k < kLength; ++k)
    words += (k == 0 ? "" : ", ") + short_number(static_cast<double>(vector[k]));
  return words + ")";
}

/// Throws Error{InvalidArgument} `name: what 4 is not finite: (0, nan, 1); ...`.
template <class Value>
[[noreturn]] void refuse_not_finite(const std::string& name, std::string_view what,
                                    std::int64_t element, const Value& value) {
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: {} {} is not finite: {}; mend what made it, or leave it out", name,
                        what, element, number_words(value)),
              element);
}

/// The same for the first of the values that is none; they are `width` an element, of which the
/// first has number `first`.
template <class Value>
void require_finite(std::span<const Value> values, std::int64_t first, std::string_view what,
                    const std::string& name, std::size_t width = 1) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!is_finite(values[i]))
      refuse_not_finite(name, what, first + static_cast<std::int64_t>(i / width), values[i]);
}

}  // namespace planish
