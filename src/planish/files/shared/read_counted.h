#pragma once

#include "planish/core/callbacks.h"
#include "planish/files/formats.h"
#include "planish/files/shared/read_progress.h"
#include "planish/files/shared/text_encoding.h"

namespace planish {

/// What read(file) finds in the file's text, which has its warnings in front; the bytes read are
/// told.
template <class Found>
[[nodiscard]] Found read_counted(const FileBytes& file, FileFormat format,
                                 const Callbacks& callbacks, Found (*read)(const FileBytes&)) {
  TextFile text = text_file(file, format);
  ReadProgress progress(callbacks, text.file.bytes.size());
  text.file.progress = &progress;
  Found found = read(text.file);
  found.warnings.insert(found.warnings.begin(), text.warnings.begin(), text.warnings.end());
  progress.finish();
  return found;
}

}  // namespace planish
