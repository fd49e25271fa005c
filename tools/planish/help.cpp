#include "help.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "commands.h"
#include "planish/core/error.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "scene_file.h"

namespace planish::command {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::istringstream stream(text);
  std::vector<std::string> parts;
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

// A word in small letters; "N", "K,FACTOR" and "L[,L2,...]" are none.
bool is_word(const std::string& text) {
  return !text.empty() && std::ranges::none_of(text, [](unsigned char c) {
    return std::isupper(c) != 0 || c == ',' || c == '[' || c == ' ';
  });
}

// Of "a|b|c", "a,b,c", whose words may stand together, and "a"; "auto[:N]|INDEX" leaves "auto".
void take_choices(HelpOption& option) {
  const std::vector<std::string> several = split(option.value, ',');
  option.takes_several = several.size() > 1 && std::ranges::all_of(several, is_word);
  for (const std::string& part : option.takes_several ? several : split(option.value, '|')) {
    const std::string word = part.substr(0, part.find('['));
    if (is_word(word)) option.choices.push_back(word);
  }
}

HelpOption option_of(const CLI::Option& option, const CommandText& text) {
  HelpOption result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  if (option.get_items_expected_max() != 0) result.value = option.get_type_name();
  if (option.get_positional()) result.names = {result.value};
  take_choices(result);
  result.text = option.get_description();
  const auto is_first = [&](const std::string& name) {
    return std::ranges::find(text.first_flags, name) != text.first_flags.end();
  };
  result.is_first = text.first_flags.empty() || std::ranges::any_of(result.names, is_first);
  result.takes_file = result.value == "FILE" || result.value == "DIR" || option.get_positional();
  return result;
}

HelpPage page_of(const CLI::App& command, const CommandTexts& texts) {
  HelpPage page;
  const CLI::App* parent = command.get_parent();
  page.program = parent == nullptr ? command.get_name() : parent->get_name();
  if (parent != nullptr) page.name = command.get_name();
  page.summary = command.get_description();
  if (const auto text = texts.find(page.name); text != texts.end()) page.text = text->second;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    const HelpOption described = option_of(*option, page.text);
    if (option->get_positional()) {
      page.arguments.push_back(described);
      continue;
    }
    auto topic = std::ranges::find(page.topics, option->get_group(), &HelpTopic::title);
    if (topic == page.topics.end()) {
      page.topics.push_back({option->get_group(), {}});
      topic = page.topics.end() - 1;
    }
    topic->options.push_back(described);
  }
  return page;
}

}  // namespace

std::string HelpPage::usage() const {
  std::string line = full_name();
  if (!commands.empty()) return line + " COMMAND [FLAGS] ...";
  if (!topics.empty()) line += " [FLAGS]";
  for (const HelpOption& argument : arguments) line += " " + argument.value;
  return line;
}

HelpPage help_page(const CLI::App& app, const CommandTexts& texts) {
  HelpPage page = page_of(app, texts);
  for (const CLI::App* command : app.get_subcommands({})) {
    if (!command->get_description().empty()) page.commands.push_back(page_of(*command, texts));
  }
  return page;
}

namespace {

constexpr int kNarrowest = 40, kWidest = 100;
constexpr int kFlagColumn = 24;     // where the texts of flags begin
constexpr int kCommandColumn = 16;  // and those of commands

int sensible(int columns) { return std::clamp(columns, kNarrowest, kWidest); }

// "  -o, --output FILE       text", the text in a column of its own.
std::string entry(const std::string& head, const std::string& text, int column, int columns) {
  std::string line = "  " + head;
  const std::string indent(static_cast<std::size_t>(column), ' ');
  if (static_cast<int>(line.size()) + 2 > column) {
    line += "\n" + indent;
  } else {
    line.resize(static_cast<std::size_t>(column), ' ');
  }
  return line + wrapped(text, columns - column, column) + "\n";
}

std::string head_of(const HelpOption& option) {
  std::string head;
  for (const std::string& name : option.names) head += (head.empty() ? "" : ", ") + name;
  if (head.starts_with("--")) head = "    " + head;
  if (!option.value.empty() && option.names.front().starts_with('-')) head += " " + option.value;
  return head;
}

std::string entry_of(const HelpOption& option, int columns) {
  return entry(head_of(option), option.text, kFlagColumn, columns);
}

std::string arguments_text(const HelpPage& page, int columns) {
  std::string text;
  for (const HelpOption& argument : page.arguments)
    text += entry(argument.value, argument.text, kFlagColumn, columns);
  return text.empty() ? text : "\n" + text;
}

std::string examples_text(const HelpPage& page, std::size_t most) {
  if (page.text.examples.empty()) return {};
  std::string text = "\nExamples:\n";
  for (std::size_t i = 0; i < std::min(most, page.text.examples.size()); ++i)
    text += "  " + page.text.examples[i] + "\n";
  return text;
}

std::string head_text(const HelpPage& page, int columns) {
  return formatted("{}\n\nUsage: {}\n", wrapped(page.summary, columns, 0), page.usage());
}

std::string commands_text(const HelpPage& page, int columns) {
  std::string text = "\nCommands:\n";
  for (const HelpPage& command : page.commands)
    text += entry(command.name, command.summary, kCommandColumn, columns);
  return text;
}

}  // namespace

