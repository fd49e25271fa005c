#pragma once

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "quality/figures.h"

namespace planish::quality {

/// Makes its case when it is wanted.
struct NamedCase {
  std::string name;
  std::function<Case()> make;
};

/// Small shapes of known form.
[[nodiscard]] std::vector<NamedCase> analytic_cases();

/// Further such shapes, of which none was looked at before the method was finished.
[[nodiscard]] std::vector<NamedCase> second_held_out_cases();

/// Spheres, tori and ellipsoids in quads, triangles and polygons, each at several densities.
[[nodiscard]] std::vector<NamedCase> dense_cases();

/// Arm, bust and goblet in few triangles, at several tolerances.
[[nodiscard]] std::vector<NamedCase> decimated_cases();

/// The scenes' rocker arm and others, sampled and meshed by `mesher`, and creased parts.
[[nodiscard]] std::vector<NamedCase> scanned_cases(const Mesher& mesher);

/// The files rocker-arm.obj, spot.obj and suzanne.obj in the folder that PLANISH_TEST_DATA names;
/// none where it is not set.
[[nodiscard]] std::vector<NamedCase> file_cases();

/// Of two surfaces neither is better where their normals differ by less, in parts and in degrees.
inline constexpr double kAlike = 1.1, kAlikeDegrees = 0.1;

[[nodiscard]] inline bool is_farther_off(double taken, double other) {
  return taken > kAlike * other && taken > other + kAlikeDegrees;
}

/// How often what was taken is as good as the better one, by degrees off the shape's normals.
struct Tally {
  int count = 0, right = 0;
  double excess = 1;  ///< the largest of the taken surface's deviation over the better one's

  void add(double taken, double better) {
    ++count;
    right += !is_farther_off(taken, better);
    // What is right to the last digit is no measure of how wrong another is.
    if (is_farther_off(taken, better))
      excess = std::max(excess, taken / std::max(better, kAlikeDegrees));
  }
};

/// A surface that was made and measured.
struct Outcome {
  std::string flags;   ///< what a user says for it
  std::string choice;  ///< what it is: method, whether with creases and joined triangles
  Figures figures;
  double milliseconds = 0;
};

[[nodiscard]] double milliseconds_since(std::chrono::steady_clock::time_point start);
[[nodiscard]] Outcome fitted(const Case& what, const std::string& flags,
                             const MeshFitOptions& options, Backend& backend);

/// What a user could have said instead: methods, creases and quads.
[[nodiscard]] std::vector<std::pair<std::string, MeshFitOptions>> mesh_flags();

/// What came out without a flag, beside the best of others; printed row by row.
class OutcomeTable {
 public:
  /// With a column of what came out before, or one of what was chosen instead.
  explicit OutcomeTable(bool has_before);
  /// `before` is looked at where there is a column for it.
  void add(const Case& what, const Outcome* before, const Outcome& now,
           const std::vector<Outcome>& others);
  /// Prints the sums; returns what is more than a tenth farther off the shape's normals.
  [[nodiscard]] std::vector<std::string> finish();

 private:
  bool has_before_;
  Tally tallies_[2];
  double before_ = 0, now_ = 0;
  std::vector<std::string> wrong_;
};

/// Prints which surface fit_mesh() takes of each case whose shape is known, and by how much the
/// other one is nearer to that shape, by the normals' rms deviation. Returns a line for each case
/// where the one that is taken is farther off, by more than a tenth and 0.1 degrees.
[[nodiscard]] std::vector<std::string> print_choice_table(const std::vector<NamedCase>& cases);

/// What comes out without a flag, beside the best of all combinations of flags, of meshes and of
/// noisy clouds of known shape. Returns what is more than a tenth farther off the shape's normals.
std::vector<std::string> print_default_table(const std::vector<NamedCase>& meshes,
                                             const Mesher* mesher);

/// Props, parts and vehicles as technical artists have them, a true shape for each; half of them
/// held out, by lot.
[[nodiscard]] std::vector<NamedCase> prop_cases();

/// What comes out of them without a flag, beside the best of all combinations of flags. Returns
/// what is more than a tenth farther off the shape's normals.
std::vector<std::string> print_prop_table(const std::vector<NamedCase>& cases);

/// Meshes of uneven triangles, each with the shape that it was taken from: a formula, or the dense
/// mesh before it was simplified.
[[nodiscard]] std::vector<NamedCase> irregular_cases();

/// A file's mesh, simplified within 1e-3 of its diagonal: the shape is the mesh in the file.
/// Throws as read_mesh().
[[nodiscard]] NamedCase simplified_file(const std::filesystem::path& path);

struct IrregularOptions {
  std::filesystem::path manifold;  ///< see smoothed_by_manifold(); empty: no peer
  int more_levels = 0;             ///< finer than what is written by default
};

/// Facets of meshes of uneven triangles against the shapes that these were taken from: the flat
/// triangles, what planish writes by default, and manifold-3d's at about as many facets. Returns
/// what falls short of truth; the peer has no say in that.
[[nodiscard]] std::vector<std::string> print_irregular_table(const std::vector<NamedCase>& cases,
                                                             const IrregularOptions& options);

/// Meshes as other people's files hold them (wild_shapes.h, part_maker.h), every kind twice: once
/// to choose constants by, once held out until they were fixed.
[[nodiscard]] std::vector<NamedCase> wild_cases();

/// Fits each case by the progressive method with Doo and Sabin's weights, the fair one, and the
/// fair one with found creases, and prints a row: folds that the input is not to blame for, the
/// worst of levels 1 to 3, and normals' rms deviation from the input's faces at level 2.
/// Returns the cases on which a fair surface folds, a line each.
[[nodiscard]] std::vector<std::string> print_wild_table(const std::vector<NamedCase>& cases);

/// Prints what find_features() finds: of parts as CAD programs tessellate them, and of the same
/// decimated, the share of found edges that are the model's (precision) and of the model's that are
/// found (recall); of organic shapes the share of edges that are found at all. Returns a line for
/// each part below 0.98 and each organic shape above 0.02; heads and animals of a few hundred
/// vertices have sharp edges, and are only listed. What find_features() finds stands beside it, to
/// be compared. Takes the wanted of the names that it prints.
[[nodiscard]] std::vector<std::string> print_crease_table(
    const std::function<bool(const std::string& name)>& is_wanted);

/// 8 s at 30 frames a second.
inline constexpr int kFrames = 240;

/// Fits every frame of the simplified scan of the rocker arm while it bends and twists and prints,
/// for each method, how far the normals at the vertices turn from frame to frame beside what the
/// shape itself turns. A surface that pops turns far more than its shape.
void print_animation(int frame_count);

}  // namespace planish::quality
