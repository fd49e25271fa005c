#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "planish/files/write_polygons.h"

namespace planish {

/// Throws Error{InvalidArgument} `name: what` for fields of another size than `row_count`.
void require_field_sizes(std::span<const NamedField> fields, std::int64_t row_count,
                         const std::string& name);

/// Throws Error{InvalidArgument} `name: what, where, value` where counts and indices of polygons do
/// not fit each other, and for faces of fewer than 3 corners.
void require_writable(const PolygonView& view, const std::string& name);

}  // namespace planish