std::string wrapped(const std::string& text, int columns, int indent) {
  const auto width = static_cast<std::size_t>(std::max(columns, 16));
  std::istringstream words(text);
  std::string result, word;
  std::size_t used = 0;
  while (words >> word) {
    if (used > 0 && used + 1 + word.size() > width) {
      result += "\n" + std::string(static_cast<std::size_t>(indent), ' ');
      used = 0;
    }
    if (used > 0) {
      result += ' ';
      ++used;
    }
    result += word;
    used += word.size();
  }
  return result;
}

std::string short_help(const HelpPage& page, int columns) {
  columns = sensible(columns);
  std::string text = head_text(page, columns);
  if (!page.commands.empty()) text += commands_text(page, columns);
  text += arguments_text(page, columns);
  std::string flags;
  std::size_t left_out = 0;
  for (const HelpTopic& topic : page.topics) {
    for (const HelpOption& option : topic.options) {
      if (option.is_first) {
        flags += entry_of(option, columns);
      } else {
        ++left_out;
      }
    }
  }
  if (!flags.empty()) text += "\n" + flags;
  text += examples_text(page, 3);
  if (left_out > 0)
    text += formatted("\n{} --help has {} more flags, by topic.\n", page.full_name(), left_out);
  if (!page.commands.empty()) text += "\nplanish COMMAND -h says more of each.\n";
  return text;
}

std::string long_help(const HelpPage& page, int columns) {
  columns = sensible(columns);
  std::string text = head_text(page, columns);
  if (!page.commands.empty()) text += commands_text(page, columns);
  text += arguments_text(page, columns);
  for (const HelpTopic& topic : page.topics) {
    text += "\n" + topic.title + ":\n";
    for (const HelpOption& option : topic.options) text += entry_of(option, columns);
  }
  text += examples_text(page, page.text.examples.size());
  std::istringstream paragraphs(page.text.notes);
  for (std::string line; std::getline(paragraphs, line);)
    text += "\n" + wrapped(line, columns, 0) + "\n";
  return text;
}

std::string overview(const HelpPage& page, int columns) {
  columns = sensible(columns);
  std::string text = wrapped(page.summary, columns, 0) + "\n" + commands_text(page, columns);
  if (!page.text.examples.empty()) text += "\nTo begin with:  " + page.text.examples.front() + "\n";
  return text + "planish -h says more.\n";
}

namespace {

// Text as roff reads it: hyphens that are to be copied, no line that looks like a request.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) {
      out += std::string("\\&") + c;
    } else {
      out += c;
    }
  }
  return out;
}

