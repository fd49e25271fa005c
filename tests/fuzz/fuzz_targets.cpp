#include "fuzz/fuzz_targets.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <future>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/fuzz_read.h"
#include "inspect_command.h"
#include "limit/limit_case.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/materials.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/job/job_text.h"
#include "planish/job/page/page.h"
#include "planish/mesh/check.h"
#include "query_command.h"
#include "scene_file.h"
#include "support/files.h"

// What the command reads, and says of it; the format says nothing of most. All abort as those of
// fuzz_read.h do.

namespace planish::test {
namespace {

// What a browser makes of it; references are of one decimal number.
std::string without_references(std::string_view html) {
  std::string text;
  while (!html.empty()) {
    const bool is_reference = html.starts_with("&#");
    const std::size_t end = is_reference ? html.find(';') : 0;
    require(end != std::string_view::npos && html.front() != '<' && html.front() != '>' &&
            html.front() != '"' && html.front() != '\'' && html.front() != '`' &&
            (is_reference || html.front() != '&'));
    text += is_reference ? static_cast<char>(std::stoi(std::string(html.substr(2, end - 2))))
                         : html.front();
    html.remove_prefix(end + 1);
  }
  return text;
}

// What a shell makes of it.
std::string without_quotes(std::string_view word) {
  std::string text;
  bool is_quoted = false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (word[i] == '\'') {
      is_quoted = !is_quoted;
    } else if (word[i] == '\\' && !is_quoted) {
      require(++i < word.size());
      text += word[i];
    } else {
      require(is_quoted || std::string_view(" \t\n;&|<>()$`\"*?[]#~!{}\\").find(word[i]) ==
                               std::string_view::npos);
      text += word[i];
    }
  }
  require(!is_quoted);
  return text;
}

// A scene file: jobs, or a refusal in which everything can be seen.
void fuzz_read_scene(std::span<const std::byte> bytes, FileFormat) {
  try {
    for (const Job& job : command::parse_scene(text_of(bytes), "fuzz.json", "/folder"))
      require(!job.name.empty() && !job.input.empty());
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::InvalidArgument});
  }
}

// The header of a cage, which says again what was read of it.
void fuzz_read_cage(std::span<const std::byte> bytes, FileFormat format) {
  try {
    const MeshFile file = read_mesh(bytes, "fuzz", format);
    const CageHeader header = parse_cage_header(file.header, "fuzz");
    const auto written = [](const CageHeader& of) {
      const bool is_fair = of.settings.interpolation == InterpolationChoice::Fair;
      return cage_header_lines(
          of.settings, is_fair ? InterpolationMethod::Fair : InterpolationMethod::Progressive,
          of.source, of.found.value_or(FoundCreases()));
    };
    const std::vector<std::string> lines = written(header);
    for (const std::string& line : lines) require(line.find('\n') == std::string::npos);
    require(written(parse_cage_header(lines, "fuzz")) == lines);
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::UnreadableInput});
  }
}

// A name on its way into messages, JSON, HTML and shells: it stays within its place, and says
// there what it said.
void fuzz_write_text(std::span<const std::byte> bytes, FileFormat) {
  const std::string_view text = text_of(bytes);
  const std::string message = visible(text), shown = visible_text(text);
  require(visible(message) == message);
  require(visible_text(shown) == shown);
  require(without_references(html_text(text)) == shown);
  std::string lines;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (begin > 0) lines += '\n';
    lines += visible_text(text.substr(begin, end - begin));
    begin = end + 1;
  }
  require(without_references(html_lines(text)) == lines);
  require(without_quotes(shell_word(text)) == text);
  const nlohmann::ordered_json given = {{std::string(text), {std::string(text), 1, nullptr}}};
  const nlohmann::ordered_json seen = visible_json(given);
  for (const nlohmann::ordered_json* value : {&given, &seen}) {
    const std::string script = script_json(*value);
    for (const char c : script) require(c >= ' ' && c <= '~' && c != '<' && c != '>' && c != '&');
    const nlohmann::ordered_json parsed = nlohmann::ordered_json::parse(script);
    if (value == &seen) require(parsed == seen);
  }
}

// A small surface to ask, with a sharp edge and borders, and places on it.
struct Asked {
  LimitCase surface{interpolating_cage(with_random_creases(open_fan(5), 0.3, 1))};
  SurfaceQueries queries{surface.limit};
  RawVector<glm::dvec3> places = surface.tessellated(3).positions;
};

const Asked& asked() {
  static const Asked surface;
  return surface;
}

