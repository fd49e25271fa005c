#include "help/completion.h"

#include "planish/core/formatted.h"

namespace planish::command {
namespace {

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

}  // namespace

std::optional<Shell> shell_of(std::string_view name) {
  if (name == "bash") return Shell::Bash;
  if (name == "zsh") return Shell::Zsh;
  if (name == "fish") return Shell::Fish;
  return std::nullopt;
}

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

}  // namespace planish::command
