// Parts of the file are read on all threads, then joined. Where anything is wrong the file is read
// again as one part, which knows the lines and faces that messages name.
#include "planish/files/obj/read_obj.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/files/obj/obj_names.h"
#include "planish/files/obj/obj_normals.h"
#include "planish/files/obj/obj_part.h"
#include "planish/files/shared/attribute_collector.h"
#include "planish/files/shared/split_normals.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

using Readers = std::vector<std::unique_ptr<ObjPartReader>>;

// The file made of its parts.
class ObjJoiner {
 public:
  explicit ObjJoiner(const Readers& readers) : readers_(readers) {}

  // Nothing where the file has to be read as one part, for the words of what is wrong.
  std::optional<MeshFile> join() {
    if (!number_parts() || !settle_indices()) return std::nullopt;
    file_.format = FileFormat::Obj;
    warn_of("keyword",
            [](ObjPartReader& r) -> const UnknownWord& { return r.part().unknown_keyword; });
    warn_of("tag", [](ObjPartReader& r) -> const UnknownWord& { return r.tags().unknown(); });
    warn_of_clamped_colors();
    require_indices();
    name_faces();
    gather();
    return std::move(file_);
  }

 private:
  struct Base {
    std::int64_t vertex = 0, uv = 0, face = 0, corner = 0, line = 0;
  };

  [[nodiscard]] ObjPart& part(std::size_t p) const { return readers_[p]->part(); }
  [[nodiscard]] bool is_whole() const { return readers_.size() == 1; }
  bool number_parts();
  bool settle_indices();
  template <class WordOf>
  void warn_of(const std::string& kind, const WordOf& word_of);
  void warn_of_clamped_colors();
  void require_indices() const;
  void require(const LargestIndex& largest, int base, const std::string& what,
               std::int64_t count) const;
  void name_faces();
  void gather();

  const Readers& readers_;
  std::vector<Base> bases_;  // one more than parts
  MeshFile file_;
};

bool ObjJoiner::number_parts() {
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  bases_.resize(readers_.size() + 1);
  for (std::size_t p = 0; p < readers_.size(); ++p) {
    const ObjPart& from = part(p);
    const Base& base = bases_[p];
    bases_[p + 1] = {base.vertex + from.mesh.vertex_count(),
                     base.uv + static_cast<std::int64_t>(from.uvs.size()),
                     base.face + from.mesh.face_count(),
                     base.corner + static_cast<std::int64_t>(from.mesh.face_vertices.size()),
                     base.line + from.line_count};
  }
  const Base& all = bases_.back();
  return is_whole() || std::max({all.vertex, all.uv, all.face, all.corner}) < kMost;
}

// Indices counted backwards, and where each part's faces begin.
bool ObjJoiner::settle_indices() {
  std::atomic<bool> sound{true};
  parallel_for(readers_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      PolygonMesh& mesh = part(p).mesh;
      const auto settle = [&](std::vector<std::int32_t>& indices,
                              std::span<const std::size_t> places, std::int64_t base) {
        for (const std::size_t place : places) {
          const std::int64_t index = indices[place] + base;
          if (index < 0) sound.store(false, std::memory_order_relaxed);
          indices[place] = static_cast<std::int32_t>(index);
        }
      };
      settle(mesh.face_vertices, part(p).backward_vertices, bases_[p].vertex);
      settle(mesh.face_uvs, part(p).backward_uvs, bases_[p].uv);
      for (std::int32_t& offset : mesh.face_offsets)
        offset = static_cast<std::int32_t>(offset + bases_[p].corner);
    }
  });
  const auto fits = [&](const auto& largest_of, std::int64_t count) {
    return std::ranges::all_of(readers_, [&](const std::unique_ptr<ObjPartReader>& reader) {
      return largest_of(*reader).index < count;
    });
  };
  const Base& all = bases_.back();
  return is_whole() ||
         (sound.load() &&
          fits([](ObjPartReader& r) { return r.part().largest_vertex; }, all.vertex) &&
          fits([](ObjPartReader& r) { return r.part().largest_uv; }, all.uv) &&
          fits([](ObjPartReader& r) { return r.tags().largest_vertex(); }, all.vertex) &&
          fits([](ObjPartReader& r) { return r.tags().largest_face(); }, all.face));
}

