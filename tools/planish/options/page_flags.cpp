#include <CLI/CLI.hpp>

#include "commands.h"
#include "options/page_flags.h"
#include "options/size_value.h"

namespace planish::command {

void add_page_flags(CLI::App& command, const PageFlags& flags) {
  command
      .add_option("--page", flags.path,
                  "HTML page to look at: the surface in 3-D, figures, plots; - for stdout")
      ->type_name("FILE")
      ->group("Page");
  command
      .add_option("--page-limit", flags.limit,
                  "largest page; a coarser level is shown where the surface needs more [8M]")
      ->type_name("SIZE")
      ->group("Page");
  command
      .add_flag("--page-no-times", flags.no_times,
                "leave times and memory out: the same run gives the same bytes")
      ->group("Page");
}

std::uint64_t parse_page_limit(std::string_view value, std::string_view where) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 32;  // browsers hold a page as text
  return parse_size(value, where, kMost, "8M or 500K");
}

PageOptions page_options(const std::string& limit, bool no_times) {
  PageOptions options;
  options.times = !no_times;
  if (!limit.empty()) options.limit_bytes = parse_page_limit(limit, "--page-limit");
  return options;
}

}  // namespace planish::command