std::string page_name(const HelpPage& page) {
  return page.name.empty() ? page.program : page.program + "-" + page.name;
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string option_entry(const HelpOption& option) {
  std::string head;
  for (const std::string& name : option.names)
    head += (head.empty() ? "" : ", ") + std::string("\\fB") + roff(name) + "\\fR";
  if (!option.value.empty() && option.names.front().starts_with('-'))
    head += " \\fI" + roff(option.value) + "\\fR";
  return ".TP\n" + head + "\n" + roff(option.text) + "\n";
}

std::string commands_section(const HelpPage& page) {
  if (page.commands.empty()) return {};
  std::string text = ".SH COMMANDS\n";
  for (const HelpPage& command : page.commands)
    text += ".TP\n\\fB" + roff(command.full_name()) + "\\fR\n" + roff(command.summary) + "\n";
  return text;
}

std::string options_section(const HelpPage& page) {
  std::string text;
  if (!page.arguments.empty()) {
    text += ".SH ARGUMENTS\n";
    for (const HelpOption& argument : page.arguments) text += option_entry(argument);
  }
  if (!page.topics.empty()) text += ".SH OPTIONS\n";
  for (const HelpTopic& topic : page.topics) {
    text += ".SS " + roff(topic.title) + "\n";
    for (const HelpOption& option : topic.options) text += option_entry(option);
  }
  return text;
}

std::string examples_section(const HelpPage& page) {
  if (page.text.examples.empty()) return {};
  std::string text = ".SH EXAMPLES\n.nf\n";
  for (const std::string& example : page.text.examples) text += roff(example) + "\n";
  return text + ".fi\n";
}

std::string notes_section(const HelpPage& page) {
  if (page.text.notes.empty()) return {};
  std::string text = ".SH NOTES\n";
  std::istringstream paragraphs(page.text.notes);
  for (std::string line; std::getline(paragraphs, line);) text += ".PP\n" + roff(line) + "\n";
  return text;
}

std::string see_also(const HelpPage& page, const HelpPage& help) {
  std::vector<std::string> names;
  if (help.program != "planish") names.emplace_back("planish");
  if (!page.name.empty()) names.push_back(page_name(help));
  for (const HelpPage& command : help.commands)
    if (command.name != page.name) names.push_back(page_name(command));
  std::string text = ".SH SEE ALSO\n";
  for (std::size_t i = 0; i < names.size(); ++i)
    text += ".BR " + roff(names[i]) + " (1)" + (i + 1 < names.size() ? "," : "") + "\n";
  return text;
}

// "planish: what it is" says its name already.
std::string summary_of(const HelpPage& page) {
  const std::string title = page_name(page) + ": ";
  return page.summary.starts_with(title) ? page.summary.substr(title.size()) : page.summary;
}

}  // namespace

std::string manual_page(const HelpPage& page, const HelpPage& help) {
  // No date: the same build gives the same page.
  return ".TH " + upper(page_name(page)) + " 1 \"\" \"planish " PLANISH_VERSION "\" \"planish\"\n" +
         ".SH NAME\n" + roff(page_name(page)) + " \\- " + roff(summary_of(page)) +
         "\n.SH SYNOPSIS\n\\fB" + roff(page.usage()) + "\\fR\n" + commands_section(page) +
         options_section(page) + examples_section(page) + notes_section(page) +
         see_also(page, help);
}