// Rounding, of a distance that large.
double slack(double distance) { return 1e-9 * (1 + distance); }

void require_on_surface(const command::QueryAnswer& answer) {
  const SurfacePoint there = asked().surface.limit.evaluate(answer.at);
  require(safe_length(there.position - answer.position) <= slack(0));
  require(std::abs(safe_length(answer.normal) - 1) <= slack(0));
}

// No place of the surface is nearer.
void require_closest(const glm::dvec3& point, const command::QueryAnswer& answer) {
  require_on_surface(answer);
  const double distance = answer.distance;
  require(std::abs(safe_length(point - answer.position) - distance) <= slack(distance));
  for (const glm::dvec3& place : asked().places)
    require(distance <= safe_length(point - place) + slack(distance));
}

void require_hit(const glm::dvec3& origin, const glm::dvec3& direction,
                 const command::QueryAnswer& answer) {
  if (answer.at.face < 0) return;
  require_on_surface(answer);
  require(answer.distance >= 0 && std::isfinite(answer.distance));
  const glm::dvec3 reached = origin + answer.distance * direction;
  require(safe_length(reached - answer.position) <= slack(safe_length(origin)));
}

using Answers = std::vector<command::QueryAnswer>;

Answers answers_to(std::span<const glm::dvec3> points, const std::string& rays) {
  Answers answers(points.size());
  if (rays.empty()) {
    command::answer_closest(asked().queries, points, true, answers);
    for (std::size_t i = 0; i < points.size(); ++i) require_closest(points[i], answers[i]);
  } else {
    const glm::dvec3 direction = command::parse_direction(rays);
    command::answer_rays(asked().queries, direction, points, answers);
    for (std::size_t i = 0; i < points.size(); ++i) require_hit(points[i], direction, answers[i]);
  }
  return answers;
}

// JSON and PLY have an answer for each point, and the PLY can be asked again.
void require_written(std::span<const glm::dvec3> points, const Answers& given, bool are_rays) {
  const char* const distance = are_rays ? "t" : "distance";
  const command::Answer answer = [&](std::span<const glm::dvec3>,
                                     std::span<command::QueryAnswer> answers) {
    std::ranges::copy(given, answers.begin());
  };
  std::string text;
  const command::TakeBytes take = [&](std::string_view bytes) { text += bytes; };
  command::answers_json(nlohmann::ordered_json::object(), "closest", points, answer, distance,
                        take);
  const nlohmann::json json = nlohmann::json::parse(text)["closest"];
  require(json.size() == points.size());
  for (const nlohmann::json& entry : json)
    require(entry.is_null() ? are_rays : entry[distance].is_number());
  text.clear();
  command::answers_ply(points, answer, distance, take);
  const PointCloud cloud = read_points(std::as_bytes(std::span(text)), "answers", FileFormat::Ply);
  require(cloud.points.size() == points.size() && cloud.missing_count == 0);
}

// A line with the direction of rays, or an empty one, and a file of points: what `query` reads and
// answers. No place of the surface is nearer, hits lie on ray and surface, and the answers can be
// read.
void fuzz_query(std::span<const std::byte> bytes, FileFormat format) {
  constexpr std::size_t kMostPoints = 32;
  const std::string_view text = text_of(bytes);
  const std::string rays(text.substr(0, text.find('\n')));
  try {
    const auto file = bytes.subspan(std::min(rays.size() + 1, bytes.size()));
    std::vector<glm::dvec3> points =
        command::questions_of(read_points(file, "fuzz", format), "fuzz");
    points.resize(std::min(points.size(), kMostPoints));
    require_written(points, answers_to(points, rays), !rays.empty());
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::UnreadableInput, ErrorCode::InvalidArgument});
  }
}

// What `inspect` says of standard input, whose format it tells by the content.
void fuzz_inspect(std::span<const std::byte> bytes, FileFormat) {
  const std::optional<FileFormat> format = sniff_format(bytes);
  if (!format) return;
  InputFile file;
  file.name = "fuzz";
  file.bytes.assign(bytes.begin(), bytes.end());
  file.format = *format;
  file.digest = std::async(std::launch::deferred, [] { return std::string("none"); });
  try {
    const command::Inspection inspection = command::inspect(file);
    const std::string text = command::inspection_text(inspection);
    require(visible_lines(text) == text);
    require(std::isfinite(inspection.diagonal) && std::isfinite(inspection.spacing));
    const nlohmann::json json =
        nlohmann::json::parse(json_text(command::inspection_json(inspection)));
    require(json["format"] == name_of(inspection.format));
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::UnreadableInput});
  }
}

