#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "planish/core/json_fwd.h"

namespace planish::command {

/// Keys in the order of the file, as in reports: one type of JSON is enough to compile.
using Json = nlohmann::ordered_json;

// Values of a scene file. Each refuses what it is not: `where: what is wanted, not what is`.

void require_object(const Json& json, const std::string& where);
[[nodiscard]] const std::string& text_of(const Json& json, const std::string& where);
[[nodiscard]] std::int64_t integer_of(const Json& json, const std::string& where);
/// From `least` to `most`.
[[nodiscard]] std::int64_t count_of(const Json& json, const std::string& where, std::int64_t least,
                                    std::int64_t most);
[[nodiscard]] double number_of(const Json& json, const std::string& where);
/// From 0 to 1.
[[nodiscard]] double fraction_of(const Json& json, const std::string& where);

// Where a value stands: "scene.json: jobs[0].solve".
[[nodiscard]] std::string key_path(const std::string& where, std::string_view key);
[[nodiscard]] std::string entry_path(const std::string& where, std::size_t index);

/// Calls visit(entry, its place) for each entry of a list.
void for_entries(const Json& json, const std::string& where,
                 const std::function<void(const Json&, const std::string&)>& visit);

}  // namespace planish::command
