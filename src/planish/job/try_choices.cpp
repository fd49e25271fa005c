#include "planish/job/try_choices.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/job/job_input.h"
#include "planish/job/job_text.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/pipeline/option_table.h"

namespace planish {
namespace {

// Settings that a surface is made by; what is empty is not open.
struct Way {
  std::string creases, quads, method;
  bool refines = false;

  [[nodiscard]] std::vector<std::pair<std::string, std::string>> settings() const {
    std::vector<std::pair<std::string, std::string>> named;
    if (!quads.empty()) named.emplace_back("quads", quads);
    if (!creases.empty()) named.emplace_back("creases", creases);
    if (!method.empty()) named.emplace_back("interpolation", method);
    if (refines) named.emplace_back("refine", "on");
    return named;
  }
  [[nodiscard]] CandidateFaces faces() const {
    if (refines) return CandidateFaces::Refined;
    return quads == "on" ? CandidateFaces::Quads : CandidateFaces::Given;
  }
  [[nodiscard]] std::string stem() const {
    std::string text;
    const auto add = [&](std::string_view part) {
      if (!part.empty()) text += (text.empty() ? "" : "_") + std::string(part);
    };
    if (!quads.empty() || refines) add(word_of(kFacesWords, faces()));
    add(method);
    add(creases);
    return text;
  }
};

// What the settings leave open.
struct OpenChoice {
  explicit OpenChoice(const Settings& settings)
      : creases(settings.creases.chooses),
        quads(settings.quads == QuadChoice::Auto),
        method(settings.interpolation == InterpolationChoice::Auto),
        // Only the fair method adds vertices, and none where the given ones may be left.
        refine(settings.refine == RefineChoice::Auto && settings.quads != QuadChoice::On &&
               settings.interpolation != InterpolationChoice::Progressive &&
               !settings.within.of_diagonal && !settings.within.is_measured) {}

  [[nodiscard]] bool any() const { return creases || quads || method || refine; }
  [[nodiscard]] std::vector<std::string> methods() const {
    return method ? std::vector<std::string>{"progressive", "fair"} : std::vector<std::string>{""};
  }

  bool creases, quads, method, refine;
};

// Those of one choice of creases, in the order in which they are made.
std::vector<Way> ways_of(const OpenChoice& open, const std::string& creases) {
  std::vector<Way> ways;
  for (const char* const quads : {"off", "on"}) {
    for (const std::string& method : open.methods())
      ways.push_back({creases, open.quads ? quads : "", method});
    if (!open.quads) break;
  }
  if (open.refine)
    ways.push_back({creases, open.quads ? "off" : "", open.method ? "fair" : "", true});
  return ways;
}

// A job that was run for one way.
struct TriedJob {
  JobResult result;
  std::string bytes;
  TriedSurface tried;
};

bool has_triangle(const FittedMesh& fitted) {
  for (std::int32_t f = 0; f < fitted.mesh.face_count(); ++f)
    if (fitted.mesh.face_size(f) == 3) return true;
  return false;
}

// Of a fit for which edges were found.
bool has_found(const FittedMesh& fitted) {
  return !fitted.found.is_empty() || fitted.rounded_count > 0;
}
bool has_tags(const FittedMesh& fitted) {
  return fitted.mesh.creases.size() > fitted.found.edges.size() ||
         fitted.mesh.corners.size() > fitted.found.corners.size();
}

std::string faces_title(CandidateFaces faces) {
  switch (faces) {
    case CandidateFaces::Quads:
      return "joined to quads";
    case CandidateFaces::Refined:
      return "vertices added";
    case CandidateFaces::Mixed:
      return "each part with its own faces";
    case CandidateFaces::Given:
      break;
  }
  return "given faces";
}

std::string creases_title(const std::string& creases, bool has_tags) {
  if (creases == "auto") return has_tags ? "tagged and found edges sharp" : "found edges sharp";
  return creases == "use" && has_tags ? "tagged edges sharp" : "all edges round";
}

// What surfaces of the meshes of one job are weighed by.
class Scales {
 public:
  // `given`: fits of the given faces.
  Scales(const std::vector<FittedMesh>& given, const Settings& settings) {
    for (const FittedMesh& fitted : given) {
      auto mesh = std::make_unique<OfMesh>(mesh_parts(fitted.mesh));
      std::vector<Halves> looks;
      if (settings.quads == QuadChoice::Auto && has_triangle(fitted))
        looks = look_halved_by_parts(fitted.mesh, *fitted.fit.prepared,
                                     settings.creases.dihedral_degrees);
      mesh->meter.emplace(mesh->parts, fitted.mesh, looks);
      meshes_.push_back(std::move(mesh));
    }
  }