template <class WordOf>
void ObjJoiner::warn_of(const std::string& kind, const WordOf& word_of) {
  std::int64_t count = 0, line = 0;
  std::string name;
  for (std::size_t p = 0; p < readers_.size(); ++p) {
    const UnknownWord& unknown = word_of(*readers_[p]);
    if (count == 0 && unknown.count > 0) {
      line = bases_[p].line + unknown.line;
      name = unknown.name;
    }
    count += unknown.count;
  }
  if (count == 0) return;
  const std::string what = "unknown " + kind + " " + name;
  if (bases_.back().vertex == 0)
    readers_.front()->lines().fail_at(line,
                                      what + " in a file without vertices: this is no OBJ file");
  file_.warnings.push_back(
      {.code = "unknown-" + kind,
       .message = "line " + std::to_string(line) + ": " + what + "; such lines are ignored",
       .count = count});
}

void ObjJoiner::warn_of_clamped_colors() {
  std::int64_t count = 0;
  for (std::size_t p = 0; p < readers_.size(); ++p) count += part(p).clamped_colors;
  if (count == 0) return;
  file_.warnings.push_back(
      {.code = "clamped-colors",
       .message = std::to_string(count) + " vertex colours lie outside 0 to 1 and are clamped",
       .count = count});
}

void ObjJoiner::require(const LargestIndex& largest, int base, const std::string& what,
                        std::int64_t count) const {
  if (largest.index < count) return;
  readers_.front()->lines().fail_at(
      largest.line, what + std::to_string(largest.index + base) + " of " + std::to_string(count),
      largest.element);
}

// Of a file in one part; of others settle_indices() has seen it. Faces count from 1, tags from 0.
void ObjJoiner::require_indices() const {
  if (!is_whole()) return;
  const Base& all = bases_.back();
  require(part(0).largest_vertex, 1, "face names vertex ", all.vertex);
  require(part(0).largest_uv, 1, "face names texture coordinate ", all.uv);
  require(readers_.front()->tags().largest_vertex(), 0, "tag names vertex ", all.vertex);
  require(readers_.front()->tags().largest_face(), 0, "tag names face ", all.face);
}

// Groups hold until the next, across parts.
void ObjJoiner::name_faces() {
  AttributeCollector attributes;
  ObjNames names;
  std::int64_t named = 0;
  const auto add_faces_to = [&](std::int64_t face) {
    attributes.add_faces(static_cast<std::size_t>(face - named));
    named = face;
  };
  for (std::size_t p = 0; p < readers_.size(); ++p) {
    for (const ObjPart::Naming& naming : part(p).namings) {
      add_faces_to(bases_[p].face + naming.faces_before);
      names.take(naming);
      attributes.use_group(names.face_group());
    }
  }
  add_faces_to(bases_.back().face);
  attributes.finish({}, file_.mesh);
}