void require_usable(const AssetMesh& mesh, std::int64_t corner_count) {
  require(static_cast<std::int64_t>(mesh.file.mesh.face_vertices.size()) <= 3 * corner_count);
  for (const MeshProblem& problem : check(mesh.file.mesh))
    require(problem.kind != MeshProblemKind::IndexOutOfRange &&
            problem.kind != MeshProblemKind::NonFinitePosition);
  require_visible(mesh.file.warnings);
}

// Each image has its place in the list, and all of it can be written.
void require_writable(const GltfMaterials& materials) {
  require(!materials.lists.contains("images") ||
          materials.lists["images"].size() == materials.images.size());
  (void)materials.lists.dump();
  require_visible(materials.warnings);
}

}  // namespace

void fuzz_read_asset(std::span<const std::byte> bytes, FileFormat format) {
  const FileBytes file{.bytes = bytes, .name = "fuzz", .path = {}};
  std::unique_ptr<const GltfAsset> asset;
  try {
    asset = asset_of(file, format);
    if (asset) (void)contents_of(*asset);
    if (asset) require_writable(materials_of(*asset));
    if (asset) (void)asset->byte_count();
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::UnreadableInput});
  }
  if (!asset) return;
  // One that cannot be read does not keep others from it.
  for (const std::int64_t number : asset->surfaces()) {
    try {
      (void)asset->may_be_scaled(number);
      require_usable(asset->read(number), asset->corner_count(number));
    } catch (const Error& error) {
      require_refusal(error, {ErrorCode::UnreadableInput});
    }
  }
}

void fuzz_read_mtl(std::span<const std::byte> bytes, FileFormat) {
  static const TemporaryFolder folder;
  const std::filesystem::path obj = folder.path() / "fuzz.obj";
  if (!std::filesystem::exists(obj)) std::ofstream(obj) << "mtllib fuzz.mtl\n";
  std::ofstream(folder.path() / "fuzz.mtl", std::ios::binary) << text_of(bytes);
  const MaterialLibrary library(obj);
  require_visible(library.warnings());
  for (const std::string& name : library.names()) {
    for (const MaterialStatement& statement : library.parsed(name)) {
      for (const double number : statement.numbers) require(std::isfinite(number));
      const MaterialTexture& texture = statement.texture;
      for (const double number :
           {texture.size.x, texture.size.y, texture.offset.x, texture.offset.y, texture.scale})
        require(std::isfinite(number));
    }
    const std::string moved = library.statements(name, folder.path().parent_path());
    require(moved.empty() || moved.ends_with('\n'));
  }
  const GltfMaterials materials = materials_of(library);
  require_writable(materials);
  const UsdMaterials usd = usd_materials(materials, library.names(), folder.path());
  require_visible(usd.warnings);
  for (const char c : usd.text) require(c == '\n' || c == '\t' || c < '\0' || c >= ' ');
}

std::vector<FuzzTarget> fuzz_targets() {
  std::vector<FuzzTarget> targets;
  std::vector<std::string> files;
  const auto add_format = [&](const std::string& name, FileFormat format, auto* read) {
    targets.push_back({name, format, read, {name}});
    files.push_back(name);
  };
  for (const FormatInfo& info : formats()) {
    const std::string name(info.name);
    if (info.read_mesh) add_format(name, info.format, fuzz_read_mesh);
    if (info.read_points) add_format("points_" + name, info.format, fuzz_read_points);
  }
  targets.insert(targets.end(), {{"draco", FileFormat::Glb, fuzz_read_draco, {"draco"}},
                                 {"meshopt", FileFormat::Glb, fuzz_read_meshopt, {"meshopt"}},
                                 {"lzf", FileFormat::Pcd, fuzz_read_lzf, {"lzf"}},
                                 {"asset_glb", FileFormat::Glb, fuzz_read_asset, {"glb"}},
                                 {"asset_gltf", FileFormat::Gltf, fuzz_read_asset, {"gltf"}},
                                 {"mtl", FileFormat::Obj, fuzz_read_mtl, {"mtl"}},
                                 {"scene", FileFormat::Obj, fuzz_read_scene, {"scene"}},
                                 {"cage", FileFormat::Obj, fuzz_read_cage, {"cage"}},
                                 {"text", FileFormat::Obj, fuzz_write_text, {"text"}},
                                 {"query", FileFormat::Xyz, fuzz_query, {"query"}},
                                 {"inspect", FileFormat::Obj, fuzz_inspect, files}});
  return targets;
}

}  // namespace planish::test