  void weigh(TriedJob& made, CandidateFaces faces) const {
    std::vector<FittedMesh>& fits = made.result.fitted;
    TriedSurface& tried = made.tried;
    // One mesh of several may have a surface by some ways alone.
    tried.is_measured = fits.size() == meshes_.size();
    for (std::size_t m = 0; tried.is_measured && m < fits.size(); ++m) {
      Candidate candidate{.faces = faces,
                          .method = fits[m].options.method,
                          .converged = fits[m].fit.interpolation.converged};
      meshes_[m]->meter->measure(candidate, {faces}, fits[m]);
      add(candidate, tried);
    }
  }

  static void add(const Candidate& candidate, TriedSurface& tried) {
    tried.cost += candidate.terms();
    tried.bending += candidate.bending;
    tried.folded = std::max(tried.folded, candidate.folded_area);
  }

 private:
  struct OfMesh {
    explicit OfMesh(MeshParts&& of) : parts(std::move(of)) {}
    MeshParts parts;
    std::optional<CandidateMeter> meter;  // of `parts`
  };
  std::vector<std::unique_ptr<OfMesh>> meshes_;
};

[[noreturn]] void refuse_points(const Job& job) {
  const std::string name = input_name(job.input);
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: holds points, whose mesh the fair method takes, so that there is "
                        "nothing to try; make the mesh first: planish reconstruct {} -o mesh.obj, "
                        "and try that",
                        name, name));
}

class Trier {
 public:
  Trier(const Job& job, Backend& backend, const JobWatch& watch, bool has_page,
        const TakeSurface& take)
      : job_(job),
        open_(job.settings),
        backend_(backend),
        watch_(watch),
        has_page_(has_page),
        take_(take),
        most_(1 + static_cast<double>(stems_to_try(job.settings).size())) {}

  Trial run() {
    TriedJob own = run_way({}, Kind::Own);
    if (own.result.report.points) refuse_points(job_);
    const std::vector<std::string> creases = creases_to_try();
    for (const std::string& one : creases) try_ways(one, own);
    const auto taken = std::ranges::find(trial_.surfaces, true, &TriedSurface::is_taken);
    if (taken == trial_.surfaces.end()) {
      if (has_page_) own = run_way({}, Kind::Once);
      take_own(std::move(own));
    } else {
      // Its report says why.
      taken->report = std::move(own.tried.report);
      taken->report.arguments = arguments_of(taken->settings);
      if (has_page_)
        taken->page.report["solve"]["choice"] = to_json(taken->report)["solve"]["choice"];
    }
    std::ranges::stable_sort(trial_.surfaces, {}, [](const TriedSurface& tried) {
      return std::tuple(!tried.is_taken, !tried.failure.empty(), !tried.is_measured,
                        tried.cost.sum());
    });
    name_all();
    return std::move(trial_);
  }

 private:
  [[nodiscard]] std::vector<std::string> arguments_of(
      const std::vector<std::pair<std::string, std::string>>& settings) const {
    std::vector<std::string> arguments = job_.arguments;
    for (const auto& [name, value] : settings) {
      arguments.push_back(flag_of_setting(name));
      arguments.push_back(value);
    }
    return arguments;
  }

  // The job's own is made first, to be compared with, and tells its warnings; mostly a page shows
  // it as one of the others.
  enum class Kind { Own, Once };