namespace {

enum class Shell { Bash, Zsh, Fish };

std::string word_list(const std::vector<std::string>& words, const char* separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

std::vector<std::string> all_flags(const HelpPage& page) {
  std::vector<std::string> flags;
  for (const HelpTopic& topic : page.topics)
    for (const HelpOption& option : topic.options)
      flags.insert(flags.end(), option.names.begin(), option.names.end());
  return flags;
}

std::vector<std::string> command_names(const std::vector<HelpPage>& commands) {
  std::vector<std::string> names;
  names.reserve(commands.size());
  for (const HelpPage& command : commands) names.push_back(command.name);
  return names;
}

// In single quotes for a shell.
std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

// The words that stand for an argument of a command, "bash zsh fish" say.
std::vector<std::string> argument_words(const HelpPage& page) {
  return page.arguments.empty() ? std::vector<std::string>() : page.arguments.front().choices;
}

// ---- bash ----

std::string bash_values(const HelpPage& page) {
  std::string cases;
  for (const HelpTopic& topic : page.topics) {
    for (const HelpOption& option : topic.options) {
      if (option.value.empty()) continue;
      cases += "        " + word_list(option.names, "|") + ") ";
      if (option.takes_several)
        cases += "[[ $word == *,* ]] && head+=${word%,*}, word=${word##*,}; ";
      if (!option.choices.empty())
        cases += "COMPREPLY=($(compgen -P \"$head\" -W '" + word_list(option.choices, " ") +
                 "' -- \"$word\")); ";
      // What is no list of words is a file, or a number: bash's own files do no harm.
      cases += "return ;;\n";
    }
  }
  return cases;
}

std::string bash_command(const HelpPage& page) {
  std::string text = "    " + page.name + ")\n";
  const std::string values = bash_values(page);
  if (!values.empty()) text += "      case $before in\n" + values + "      esac\n";
  text += "      if [[ $word == -* ]]; then\n        COMPREPLY=($(compgen -W '" +
          word_list(all_flags(page), " ") + "' -- \"$word\"))\n";
  const auto words = argument_words(page);
  if (!words.empty())
    text += "      else\n        COMPREPLY=($(compgen -W '" + word_list(words, " ") +
            "' -- \"$word\"))\n";
  return text + "      fi ;;\n";
}

std::string bash_script(const HelpPage& help) {
  std::string text = formatted(
      R"(# bash completion of planish; made by: planish completion bash
_planish() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} head=
  COMPREPLY=()
  # --flag=VALUE is three words to bash, unless COMP_WORDBREAKS has no =.
  if [[ $word == = ]]; then word=
  elif [[ $before == = ]]; then before=${COMP_WORDS[COMP_CWORD-2]}
  elif [[ $word == --*=* ]]; then before=${word%%=*} head=$before= word=${word#*=}
  fi
  if ((COMP_CWORD == 1)); then
    COMPREPLY=($(compgen -W '{} {}' -- "$word"))
    return
  fi
  case ${COMP_WORDS[1]} in
)",
      word_list(command_names(help.commands), " "), word_list(all_flags(help), " "));
  for (const HelpPage& command : help.commands) text += bash_command(command);
  return text + "  esac\n}\ncomplete -o default -F _planish planish\n";
}

// ---- zsh ----

// Within _arguments' brackets and colons.
std::string zsh_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string zsh_action(const HelpOption& option) {
  const std::string words = word_list(option.choices, " ");
  if (option.takes_several) return formatted("_values -s , {} {}", zsh_text(option.value), words);
  if (!words.empty()) return "(" + words + ")";
  return option.takes_file ? "_files" : "";
}

std::string zsh_option(const HelpOption& option) {
  std::string text;
  for (const std::string& name : option.names) {
    // With = the value may stand behind it or be the next word.
    const bool is_long = !option.value.empty() && name.starts_with("--");
    std::string spec = formatted("*{}{}[{}]", name, is_long ? "=" : "", zsh_text(option.text));
    if (!option.value.empty()) spec += ":" + zsh_text(option.value) + ":" + zsh_action(option);
    text += "        " + in_quotes(spec) + " \\\n";
  }
  return text;
}

std::string zsh_command(const HelpPage& page) {
  std::string text = "    " + page.name + ")\n      _arguments \\\n";
  for (const HelpTopic& topic : page.topics)
    for (const HelpOption& option : topic.options) text += zsh_option(option);
  const auto words = argument_words(page);
  const std::string action = words.empty() ? "_files" : "(" + word_list(words, " ") + ")";
  return formatted("{}        {} ;;\n", text, in_quotes("*:argument:" + action));
}

std::string zsh_script(const HelpPage& help) {
  std::string text =
      "#compdef planish\n# zsh completion of planish; made by: planish completion zsh\n"
      "_planish() {\n  local -a commands\n  commands=(\n";
  for (const HelpPage& command : help.commands)
    text += "    " + in_quotes(command.name + ":" + zsh_text(command.summary)) + "\n";
  text +=
      "  )\n  if ((CURRENT == 2)); then\n    _describe command commands\n    return\n  fi\n"
      "  local command=$words[2]\n  shift words\n  ((CURRENT--))\n  case $command in\n";
  for (const HelpPage& command : help.commands) text += zsh_command(command);
  return text +
         "  esac\n}\n"
         "if [ \"$funcstack[1]\" = _planish ]; then _planish \"$@\"; else compdef _planish "
         "planish; "
         "fi\n";
}

// ---- fish ----

std::string fish_option(const std::string& condition, const HelpOption& option) {
  std::string text = "complete -c planish -n " + in_quotes(condition);
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (!option.value.empty()) {
    if (option.takes_several) {
      text += " -x -a " + in_quotes("(__fish_complete_list , \"string split , " +
                                    word_list(option.choices, ",") + "\")");
    } else if (!option.choices.empty()) {
      text += " -x -a " + in_quotes(word_list(option.choices, " "));
    } else {
      text += option.takes_file ? " -r -F" : " -x";
    }
  }
  return formatted("{} -d {}\n", text, in_quotes(option.text));
}

std::string fish_script(const HelpPage& help) {
  std::string text = "# fish completion of planish; made by: planish completion fish\n";
  const std::string first = "__fish_use_subcommand";
  for (const HelpPage& command : help.commands)
    text += formatted("complete -c planish -f -n {} -a {} -d {}\n", in_quotes(first), command.name,
                      in_quotes(command.summary));
  for (const HelpTopic& topic : help.topics)
    for (const HelpOption& option : topic.options) text += fish_option(first, option);
  for (const HelpPage& command : help.commands) {
    const std::string condition = "__fish_seen_subcommand_from " + command.name;
    for (const HelpTopic& topic : command.topics)
      for (const HelpOption& option : topic.options) text += fish_option(condition, option);
    const auto words = argument_words(command);
    if (!words.empty())
      text += formatted("complete -c planish -f -n {} -a {}\n", in_quotes(condition),
                        in_quotes(word_list(words, " ")));
  }
  return text;
}

// "bash", "zsh" or "fish".
std::optional<Shell> shell_of(std::string_view name) {
  if (name == "bash") return Shell::Bash;
  if (name == "zsh") return Shell::Zsh;
  if (name == "fish") return Shell::Fish;
  return std::nullopt;
}

// A script that completes commands, flags, the words that a flag takes, and files.
std::string completion_script(Shell shell, const HelpPage& help) {
  switch (shell) {
    case Shell::Bash:
      return bash_script(help);
    case Shell::Zsh:
      return zsh_script(help);
    case Shell::Fish:
      return fish_script(help);
  }
  return {};
}

ExitCode print_completion(const std::string& name) {
  constexpr std::array<std::string_view, 3> kShells{"bash", "zsh", "fish"};
  const auto shell = shell_of(name);
  if (!shell)
    throw Error(ErrorCode::InvalidArgument,
                formatted("planish completion: \"{}\" is not one of bash, zsh, fish{}",
                          visible(name), did_you_mean(name, kShells)));
  write_stdout(completion_script(*shell, all_help()));
  return ExitCode::Done;
}

ExitCode print_manual(const std::string& name) {
  const HelpPage help = all_help();
  if (name.empty()) {
    write_stdout(manual_page(help, help));
    return ExitCode::Done;
  }
  for (const HelpPage& page : help.commands) {
    if (page.name != name) continue;
    write_stdout(manual_page(page, help));
    return ExitCode::Done;
  }
  throw Error(ErrorCode::InvalidArgument, "planish has no command \"" + visible(name) + "\"");
}

ExitCode print_schema() {
  write_stdout(scene_schema_text());
  return ExitCode::Done;
}

}  // namespace

