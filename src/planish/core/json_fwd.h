#pragma once

// nlohmann's JSON in a namespace of planish's own (json.h), which it offers for that: a host's JSON
// of the same release stays as it is. In place of <nlohmann/json_fwd.hpp>.
#define NLOHMANN_JSON_NAMESPACE nlohmann::planish_json
#define NLOHMANN_JSON_NAMESPACE_BEGIN \
  namespace nlohmann {                \
  inline namespace planish_json {
#define NLOHMANN_JSON_NAMESPACE_END \
  }                                 \
  }
#include <nlohmann/json_fwd.hpp>