  TriedJob run_way(const Way& way, Kind kind) {
    TriedJob made;
    made.tried.settings = way.settings();
    made.tried.stem = way.stem();
    Job job = job_;
    const std::vector<NamedSetting> named(made.tried.settings.begin(), made.tried.settings.end());
    apply_settings(named, job.settings);
    check_consistent(job.settings);
    job.arguments = arguments_of(made.tried.settings);
    job.outputs = {surface_request(job.settings, "-", "-o")};
    job.page_options.small_width = kTriedWidth;
    PathClaims claims({});
    const std::vector<PlannedOutput> outputs =
        plan_outputs(job, claims, [](const std::function<void()>& check) { check(); });
    JobPage page(job.page_options);
    const double before = done_ / most_, after = (done_ + 1) / most_;
    ++done_;
    JobWatch watch;
    watch.cancelled = watch_.cancelled;
    if (kind == Kind::Own) watch.warning = watch_.warning;
    watch.write = [&](std::string_view bytes) { made.bytes += bytes; };
    const bool has_page = has_page_ && kind == Kind::Once;
    if (has_page) watch.page = &page;
    watch.progress = [&](std::string_view step, double fraction, double share) {
      if (watch_.progress) watch_.progress(step, fraction, std::lerp(before, after, share));
    };
    made.result = run_job(job, outputs, backend_, watch);
    if (has_page) take_page(std::move(page), made.tried);
    made.tried.report = made.result.report;
    return made;
  }

  static void take_page(JobPage&& page, TriedSurface& tried) {
    tried.picture = page.small_pictures().surface;
    std::vector<PageJob> jobs = std::move(page).jobs();
    tried.page = std::move(*std::ranges::max_element(jobs, {}, [](const PageJob& one) {
      return one.report["input"]["vertices"].get<std::int64_t>();
    }));
  }

  // Whether edges are found and tagged shows a fit; it is kept, for it mostly is one of the ways.
  std::vector<std::string> creases_to_try() {
    if (!open_.creases) return {""};
    first_way_ = ways_of(open_, "auto").front();
    try {
      first_ = run_way(first_way_, Kind::Once);
    } catch (const Error& error) {
      if (is_fatal(error)) throw;
      return {"auto"};
    }
    const std::vector<FittedMesh>& fits = first_->result.fitted;
    const bool found = std::ranges::any_of(fits, has_found);
    has_tags_ = std::ranges::any_of(fits, has_tags);
    several_creases_ = found || has_tags_;
    if (!has_tags_)
      return found ? std::vector<std::string>{"auto", "use"} : std::vector<std::string>{"auto"};
    std::vector<std::string> creases{"use"};
    if (found) creases.emplace_back("auto");
    creases.emplace_back("ignore");
    return creases;
  }

  static bool is_fatal(const Error& error) { return error.code() != ErrorCode::UnusableMesh; }

  void try_ways(const std::string& creases, const TriedJob& own) {
    std::optional<Scales> scales;
    bool may_join = true;
    for (const Way& way : ways_of(open_, creases)) {
      if (way.quads == "on" && !may_join) continue;
      TriedJob made;
      try {
        const bool is_first = first_ && way.stem() == first_way_.stem();
        made = is_first ? *std::exchange(first_, std::nullopt) : run_way(way, Kind::Once);
      } catch (const Error& error) {
        if (is_fatal(error)) throw;
        made.tried.settings = way.settings();
        made.tried.stem = way.stem();
        made.tried.failure = made.tried.page.failure = error.what();
      }
      const std::vector<FittedMesh>& fits = made.result.fitted;
      if (made.tried.failure.empty()) {
        if (!scales) {
          scales.emplace(fits, job_.settings);
          may_join = std::ranges::any_of(fits, has_triangle);
        }
        const auto has_joined = [](const FittedMesh& fitted) { return fitted.paired_count > 0; };
        const auto has_added = [](const FittedMesh& fitted) {
          return !fitted.added_vertices.empty();
        };
        if (way.quads == "on") may_join = std::ranges::any_of(fits, has_joined);
        if (way.quads == "on" && !may_join) continue;
        if (way.refines && std::ranges::none_of(fits, has_added)) continue;
        scales->weigh(made, way.faces());
        made.tried.is_taken = made.bytes == own.bytes;
      }
      made.tried.title = title_of(way);
      if (take_ && made.tried.failure.empty()) take_(made.tried, made.bytes);
      trial_.surfaces.push_back(std::move(made.tried));
    }
  }

