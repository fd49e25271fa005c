#include "planish/core/option.h"

#include <span>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/words.h"

namespace planish {
namespace {

std::string joined(std::span<const std::string_view> words, std::string_view separator) {
  std::string all;
  for (const std::string_view word : words)
    all += (all.empty() ? "" : std::string(separator)) + std::string(word);
  return all;
}

std::string wanted_of(const OptionInfo& option) {
  const OptionLimits& limits = option.limits;
  if (!limits.wanted.empty()) return std::string(limits.wanted);
  return formatted("{} to {} is wanted", shortest(limits.least), shortest(limits.most));
}

// Whole numbers as such: no limit is beyond 2^53.
std::string plain_limit(double limit) { return std::to_string(static_cast<std::int64_t>(limit)); }

std::string whole_wanted_of(const OptionInfo& option) {
  const OptionLimits& limits = option.limits;
  if (!limits.wanted.empty()) return std::string(limits.wanted);
  return formatted("{} to {} is wanted", plain_limit(limits.least), plain_limit(limits.most));
}

void check_whole(const OptionInfo& option, std::int64_t value, std::string_view where) {
  const auto number = static_cast<double>(value);
  if (!(number >= option.limits.least && number <= option.limits.most))
    refuse(where, "{} is out of range; {}", value, whole_wanted_of(option));
}

void check_number(const OptionInfo& option, double value, std::string_view where) {
  const OptionLimits& limits = option.limits;
  const bool low = limits.above_least ? !(value > limits.least) : !(value >= limits.least);
  const bool high = limits.below_most ? !(value < limits.most) : !(value <= limits.most);
  if (low || high) refuse(where, shortest(value) + " is out of range; " + wanted_of(option));
}

bool is_word_of_list(const OptionInfo& option, std::string_view text) {
  return !option.word.empty() && text == option.word;
}

template <class Value, class Check, class Shown>
void check_list(const OptionInfo& option, const OptionValue& value, std::span<const Value> values,
                std::string_view where, const Check& check, const Shown& shown) {
  if (is_word_of_list(option, value.text)) return;
  const std::string entry(option.entry);
  if (values.empty()) {
    const std::string_view good = option.initial.empty() ? option.example : option.initial;
    refuse(where, "no {} is named; {} is a good one", entry, good.substr(good.rfind(',') + 1));
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    check(option, values[i], where);
    if (std::ranges::find(values.first(i), values[i]) != values.begin() + static_cast<long>(i))
      refuse(where, "{} {} is named twice", entry, shown(values[i]));
  }
}

std::int64_t word_index(const OptionInfo& option, std::string_view text, std::string_view where) {
  const auto found = std::ranges::find(option.words, text);
  if (found == option.words.end()) {
    refuse(where, in_double_quotes(text) + " is not one of " + joined(option.words, ", ") +
                      did_you_mean(text, option.words));
  }
  return found - option.words.begin();
}

void check_words(const OptionInfo& option, OptionValue& value, std::string_view where) {
  value.wholes.clear();
  std::string_view rest = value.text;
  while (true) {
    const std::size_t comma = rest.find(',');
    value.wholes.push_back(word_index(option, rest.substr(0, comma), where));
    if (comma == std::string_view::npos) return;
    rest.remove_prefix(comma + 1);
  }
}

// Entries between commas, each by `parse`; false: there is one that is none.
template <class Value, class Parse>
bool parse_list(std::string_view text, std::vector<Value>& values, const Parse& parse) {
  while (true) {
    const std::size_t comma = text.find(',');
    if (!parse(text.substr(0, comma), values.emplace_back())) return false;
    if (comma == std::string_view::npos) return true;
    text.remove_prefix(comma + 1);
  }
}

}  // namespace

std::string flag_of(const OptionInfo& option) {
  if (!option.flag.empty()) return std::string(option.flag);
  std::string flag = "--" + std::string(option.name);
  std::ranges::replace(flag, '_', '-');
  return flag;
}

std::string choices_of(const OptionInfo& option) {
  if (!option.choices.empty()) return std::string(option.choices);
  return joined(option.words, option.kind == OptionKind::Words ? "," : "|");
}

std::string help_of(const OptionInfo& option) {
  std::string help(option.help);
  if (!option.initial.empty() && option.kind != OptionKind::Switch)
    help += " [" + std::string(option.initial) + "]";
  return help;
}

OptionValue parse_option(const OptionInfo& option, std::string_view text, std::string_view where) {
  OptionValue value;
  value.text = text;
  const auto no_list = [&] {
    refuse(where, "{} is no list of {}s such as {}{}", in_double_quotes(text), option.entry,
           option.example,
           option.word.empty() ? std::string() : ", and not " + std::string(option.word));
  };
  if (is_word_of_list(option, text)) return value;
  switch (option.kind) {
    case OptionKind::Word:
    case OptionKind::Words:
    case OptionKind::Text:
    case OptionKind::TextOrNumber:
      break;
    case OptionKind::Whole:
      if (!parse_integer(text, value.whole))
        refuse(where, in_double_quotes(text) + " is no whole number; " + whole_wanted_of(option));
      break;
    case OptionKind::Number:
      if (!parse_number(text, value.number))
        refuse(where, in_double_quotes(text) + " is no number; " + wanted_of(option));
      break;
    case OptionKind::Switch:
      value.is_on = text == "true";
      if (!value.is_on && text != "false")
        refuse(where, in_double_quotes(text) + " is neither true nor false");
      break;
    case OptionKind::Wholes:
      if (!parse_list(text, value.wholes, parse_integer)) no_list();
      break;
    case OptionKind::Numbers:
      if (!parse_list(text, value.numbers, parse_number)) no_list();
      break;
    case OptionKind::Vertices:
    case OptionKind::Edges:
      refuse(where, "stands in scene files only");
  }
  return value;
}

void check_option(const OptionInfo& option, OptionValue& value, std::string_view where) {
  const auto shown_whole = [](std::int64_t whole) { return std::to_string(whole); };
  switch (option.kind) {
    case OptionKind::Word:
      value.whole = word_index(option, value.text, where);
      break;
    case OptionKind::Words:
      check_words(option, value, where);
      break;
    case OptionKind::Whole:
      check_whole(option, value.whole, where);
      break;
    case OptionKind::Number:
      check_number(option, value.number, where);
      break;
    case OptionKind::Wholes:
      check_list(option, value, std::span<const std::int64_t>(value.wholes), where, check_whole,
                 shown_whole);
      break;
    case OptionKind::Numbers:
      check_list(option, value, std::span<const double>(value.numbers), where, check_number,
                 shortest);
      break;
    case OptionKind::Text:
    case OptionKind::TextOrNumber:
    case OptionKind::Switch:
    case OptionKind::Vertices:
    case OptionKind::Edges:
      break;
  }
}

}  // namespace planish
