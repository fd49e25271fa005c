#include "planish/files/off/write_off.h"

#include "planish/files/shared/write_numbers.h"

namespace planish {

void write_off(const PolygonStream& stream) {
  for (const PolygonPart part : kOffParts) {
    stream.part(part, [&](FileBuffer& out, const PolygonPiece& piece, RowRange) {
      const PolygonView& view = piece.view;
      if (part == PolygonPart::Head) {
        out.text("OFF\n");
        for (const std::string& line : view.header) out.text("# ").text(line).text("\n");
        out.number(piece.totals.row_count).text(" ").number(piece.totals.face_count);
        out.text(" 0\n");
      }
      for (const glm::dvec3& position : view.positions) write_position(out, position);
      for (std::size_t face = 0; face < view.face_count(); ++face) {
        const auto corners = view.face(face);
        out.number(corners.size());
        for (const std::int32_t vertex : corners) out.text(" ").number(vertex);
        out.text("\n");
      }
    });
  }
}

}  // namespace planish