  [[nodiscard]] std::string title_of(const Way& way) const {
    std::string title;
    const auto add = [&](const std::string& part) { title += (title.empty() ? "" : ", ") + part; };
    if (!way.quads.empty() || way.refines) add(faces_title(way.faces()));
    if (!way.method.empty()) add(way.method);
    if (several_creases_) add(creases_title(way.creases, has_tags_));
    return title;
  }

  // What no flags name: of several parts or meshes each has its own faces or method.
  void take_own(TriedJob&& own) {
    TriedSurface& tried = own.tried;
    tried.is_taken = true;
    tried.stem = "default";
    const bool is_asset = own.result.fitted.size() > 1;
    for (const FittedMesh& fitted : own.result.fitted) {
      tried.is_measured &= fitted.choice && fitted.choice->best().is_measured();
      if (tried.is_measured) Scales::add(fitted.choice->best(), tried);
    }
    tried.title = is_asset ? "each mesh as is best for it" : faces_title(CandidateFaces::Mixed);
    if (take_) take_(tried, own.bytes);
    trial_.surfaces.push_back(std::move(tried));
  }

  // As pages and reports have them.
  void name_all() {
    for (TriedSurface& tried : trial_.surfaces) {
      if (!tried.failure.empty()) {
        tried.page.name = tried.title;
      } else if (has_page_) {
        tried.page.report["job"] = tried.title;
        tried.page.report["argv"] = arguments_of(tried.settings);
      }
    }
    const FitFigures& fit = trial_.surfaces.front().report.fit;
    if (!fit.choice) return;
    trial_.reason = fit.choice->reason;
    if (!fit.choice->faces_reason.empty())
      trial_.reason += (trial_.reason.empty() ? "" : "; ") + fit.choice->faces_reason;
  }

  const Job& job_;
  const OpenChoice open_;
  Backend& backend_;
  const JobWatch& watch_;
  const bool has_page_;
  const TakeSurface& take_;
  double done_ = 0;
  const double most_;
  Way first_way_;
  std::optional<TriedJob> first_;
  bool has_tags_ = false, several_creases_ = false;
  Trial trial_;
};

}  // namespace

std::vector<std::string> stems_to_try(const Settings& settings) {
  const OpenChoice open(settings);
  std::vector<std::string> stems{"default"};
  const std::vector<std::string> creases = open.creases
                                               ? std::vector<std::string>{"auto", "use", "ignore"}
                                               : std::vector<std::string>{""};
  for (const std::string& one : creases)
    for (const Way& way : ways_of(open, one)) stems.push_back(way.stem());
  return stems;
}

void require_open_choice(const Job& job) {
  const Settings& settings = job.settings;
  if (settings.scheme != Scheme::DooSabin)
    refuse("--scheme",
           "{} surfaces leave nothing to try: method, faces and sharp edges are chosen for "
           "doo-sabin alone; leave --scheme out",
           name_of(settings.scheme));
  if (!OpenChoice(settings).any())
    throw Error(ErrorCode::InvalidArgument,
                "nothing is left to try; leave out one of --quads, --creases, --interpolation and "
                "--refine");
  if (settings.levels.size() > 1 || settings.adaptive.chord_errors.size() > 1)
    refuse(settings.levels.size() > 1 ? "--levels" : "--chord-error",
           "surfaces are tried with one fineness each; name one");
  if (job.input == "-")
    throw Error(ErrorCode::InvalidArgument,
                "stdin: is read once, and each surface that is tried reads its input; name a file");
  if (may_be_points(job)) refuse_points(job);
}

Trial try_choices(const Job& job, Backend& backend, const JobWatch& watch, bool has_page,
                  const TakeSurface& take) {
  require_open_choice(job);
  return Trier(job, backend, watch, has_page, take).run();
}

}  // namespace planish