void ObjJoiner::gather() {
  PolygonMesh& mesh = file_.mesh;
  for (std::size_t p = 0; p < readers_.size(); ++p) {
    ObjPart& from = part(p);
    const auto append = [](auto& to, const auto& values) {
      to.insert(to.end(), values.begin(), values.end());
    };
    append(file_.header, from.header);
    append(mesh.creases, from.mesh.creases);
    append(mesh.corners, from.mesh.corners);
    append(mesh.hole_faces, from.mesh.hole_faces);
    file_.dropped_element_count += from.dropped_element_count;
  }
  const Base& all = bases_.back();
  // What a part has fewer of than its vertices or corners is filled up.
  const auto join_filled = [&](auto& to, auto member, const auto& filler,
                               std::int64_t Base::*base) {
    const bool any = std::ranges::any_of(
        readers_, [&](const auto& reader) { return !(reader->part().mesh.*member).empty(); });
    if (!any) return;
    to.reserve(static_cast<std::size_t>(all.*base));
    for (std::size_t p = 0; p < readers_.size(); ++p) {
      auto& values = part(p).mesh.*member;
      to.insert(to.end(), values.begin(), values.end());
      to.resize(static_cast<std::size_t>(bases_[p + 1].*base), filler);
    }
  };
  const auto join_all = [&](auto& to, auto member, std::ptrdiff_t skipped, std::int64_t count) {
    to.reserve(static_cast<std::size_t>(count));
    for (std::size_t p = 0; p < readers_.size(); ++p) {
      auto& values = part(p).mesh.*member;
      to.insert(to.end(), values.begin() + skipped, values.end());
      values = {};
    }
  };
  const std::array<std::function<void()>, 6> tasks = {
      [&] { join_all(mesh.positions, &PolygonMesh::positions, 0, all.vertex); },
      [&] { join_all(mesh.face_vertices, &PolygonMesh::face_vertices, 0, all.corner); },
      [&] { join_all(mesh.face_offsets, &PolygonMesh::face_offsets, 1, all.face + 1); },
      [&] { join_filled(mesh.face_uvs, &PolygonMesh::face_uvs, -1, &Base::corner); },
      [&] {
        join_filled(mesh.colors, &PolygonMesh::colors, kNoObjColor, &Base::vertex);
        std::ranges::replace(mesh.colors, kNoObjColor, glm::vec4(1.0f));
      },
      [&] {
        mesh.uvs.reserve(static_cast<std::size_t>(all.uv));
        for (std::size_t p = 0; p < readers_.size(); ++p)
          mesh.uvs.insert(mesh.uvs.end(), part(p).uvs.begin(), part(p).uvs.end());
      }};
  if (is_whole()) {
    ObjPart& whole = part(0);
    mesh.positions = std::move(whole.mesh.positions);
    mesh.face_vertices = std::move(whole.mesh.face_vertices);
    mesh.face_offsets = std::move(whole.mesh.face_offsets);
    for (std::size_t i = 3; i < tasks.size(); ++i) tasks[i]();
  } else {
    parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) tasks[i]();
    });
  }
  // Coordinates that no corner names are dropped.
  if (mesh.face_uvs.empty()) mesh.uvs = {};
}

std::optional<MeshFile> read_parts(const std::vector<TextLines>& parts) {
  Readers readers(parts.size());
  if (parts.size() == 1) {
    readers.front() = std::make_unique<ObjPartReader>(parts.front(), /*is_first=*/true);
    readers.front()->read();
    return ObjJoiner(readers).join();
  }
  std::atomic<bool> readable{true};
  parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end && readable.load(std::memory_order_relaxed); ++p) {
      readers[p] = std::make_unique<ObjPartReader>(parts[p], p == 0);
      try {
        readers[p]->read();
      } catch (const Error&) {
        readable.store(false, std::memory_order_relaxed);
      }
    }
  });
  return readable.load() ? ObjJoiner(readers).join() : std::nullopt;
}

}  // namespace

MeshFile read_obj(const FileBytes& file) {
  MeshFile found = read_obj(file.bytes, file.name);
  const bool is_cloud = found.mesh.face_count() == 0 && !found.mesh.positions.empty();
  if (!is_cloud && !file.split_normals_crease) return found;
  CornerNormals normals = read_obj_normals(file.bytes, file.name);
  if (is_cloud) {
    if (normals.values.size() == found.mesh.positions.size())
      found.normals = std::move(normals.values);
    return found;
  }
  weld_repeated_vertices(found);
  mark_split_normals(found.mesh, normals);
  return found;
}

MeshFile read_obj(std::span<const std::byte> bytes, std::string_view name) {
  constexpr std::size_t kPartBytes = std::size_t{1} << 20;
  return read_obj_in_parts(bytes, name, kPartBytes);
}

MeshFile read_obj_in_parts(std::span<const std::byte> bytes, std::string_view name,
                           std::size_t part_bytes) {
  const TextLines whole(bytes, name, TextLines::Continuation::Backslash);
  const std::vector<TextLines> parts = whole.cut(part_bytes);
  if (parts.size() > 1) {
    if (std::optional<MeshFile> file = read_parts(parts)) return *std::move(file);
  }
  // Numbers of lines and of faces, as messages say them, are known from the beginning only.
  return *read_parts({whole});
}

}  // namespace planish
