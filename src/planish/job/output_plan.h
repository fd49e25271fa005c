#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "planish/files/formats.h"
#include "planish/files/mesh_file.h"
#include "planish/job/job_settings.h"

namespace planish {

enum class OutputKind { Surface, Cage };

/// One output as asked for. A surface of several levels becomes several files.
struct OutputRequest {
  std::string path;  ///< "-": a GLB to stdout
  OutputKind kind = OutputKind::Surface;
  std::vector<int> levels;   ///< of a surface
  bool by_density = false;   ///< less where the mesh is dense
  AdaptiveChoice adaptive;   ///< instead of levels, where there is any
  std::string where;         ///< for messages: "-o" or "scene.json: jobs[0].outputs[1]"
  bool lods_in_one = false;  ///< levels of detail are in one file
};

/// How fine a surface is: a level, or what its triangles keep.
struct Fineness {
  int level = 0;                      ///< 1 where one of the others is given
  double chord_error = 0, angle = 0;  ///< see AdaptiveOptions
  bool by_density = false;            ///< a level that nobody named
  DecimationTarget target{};          ///< of decimate()

  [[nodiscard]] bool is_adaptive() const { return chord_error > 0 || angle > 0 || target.any(); }
  friend bool operator==(const Fineness& a, const Fineness& b) {
    return a.level == b.level && a.chord_error == b.chord_error && a.angle == b.angle &&
           a.target == b.target;
  }
};

/// What a mesh settles.
struct MeshFineness {
  int level = 2;        ///< MeshDensity::level(), or one of its own
  double share = 1;     ///< of the triangles of a file, those of the mesh
  bool is_own = false;  ///< a level that takes the place of all
};
[[nodiscard]] Fineness settled(Fineness fineness, const MeshFineness& mesh);

/// "level 2", "chord error 0.001", "angle 10", "chord error 0.001 and angle 10", "at most 500
/// faces", "edges of 0.1", "distance 0.001".
[[nodiscard]] std::string fineness_text(const Fineness& fineness);
/// The same of levels of detail in one file: "level 2 and level 1, level 0 as levels of detail".
[[nodiscard]] std::string finenesses_text(const Fineness& finest,
                                          const std::vector<Fineness>& coarser);
/// A length that it leaves out, to be compared with others of its kind.
[[nodiscard]] double left_out_by(const Fineness& fineness);

/// One file to be written.
struct PlannedOutput {
  std::filesystem::path path;
  OutputKind kind = OutputKind::Surface;
  FileFormat format = FileFormat::Glb;
  Fineness fineness;  ///< of a surface
  bool to_stdout = false;
  std::vector<Fineness> coarser{};  ///< levels of detail of the same file, each than the one before

  [[nodiscard]] std::vector<Fineness> finenesses() const {
    std::vector<Fineness> all{fineness};
    all.insert(all.end(), coarser.begin(), coarser.end());
    return all;
  }
};

struct PathRules {
  bool overwrite = false;           ///< existing files may be replaced
  bool create_folders = false;      ///< missing folders are made when files are written
  bool only_note = false;           ///< what cannot be written is noted, not thrown: for a dry run
  bool stdout_is_terminal = false;  ///< which takes only text
};

/// All paths of a process, so that no file is written twice, or over an input or what that names:
/// whatever flags say, nobody wants that. One rule for what an
/// output meets on the disk: a file that exists, a folder in its place, a folder that is missing or
/// not writable are all Error{UnwritableOutput}. What is wrong with the request itself (written
/// twice, over the input) is Error{InvalidArgument}.
class PathClaims {
 public:
  explicit PathClaims(PathRules rules) : rules_(rules) {}

  [[nodiscard]] bool overwrites() const { return rules_.overwrite; }
  [[nodiscard]] bool stdout_is_terminal() const { return rules_.stdout_is_terminal; }

  /// See InputFiles.
  void add_input(const std::filesystem::path& path, std::optional<FileFormat> format = {},
                 FileReach reach = FileReach::Beside);
  void add_inputs(const InputFiles& inputs) { inputs_ = inputs; }
  /// "-" claims stdout, which may be a terminal only for text. Throws as above. Only looks, creates
  /// nothing.
  /// `format`: of a surface or cage, with all that goes beside it.
  void add_output(const std::filesystem::path& path, std::string_view where,
                  std::optional<FileFormat> format = {});
  /// The folder of a tile set. One that exists may only be replaced where it holds nothing but
  /// what a tile set does. Throws as above.
  void add_tile_folder(const std::filesystem::path& folder, std::string_view where);
  /// A report: a path that ends in .json, or "-".
  void add_report(const std::filesystem::path& path, std::string_view where);
  /// A page: a path that ends in .html or .htm, or "-" where that is no terminal.
  void add_page(const std::filesystem::path& path, std::string_view where);

  /// Why the path would be refused; empty where it would not, or where nothing is only noted.
  [[nodiscard]] std::string refusal(const std::filesystem::path& path) const;
  [[nodiscard]] bool any_refused() const { return !refusals_.empty(); }

 private:
  void refuse_place(const std::filesystem::path& path, std::string_view where,
                    const std::string& what);
  void check_folder(const std::filesystem::path& path, std::string_view where);

  PathRules rules_;
  InputFiles inputs_;
  std::set<std::filesystem::path> outputs_;
  std::map<std::filesystem::path, std::string> refusals_;
};

/// Refuses a path of a page that is no .html or .htm with Error{InvalidArgument} naming `where`.
void require_page_path(const std::filesystem::path& path, std::string_view where);

/// The files that a request becomes: NAME.glb, or NAME_LOD0.glb, NAME_LOD1.glb... in the order of
/// the levels; with lods_in_one NAME.glb alone, from fine to coarse. Claims each. Throws as
/// PathClaims, and Error{InvalidArgument} for an extension that is not written, several levels to
/// stdout or bytes to a terminal.
[[nodiscard]] std::vector<PlannedOutput> plan_output(const OutputRequest& request,
                                                     PathClaims& claims);

[[nodiscard]] bool has_cage(const std::vector<PlannedOutput>& outputs);

/// The same of outputs.
[[nodiscard]] std::vector<PlannedOutput> settled(std::vector<PlannedOutput> outputs,
                                                 const MeshFineness& mesh);

/// Refuses tile sets of what they are not made of (schemes but Doo-Sabin, level 0) with
/// Error{InvalidArgument}.
void require_tileable(const std::vector<PlannedOutput>& outputs, const Settings& settings);

/// Refuses STEP of surfaces that do not become B-spline faces with Error{InvalidArgument}.
void require_step_surfaces(const std::vector<PlannedOutput>& outputs, const Settings& settings);

/// Refuses surfaces that are no glTF, which alone is compressed, with Error{InvalidArgument}.
void require_compressible(const std::vector<PlannedOutput>& outputs);

/// Refuses surfaces that cannot carry vertex attributes, such as .obj, with Error{InvalidArgument}.
void require_attribute_formats(const std::vector<PlannedOutput>& outputs);

}  // namespace planish
