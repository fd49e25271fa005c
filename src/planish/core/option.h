#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "planish/core/error.h"

// An option stands in one row of a table; whoever takes options (flags, scene files, headers of
// cages, C, Python, ranks) and whoever describes them (help, manuals, completions, the schema,
// stubs) goes through the rows.

namespace planish {

/// How the value of an option is written.
enum class OptionKind {
  Word,          ///< one of its words
  Words,         ///< some of them, with commas between
  Text,          ///< a text that the option reads by itself
  TextOrNumber,  ///< the same, in JSON also a number
  Whole,
  Number,
  Switch,
  Wholes,    ///< a list of them, none twice, at least one
  Numbers,   ///< the same
  Vertices,  ///< a list of vertices: in scene files only
  Edges,     ///< a list of pairs of vertices: the same
};

/// What an option decides.
enum class OptionStage {
  Input,     ///< what is read
  Shape,     ///< which surface a cage has: who verifies it has to know
  Solve,     ///< how it is found
  Points,    ///< how points become a mesh
  Fineness,  ///< how finely the surface is cut
  Output,    ///< what files hold, and what computes
};

/// Without what an option has no effect.
enum class OptionNeeds {
  Nothing,
  Points,       ///< in the input
  Faces,        ///< in the input
  Progressive,  ///< method
  Fair,         ///< method
  Tiles,        ///< among the outputs
  Step,         ///< among the outputs
  Fineness,     ///< an output that has levels, or a page
};

/// What numbers may be; those of lists, each.
struct OptionLimits {
  double least = 0, most = 0;
  bool above_least = false, below_most = false;  ///< the limit itself is outside
  std::string_view wanted;                       ///< for messages; empty: "0 to 6 is wanted"
};

/// What planish-mpi takes of an option.
struct RankRule {
  /// All; else those, with '|' between; "!WORD": all but that; empty: none.
  std::string_view words = "*";
  std::string_view remedy;  ///< what to do instead
};

/// All that can be said of an option without a value.
struct OptionInfo {
  std::string_view name;  ///< as scene files and reports have it: "max_iterations"
  OptionStage stage = OptionStage::Solve;
  OptionKind kind = OptionKind::Word;
  OptionNeeds needs = OptionNeeds::Nothing;
  OptionLimits limits{};
  std::vector<std::string_view> words{};  ///< of Word and Words
  std::string_view choices{};             ///< what stands behind the flag, where not the words
  std::string_view initial{};             ///< the default; empty: none
  std::string_view example{};             ///< where there is no default
  std::string_view help{};
  std::string_view flag{};     ///< where it is not "--name" with '-' for '_'
  std::string_view keyword{};  ///< of Python, where it is not the name
  std::string_view entry{};    ///< of lists: "level"
  std::string_view word{};     ///< that may stand instead of a list
  std::string_view pattern{};  ///< of texts: all that is taken, as a regular expression
  std::string_view joiner{};   ///< of texts: between those of a flag that may come several times
  RankRule ranks{};
};

/// "--max-iterations"
[[nodiscard]] std::string flag_of(const OptionInfo& option);
/// "doo-sabin|averaged", "N"
[[nodiscard]] std::string choices_of(const OptionInfo& option);
/// The help text with the default behind it: "give up after so many [200]".
[[nodiscard]] std::string help_of(const OptionInfo& option);

/// A value, of which the member that belongs to the kind counts.
struct OptionValue {
  std::string_view text{};  ///< of Word, Words, Text, TextOrNumber; the word instead of a list
  std::int64_t whole = 0;   ///< and of Word, once checked, the word's index
  double number = 0;
  bool is_on = false;
  std::vector<std::int64_t> wholes{};  ///< and of Vertices, of Edges two each, of Words indices
  std::vector<double> numbers{};
};

/// The value that a text stands for, as a flag or a file's header has it. Throws
/// Error{InvalidArgument}: `where`, the text and what is wanted.
[[nodiscard]] OptionValue parse_option(const OptionInfo& option, std::string_view text,
                                       std::string_view where);

/// Throws Error{InvalidArgument} for words that are none, with the nearest, for numbers outside the
/// limits and for lists that are empty or name something twice: `where` ("--weights",
/// "scene.json:3: jobs[0].weights"), the value and what is wanted. Sets the indices of words.
void check_option(const OptionInfo& option, OptionValue& value, std::string_view where);

/// A row of a table.
template <class Target>
struct Option : OptionInfo {
  /// Takes a value that is checked; may throw for what only this option knows.
  std::function<void(Target&, const OptionValue&, std::string_view where)> set;
  /// As a text that can be parsed; empty: not set. Null where there is no such text.
  std::function<std::string(const Target&)> get;
};

template <class Target>
void set_option(const Option<Target>& option, Target& target, OptionValue value,
                std::string_view where) {
  check_option(option, value, where);
  option.set(target, value, where);
}

template <class Target>
void read_option(const Option<Target>& option, Target& target, std::string_view text,
                 std::string_view where) {
  set_option(option, target, parse_option(option, text, where), where);
}

/// Sets what is given, pairs of names and texts, in the order of the table: a preset first. `spell`
/// a row: what messages call it. Throws as read_option().
template <class Target, class Given, class Spell>
void read_options(const std::vector<Option<Target>>& table, const Given& given, const Spell& spell,
                  Target& target) {
  for (const Option<Target>& option : table)
    for (const auto& [name, text] : given)
      if (name == option.name) read_option(option, target, text, spell(option));
}

/// The row of that name; null where there is none.
template <class Target>
[[nodiscard]] const Option<Target>* find_option(const std::vector<Option<Target>>& options,
                                                std::string_view name) {
  const auto found = std::ranges::find(options, name, &OptionInfo::name);
  return found == options.end() ? nullptr : &*found;
}

// Rows of the usual kinds, of a member of the target, or of a member of that, and so on.

/// whole.*first.*second ...
template <class Whole, class... Members>
[[nodiscard]] auto& member_of(Whole& whole, Members... members) {
  return (whole.*....*members);
}

/// `words` has entries with .text and .value, and lives as long as the program.
template <class Words, class Target, class Member, class... Inner>
[[nodiscard]] Option<Target> word_option(OptionInfo info, const Words& words,
                                         Member Target::*member, Inner... inner) {
  info.kind = OptionKind::Word;
  for (const auto& word : words) info.words.push_back(word.text);
  return {std::move(info),
          [&words, member, inner...](Target& target, const OptionValue& value, std::string_view) {
            member_of(target, member, inner...) =
                words[static_cast<std::size_t>(value.whole)].value;
          },
          [&words, member, inner...](const Target& target) {
            for (const auto& word : words)
              if (word.value == member_of(target, member, inner...)) return std::string(word.text);
            return std::string();
          }};
}

template <class Target, class Member, class... Inner>
[[nodiscard]] Option<Target> whole_option(OptionInfo info, Member Target::*member, Inner... inner) {
  info.kind = OptionKind::Whole;
  return {std::move(info),
          [member, inner...](Target& target, const OptionValue& value, std::string_view) {
            auto& whole = member_of(target, member, inner...);
            whole = static_cast<std::remove_reference_t<decltype(whole)>>(value.whole);
          },
          [member, inner...](const Target& target) {
            return std::to_string(member_of(target, member, inner...));
          }};
}

template <class Target, class Member, class... Inner>
[[nodiscard]] Option<Target> number_option(OptionInfo info, Member Target::*member,
                                           Inner... inner) {
  info.kind = OptionKind::Number;
  return {std::move(info),
          [member, inner...](Target& target, const OptionValue& value, std::string_view) {
            member_of(target, member, inner...) = value.number;
          },
          [member, inner...](const Target& target) {
            return shortest(member_of(target, member, inner...));
          }};
}

}  // namespace planish
