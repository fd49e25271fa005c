#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/formatted.h"
#include "planish/files/formats.h"
#include "planish/files/shared/read_progress.h"
#include "planish/files/shared/text_encoding.h"
#include "planish/files/sniff_format.h"

namespace planish {

/// What a failed reader of `format` says, with what the content looks like.
[[nodiscard]] inline std::string with_sniffed(const Error& error, std::span<const std::byte> bytes,
                                              FileFormat format) {
  const std::optional<FileFormat> sniffed = sniff_format(bytes);
  const auto is_number = [](FileFormat of) {  // numbers alone speak for nothing
    return of == FileFormat::Xyz || of == FileFormat::Pts || of == FileFormat::Ptx;
  };
  const bool is_other = sniffed && *sniffed != format && !is_number(*sniffed) &&
                        !(info_of(*sniffed).is_gltf && info_of(format).is_gltf);
  if (!is_other) return error.what();
  return formatted("{}; its content looks like {} (.{}): rename it, or name that as its format",
                   error.what(), info_of(*sniffed).title, info_of(*sniffed).name);
}

/// What read(file) finds in the file's text, which has its warnings in front; the bytes read are
/// told. Throws Error{UnreadableInput} for what stands in the place of a file, and says what the
/// content looks like where it cannot be read as `format`.
template <class Found>
[[nodiscard]] Found read_counted(const FileBytes& file, FileFormat format,
                                 const Callbacks& callbacks, Found (*read)(const FileBytes&)) {
  if (const std::string_view foreign = foreign_content(file.bytes); !foreign.empty())
    throw Error(ErrorCode::UnreadableInput, formatted("{}: {}", file.name, foreign));
  TextFile text = text_file(file, format);
  ReadProgress progress(callbacks, text.file.bytes.size());
  text.file.progress = &progress;
  Found found;
  try {
    found = read(text.file);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
    throw Error(error.code(), with_sniffed(error, file.bytes, format), error.element());
  }
  found.warnings.insert(found.warnings.begin(), text.warnings.begin(), text.warnings.end());
  progress.finish();
  return found;
}

}  // namespace planish
