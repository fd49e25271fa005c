#pragma once

#include <array>

#include "planish/files/polygon_stream.h"

namespace planish {

inline constexpr std::array kOffParts = {PolygonPart::Head, PolygonPart::Positions,
                                         PolygonPart::Faces};

/// OFF: positions and faces.
void write_off(const PolygonStream& stream);

}  // namespace planish
