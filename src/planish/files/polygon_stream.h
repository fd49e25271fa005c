#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/files/shared/file_buffer.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/files/write_polygons.h"

namespace planish {

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

}  // namespace planish
