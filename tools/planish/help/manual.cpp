#include "help/manual.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

#include "planish/core/version.h"

namespace planish::command {
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

}  // namespace planish::command
