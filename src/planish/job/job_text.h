#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/json_fwd.h"
#include "planish/core/option.h"
#include "planish/job/report.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/settings.h"

namespace planish {

/// What a cage says about how it was made, so that `verify` needs no flags.
struct CageHeader {
  /// The defaults where it says nothing, of the progressive method.
  FitSettings settings{.interpolation = InterpolationChoice::Progressive, .creases = {}};
  std::optional<FoundCreases> found;  ///< of the prepared mesh
  std::string source;                 ///< file name of the input; may be empty
};

/// Comment lines "planish key=value" for MeshWriteOptions: what shapes the surface, the tolerance
/// and the input's file name.
[[nodiscard]] std::vector<std::string> cage_header_lines(FitSettings settings,
                                                         InterpolationMethod method,
                                                         const std::string& source,
                                                         const FoundCreases& found = {});

/// Reads them back; a leading comment sign is allowed. Keys that are not known are left to newer
/// versions. Throws Error{UnreadableInput} naming `name` for a known key whose value is none.
[[nodiscard]] CageHeader parse_cage_header(std::span<const std::string> lines,
                                           const std::string& name);

/// Whether cages say it: the same options are flags of `verify`.
[[nodiscard]] bool is_of_cages(const OptionInfo& option);

/// Throws Error{InvalidArgument} for the method auto: a cage was made by one of the others.
void require_known_method(const FitSettings& settings, std::string_view where);

/// 0.41 s or 12 ms or 0.3 ms.
[[nodiscard]] std::string duration(double milliseconds);

/// A third to three times as long: "under 2 s", "4 to 36 s", "1 to 9 min".
[[nodiscard]] std::string rough_duration(double seconds);

/// What messages call an input or an output: its whole path, made visible; "-" is stdin or stdout.
[[nodiscard]] std::string input_name(std::string_view path);
[[nodiscard]] std::string output_name(std::string_view path);

/// A message that says whose it is: "bust.obj: what", the name once. No name: the message.
[[nodiscard]] std::string named_message(std::string_view name, const std::string& message);

/// Valid UTF-8 without controls (without_controls()): what may stand in a file's header or in glTF.
/// Each that does not fit becomes '?', and so does a byte that is no UTF-8.
[[nodiscard]] std::string plain_utf8(std::string_view text);

/// What report_json() is the text of.
[[nodiscard]] nlohmann::ordered_json to_json(const JobReport& report);

/// The "reconstruction" of a report.
[[nodiscard]] nlohmann::ordered_json to_json(const PointFacts& points);

/// Indented text of any JSON value, with a line end. Text that is no UTF-8 is made so.
[[nodiscard]] std::string json_text(const nlohmann::ordered_json& value);

/// {"3": 20, "4": 1}: the non-zero entries of a histogram.
[[nodiscard]] nlohmann::ordered_json histogram_json(const std::vector<std::int64_t>& counts);

/// What `-v` adds to the summary: threads, the bound of the spectrum, the error after every
/// iteration, peak memory, what fold repair chose.
[[nodiscard]] std::string details(const JobReport& report);

/// What can be done with what was written, for a person at a terminal.
[[nodiscard]] std::string next_step(const JobReport& report);

}  // namespace planish
