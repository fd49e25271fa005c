#include "planish/distributed/staged_tileset.h"

#include <system_error>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/rename_file.h"
#include "planish/files/tiles/write_tiles.h"

namespace planish {

namespace fs = std::filesystem;

StagedTileset::StagedTileset(const Ranks& ranks, fs::path document, bool resume, bool replaces)
    : ranks_(ranks), document_(std::move(document)), replaces_(replaces) {
  part_ = document_.parent_path() / formatted(".{}.part", document_.filename().string());
  agree(ranks_, [&] {
    if (ranks_.rank != 0) return;
    std::error_code error;
    if (!resume) fs::remove_all(part_, error);
    for (const fs::path& folder : {tile_folder(this->document()), records()}) {
      if (!error) fs::create_directories(folder, error);
      if (error)
        throw Error(ErrorCode::UnwritableOutput, document_.string() + ": cannot make " +
                                                     folder.string() + ": " + error.message());
    }
  });
}

StagedTileset::~StagedTileset() {
  std::error_code ignored;
  if (ranks_.rank == 0) fs::remove_all(part_, ignored);
}

void StagedTileset::move_into_place() const {
  const auto require = [&](const std::error_code& error) {
    if (error)
      throw Error(ErrorCode::UnwritableOutput,
                  document_.string() + ": cannot be put in place: " + error.message());
  };
  const fs::path folder = tile_folder(document_), own_folder = tile_folder(document());
  if (replaces_) {
    std::error_code ignored;
    for (const fs::path& old : {document_, folder})
      if (fs::exists(fs::symlink_status(old, ignored)))
        require(rename_file(old, part_ / (old.filename().string() + ".replaced"), true));
  }
  require(rename_file(own_folder, folder, true));  // of folders only an empty one is replaced
  const std::error_code error = rename_file(document(), document_, replaces_);
  if (error) (void)rename_file(folder, own_folder, true);
  require(error);
}

void StagedTileset::commit() {
  agree(ranks_, [&] {
    if (ranks_.rank == 0) move_into_place();
  });
}

}  // namespace planish
