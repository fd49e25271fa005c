#include <CLI/CLI.hpp>

#include "commands.h"

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

}  // namespace planish::command
