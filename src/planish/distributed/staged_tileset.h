#pragma once

#include <filesystem>

#include "planish/distributed/messages.h"

namespace planish {

/// A set of tiles that all ranks write and that appears whole or not at all: into a hidden folder
/// beside it, `.NAME.part`, which rank 0 moves when all agree that everything is there. Every
/// function is called by all ranks and throws AgreedError{UnwritableOutput} naming the path.
class StagedTileset {
 public:
  /// Removes what an ended job may have left of it, unless it is to be resumed. Without `replaces`
  /// a document and a folder with something in it that stand there when commit() is called stay,
  /// and commit() throws.
  StagedTileset(const Ranks& ranks, std::filesystem::path document, bool resume,
                bool replaces = true);
  /// Removes what was not committed.
  ~StagedTileset();
  StagedTileset(const StagedTileset&) = delete;
  StagedTileset& operator=(const StagedTileset&) = delete;

  /// Where to write the document, its tiles beside it, and what is known of blocks.
  [[nodiscard]] std::filesystem::path document() const { return part_ / document_.filename(); }
  [[nodiscard]] std::filesystem::path records() const { return part_ / "records"; }

  /// The old document goes first, then its folder, then the new folder comes, then the document:
  /// whatever ends the process, a document is in place only while its folder is.
  void commit();

 private:
  void move_into_place() const;

  const Ranks& ranks_;
  std::filesystem::path document_, part_;
  bool replaces_;
};

}  // namespace planish
