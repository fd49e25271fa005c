#include "planish/files/pcd/pcd_header.h"

namespace planish {

void find_pcd_attributes(PcdHeader& header) {
  constexpr std::array<std::string_view, 3> kNormalNames = {"normal_x", "normal_y", "normal_z"};
  const std::size_t none = header.fields.size();
  const auto place_of = [&](std::string_view name, bool is_number) {
    const auto found = std::ranges::find(header.fields, name, &PcdField::name);
    const bool fits = found != header.fields.end() && found->count == 1 &&
                      (is_number ? found->type == 'F' && found->size >= 4 : found->size == 4);
    return fits ? static_cast<std::size_t>(found - header.fields.begin()) : none;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    header.places[kPcdNormal + axis] = place_of(kNormalNames[axis], true);
  if (!header.has(3) || !header.has(4) || !header.has(5))
    std::fill_n(header.places.begin() + kPcdNormal, 3, none);
  const std::size_t opaque = place_of("rgb", false);
  header.places[kPcdColor] = opaque < none ? opaque : place_of("rgba", false);
}

void find_further_fields(PcdHeader& header, PropertyNames& names) {
  constexpr std::array<std::string_view, 9> kKnown = {
      "x", "y", "z", "normal_x", "normal_y", "normal_z", "rgb", "rgba", "_"};
  for (std::size_t f = 0; f < header.fields.size(); ++f) {
    const PcdField& field = header.fields[f];
    const bool fits = field.count == 1 && (field.type != 'F' || field.size >= 4);
    if (fits && std::ranges::find(kKnown, field.name) == kKnown.end() && names.add(field.name))
      header.further.push_back(f);
  }
}

}  // namespace planish
