// Writes the types of the npm package: a form, with the options of calls from the table of options.
// Arguments: form, types.
#include <string>
#include <string_view>

#include "planish/pipeline/option_table.h"
#include "stubs/stub.h"

namespace planish::wasm {
namespace {

// What a mesh's fit takes: what shapes and solves it, and what its files are told. Tags come with
// the mesh.
bool is_of_fit(const OptionInfo& option) {
  if (option.kind == OptionKind::Vertices || option.kind == OptionKind::Edges) return false;
  return option.stage == OptionStage::Shape || option.stage == OptionStage::Solve ||
         option.needs == OptionNeeds::Step || option.name == "up" || option.name == "levels";
}

// What a file's takes besides. One file goes in and one comes out: nothing lies beside the input,
// and tiles are many. All is computed on the CPU.
bool is_of_file(const OptionInfo& option) {
  return (option.stage == OptionStage::Output || option.stage == OptionStage::Fineness) &&
         !is_of_fit(option) && option.needs != OptionNeeds::Tiles && option.name != "device";
}

// "maxIterations"
std::string key_of(const OptionInfo& option) {
  std::string key;
  bool is_first = false;
  for (const char letter : option.name) {
    if (letter != '_') key += is_first ? static_cast<char>(letter - 'a' + 'A') : letter;
    is_first = letter == '_';
  }
  return key;
}

// "'none' | 'quantize'"
std::string words_of(const OptionInfo& option) {
  std::string words;
  for (const std::string_view word : option.words)
    words += (words.empty() ? "'" : " | '") + std::string(word) + "'";
  return words;
}

std::string list_of(const std::string& entry, const OptionInfo& option) {
  const std::string word =
      option.word.empty() ? std::string() : " | '" + std::string(option.word) + "'";
  return entry + " | " + entry + "[]" + word;
}

std::string type_of(const OptionInfo& option) {
  switch (option.kind) {
    case OptionKind::Word:
      return words_of(option);
    case OptionKind::Words:
      return words_of(option) + " | (" + words_of(option) + ")[]";
    case OptionKind::Whole:
    case OptionKind::Number:
      return "number";
    case OptionKind::TextOrNumber:
      return "number | string";
    case OptionKind::Switch:
      return "boolean";
    case OptionKind::Wholes:
    case OptionKind::Numbers:
      return list_of("number", option);
    default:
      return "string";
  }
}

// Texts have no type that says what they may be.
std::string comment_of(const OptionInfo& option) {
  const bool is_text = option.kind == OptionKind::Text || option.kind == OptionKind::TextOrNumber;
  return (is_text ? choices_of(option) + "; " : std::string()) + help_of(option);
}

std::string option_lines(bool (*is_wanted)(const OptionInfo&)) {
  std::string lines;
  for (const FitOption& option : option_table())
    if (is_wanted(option))
      lines += "  /** " + comment_of(option) + " */\n  " + key_of(option) +
               "?: " + type_of(option) + ";\n";
  return lines;
}

}  // namespace
}  // namespace planish::wasm

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  using namespace planish::wasm;
  return planish::write_stub(argv[1], argv[2],
                             {{"  @FIT_OPTIONS@", option_lines(is_of_fit)},
                              {"  @FILE_OPTIONS@", option_lines(is_of_file)}})
             ? 0
             : 1;
}
