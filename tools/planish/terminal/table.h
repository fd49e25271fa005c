#pragma once

#include <string>
#include <vector>

namespace planish::command {

enum class Align { Left, Right };

/// Text in aligned columns, two spaces between them. Widths count code points of UTF-8.
class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::Left;
  };

  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// One cell per column.
  void add_row(std::vector<std::string> cells);

  /// Titles and rows, each with a line end and no spaces before it.
  [[nodiscard]] std::string text() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace planish::command
