// Writes the stub of the Python module: a template, with the keywords of functions from the table
// of options. Arguments: template, stub.
#include <string>

#include "keywords.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"
#include "stubs/stub.h"

namespace planish::python {
namespace {

std::string type_of(const OptionInfo& option) {
  if (option.kind == OptionKind::Whole) return "int";
  if (option.kind == OptionKind::Number) return "float";
  if (option.kind == OptionKind::TextOrNumber) return "float | str";
  if (option.kind == OptionKind::Switch) return "bool";
  if (option.kind == OptionKind::Wholes) return "int | Sequence[int] | str";
  if (option.kind == OptionKind::Numbers) return "float | Sequence[float] | str";
  if (option.kind == OptionKind::Words) return "str | Sequence[str]";
  if (option.words.empty()) return "str";
  std::string words;
  for (const std::string_view word : option.words)
    words += (words.empty() ? "" : ", ") + ("\"" + std::string(word) + "\"");
  return "Literal[" + words + "]";
}

std::string keyword_line(const OptionInfo& option) {
  const char* const none = option.initial.empty() ? " | None" : "";
  return "    " + keyword_of(option) + ": " + type_of(option) + none + " = ...,\n";
}

std::string keyword_lines(bool (*is_wanted)(const OptionInfo&)) {
  std::string lines;
  for (const FitOption& option : option_table())
    if (is_wanted(option)) lines += keyword_line(option);
  return lines;
}

// But for `levels`, which may stand without its name.
std::string file_lines() {
  std::string lines = keyword_lines(
      [](const OptionInfo& option) { return is_file_keyword(option) && option.name != "levels"; });
  for (const PointOption& option : point_option_table()) lines += keyword_line(option);
  return lines;
}

std::string fit_lines() {
  return keyword_lines(is_keyword) +
         "    threads: int = ...,\n"
         "    progress: Progress | None = ...,\n"
         "    cancelled: Cancelled | None = ...,\n";
}

}  // namespace
}  // namespace planish::python

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  using namespace planish::python;
  return planish::write_stub(argv[1], argv[2],
                             {{"    @FIT_KEYWORDS@", fit_lines()},
                              {"    @FILE_KEYWORDS@", file_lines()},
                              {"    @WRITE_KEYWORDS@", keyword_lines(is_write_keyword)}})
             ? 0
             : 1;
}
