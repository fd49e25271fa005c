#pragma once

#include <string>

namespace planish {

/// A name of letters, digits and '_', no digit first: other bytes become '_'.
[[nodiscard]] std::string identifier_of(const std::string& name);

}  // namespace planish