void add_help_commands(CLI::App& app, Invocation& invocation) {
  CLI::App* completion =
      app.add_subcommand("completion", "a script that completes planish's flags in a shell");
  auto shell = std::make_shared<std::string>();
  completion->add_option("SHELL", *shell, "the shell")->type_name("bash|zsh|fish")->required();
  invocation.texts["completion"] = {
      .examples = {"planish completion bash > ~/.local/share/bash-completion/completions/planish",
                   "planish completion zsh > ~/.zfunc/_planish",
                   "planish completion fish > ~/.config/fish/completions/planish.fish"},
      .first_flags = {},
      .notes = ""};
  completion->callback(
      [shell, &invocation] { invocation.action = [shell] { return print_completion(*shell); }; });
  // For the build, which installs what it prints; without a description it is not listed.
  CLI::App* manual = app.add_subcommand("manual", "");
  auto page = std::make_shared<std::string>();
  auto schema = std::make_shared<bool>(false);
  manual->add_option("COMMAND", *page, "")->type_name("[COMMAND]");
  manual->add_flag("--schema", *schema, "the JSON schema of scene files");
  manual->callback([page, schema, &invocation] {
    invocation.action = [page, schema] { return *schema ? print_schema() : print_manual(*page); };
  });
}

}  // namespace planish::command
