#include "terminal/watch.h"

namespace planish::command {

JobWatch watch_of(Console& console, JobDisplay& display, JobPage* page) {
  return {.progress = display.visit(),
          .warning = [&console](const Warning& warning) { console.warning(warning.message); },
          .details = [&console](const std::string& lines) { console.debug(lines); },
          .write =
              [&console](std::string_view bytes) {
                console.clear_status();
                write_stdout(bytes);
              },
          .page = page};
}

}  // namespace planish::command
