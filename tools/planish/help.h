#pragma once

#include <map>
#include <string>
#include <vector>

namespace CLI {

class App;

}  // namespace CLI

namespace planish::command {

/// What CLI11's tree of options cannot hold of a command's help.
struct CommandText {
  std::vector<std::string> examples;     ///< whole lines
  std::vector<std::string> first_flags;  ///< long names that -h shows; empty: all of them
  std::string notes;                     ///< paragraphs for the end of the long help
};

/// By the command's name; "" is planish itself.
using CommandTexts = std::map<std::string, CommandText>;

struct HelpOption {
  std::vector<std::string> names;    ///< "-o", "--output"; of an argument without dashes, "INPUT"
  std::string value;                 ///< "FILE", "auto|cpu"; empty for a switch
  std::vector<std::string> choices;  ///< the words of `value` where there are some
  bool takes_several = false;        ///< of the choices, with commas between
  std::string text;
  bool is_first = false;  ///< belongs into the short help
  bool takes_file = false;
};

struct HelpTopic {
  std::string title;
  std::vector<HelpOption> options;
};

/// All that help texts, man pages and completions say of a command: the only source is the tree of
/// options that parses the arguments, and its CommandText.
struct HelpPage {
  std::string program;  ///< "planish"
  std::string name;     ///< "fit"; empty: the program itself
  std::string summary;
  std::vector<HelpOption> arguments;  ///< positional
  std::vector<HelpTopic> topics;
  std::vector<HelpPage> commands;  ///< of the program itself
  CommandText text;

  [[nodiscard]] std::string full_name() const {
    return name.empty() ? program : program + " " + name;
  }
  /// "planish fit [FLAGS] INPUT..."
  [[nodiscard]] std::string usage() const;
};

/// The page of a program with those of its commands. Commands without a description are for the
/// build and left out.
[[nodiscard]] HelpPage help_page(const CLI::App& app, const CommandTexts& texts);

/// One screen: usage, the flags that come first, examples. No line is longer than `columns`
/// (at least 40), file names in examples excepted.
[[nodiscard]] std::string short_help(const HelpPage& page, int columns);

/// All flags by topic, examples and notes.
[[nodiscard]] std::string long_help(const HelpPage& page, int columns);

/// "planish: what it is", its commands and one example: the answer to `planish` alone.
[[nodiscard]] std::string overview(const HelpPage& page, int columns);

/// Text cut into lines of at most `columns` at blanks, those after the first begun with `indent`.
[[nodiscard]] std::string wrapped(const std::string& text, int columns, int indent);

/// The manual page (roff, section 1) of a program or of one of its commands, of `help`, the page of
/// the program with all of them.
[[nodiscard]] std::string manual_page(const HelpPage& page, const HelpPage& help);

}  // namespace planish::command
