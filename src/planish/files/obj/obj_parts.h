#pragma once

#include <cstddef>
#include <functional>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/obj/obj_part.h"
#include "planish/files/shared/first_failure.h"

namespace planish {

/// The parts of an OBJ file, or of a range of one, read side by side. A part does not know what
/// stands before it; one for which that matters is read again when it is known.
class ObjParts {
 public:
  /// Calls use(lines) with the lines of a part; from several threads at once.
  using LinesOf =
      std::function<void(std::size_t part, const std::function<void(const TextLines&)>& use)>;

  /// Reads `count` parts on all threads; `is_start`: the first is the beginning of the file.
  ObjParts(std::size_t count, LinesOf lines_of, bool is_start);

  /// Of the parts before the first that is wrong.
  [[nodiscard]] ObjCounts counts() const;
  /// All parts as one, whose indices, lines of notes and elements count from the file's beginning
  /// and whose offsets and namings from its own. Throws Error{UnreadableInput} as reading the file
  /// from its beginning on would. Once only.
  [[nodiscard]] ObjPart join(const ObjCounts& before);

 private:
  void read_again(std::size_t part, const ObjCounts& before);
  void settle(const std::vector<ObjCounts>& before);
  void gather_notes(const std::vector<ObjCounts>& before, ObjPart& all) const;
  void gather(const std::vector<ObjCounts>& before, ObjPart& all);

  LinesOf lines_of_;
  std::vector<ObjPart> parts_;
  FirstFailure failure_;
};

/// Throws Error{UnreadableInput} for a file of unknown words without vertices, and for faces and
/// tags that name what the file with these counts has not; texture coordinates are noted, unless
/// the file is strict.
void require_obj(ObjPart& part, const ObjCounts& all, const TextLines& lines);

/// The warnings of all notes.
void warn_of(const ObjPart& part, std::string_view name, std::vector<Warning>& warnings);

}  // namespace planish
