#include "planish/files/shared/property_names.h"

#include <utility>

#include "planish/core/formatted.h"
#include "planish/core/lower_case.h"
#include "planish/core/number_text.h"
#include "planish/files/shared/identifier.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

constexpr std::size_t kMostNameBytes = 64;
// Names of USD, which knows the others apart by their case.
constexpr std::array<std::string_view, 3> kTakenNames = {"st", "displaycolor", "displayopacity"};

}  // namespace

PropertyNames::PropertyNames() : taken_(kTakenNames.begin(), kTakenNames.end()) {
  for (const KnownProperty& known : kKnownProperties) taken_.emplace(known.name);
}

bool PropertyNames::add(const std::string& given) {
  std::string name = identifier_of(given);
  if (names_.size() < kMaxProperties && name.size() <= kMostNameBytes &&
      taken_.insert(lower_case(name)).second) {
    names_.push_back(std::move(name));
    return true;
  }
  if (left_out_count_++ == 0) left_out_ = given;
  return false;
}

void PropertyNames::warn(std::vector<Warning>& warnings, std::string_view file,
                         std::string_view elements) const {
  if (left_out_count_ == 0) return;
  warnings.push_back(
      {.code = "left-out-properties",
       .message =
           formatted("{}: property {} of the {} is left out{}; {} are read, of names of their own, "
                     "whatever their case",
                     file, quote(left_out_), elements,
                     left_out_count_ > 1 ? formatted(", and {} more", left_out_count_ - 1) : "",
                     kMaxProperties),
       .count = left_out_count_});
}

}  // namespace planish
