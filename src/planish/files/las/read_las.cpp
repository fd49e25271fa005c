#include "planish/files/las/read_las.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/stop.h"
#include "planish/files/las/las_header.h"
#include "planish/files/shared/read_progress.h"
#include "planish/files/shared/srgb.h"

namespace planish {
namespace {

constexpr std::size_t kPiecePoints = 1 << 16;

// ASPRS' names, by number.
constexpr std::array<std::string_view, 23> kClassNames{"never classified",
                                                       "unclassified",
                                                       "ground",
                                                       "low vegetation",
                                                       "medium vegetation",
                                                       "high vegetation",
                                                       "building",
                                                       "low noise",
                                                       "model key point",
                                                       "water",
                                                       "rail",
                                                       "road",
                                                       "overlap",
                                                       "wire guard",
                                                       "wire conductor",
                                                       "transmission tower",
                                                       "wire connector",
                                                       "bridge deck",
                                                       "high noise",
                                                       "overhead structure",
                                                       "ignored ground",
                                                       "snow",
                                                       "temporal exclusion"};

std::string class_name(int number) {
  std::string text = std::to_string(number);
  if (static_cast<std::size_t>(number) >= kClassNames.size()) return text;
  return text + " " + std::string(kClassNames[number]);
}

// What is to be known before points are placed.
struct PieceSurvey {
  std::int64_t kept = 0, missing = 0;
  std::uint16_t brightest = 0;  // of all channels
  bool has_intensity = false;
};

class LasReader {
 public:
  explicit LasReader(const FileBytes& file)
      : file_(file),
        header_(read_las_header(file)),
        pieces_((count() + kPiecePoints - 1) / kPiecePoints) {}

  PointCloud read() {
    expect_passes(file_, 2);
    note_damage();
    look_at_pieces();
    std::vector<std::int64_t> first(pieces_.size() + 1, 0);
    std::uint16_t brightest = 0;
    bool has_intensity = false;
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      first[p + 1] = first[p] + pieces_[p].kept;
      cloud_.missing_count += pieces_[p].missing;
      brightest = std::max(brightest, pieces_[p].brightest);
      has_intensity |= pieces_[p].has_intensity;
    }
    cloud_.points.resize(static_cast<std::size_t>(first.back()));
    if (brightest > 0) cloud_.colors.resize(cloud_.points.size());
    if (has_intensity)
      cloud_.attributes.push_back(attribute_of_size("intensity", 1, cloud_.points.size()));
    const double white = brightest > 255 ? 65535 : 255;
    for_pieces([&](std::size_t piece, std::size_t begin, std::size_t end) {
      auto to = static_cast<std::size_t>(first[piece]);
      for (std::size_t i = begin; i < end; ++i) {
        const LasRecord record = las_record(header_, file_.bytes, i);
        if (record.is_left_out() || !record.has_place()) continue;
        cloud_.points[to] = record.position();
        if (brightest > 0) cloud_.colors[to] = color_of(record, white);
        if (has_intensity) cloud_.attributes[0].values[to] = record.intensity();
        ++to;
      }
    });
    warn_of_left_out();
    return std::move(cloud_);
  }

 private:
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(header_.point_count); }

  template <class Body>
  void for_pieces(const Body& body) const {
    parallel_each(pieces_.size(), 1, [&](std::size_t p) {
      const std::size_t last = std::min(count(), (p + 1) * kPiecePoints);
      body(p, p * kPiecePoints, last);
      count_read(file_.progress, (last - p * kPiecePoints) * header_.record_bytes);
    });
  }

  void look_at_pieces() {
    for_pieces([&](std::size_t piece, std::size_t begin, std::size_t end) {
      PieceSurvey survey;
      for (std::size_t i = begin; i < end; ++i) {
        const LasRecord record = las_record(header_, file_.bytes, i);
        if (record.is_left_out()) continue;
        if (!record.has_place()) {
          ++survey.missing;
          continue;
        }
        ++survey.kept;
        survey.has_intensity |= record.intensity() > 0;
        if (header_.color_begin == 0) continue;
        for (int channel = 0; channel < 3; ++channel)
          survey.brightest = std::max(survey.brightest, record.color(channel));
      }
      pieces_[piece] = survey;
    });
  }

  static glm::vec4 color_of(const LasRecord& record, double white) {
    return linear_of_srgb(
        glm::dvec4(record.color(0) / white, record.color(1) / white, record.color(2) / white, 1.0));
  }

  void note_damage() {
    if (header_.record_damage.empty()) return;
    const std::string what = std::string(file_.name) + ": " + header_.record_damage;
    if (file_.is_strict) throw Error(ErrorCode::UnreadableInput, what);
    cloud_.warnings.push_back(
        {.code = "damaged-record",
         .message = what + "; those from there on are passed over, points are read"});
  }

  void warn_of_left_out() {
    const std::int64_t left_out =
        header_.point_count - std::ssize(cloud_.points) - cloud_.missing_count;
    if (left_out == 0) return;
    cloud_.warnings.push_back(
        {.code = "noise-points",
         .message =
             formatted("{}: {}{} classified as noise or withheld in the file, and left out",
                       file_.name, counted(left_out, "point"), left_out == 1 ? " is" : " are"),
         .count = left_out});
  }

  FileBytes file_;
  LasHeader header_;
  std::vector<PieceSurvey> pieces_;
  PointCloud cloud_;
};

}  // namespace

PointCloud read_las(const FileBytes& file) { return LasReader(file).read(); }

ScanContents las_contents(const FileBytes& file) {
  const LasHeader header = read_las_header(file);
  std::map<int, std::int64_t> classes, sources;
  for (std::size_t i = 0; i < static_cast<std::size_t>(header.point_count); ++i) {
    if (i % kPiecePoints == 0) check_stop();
    const LasRecord record = las_record(header, file.bytes, i);
    ++classes[record.classification()];
    ++sources[record.source()];
  }
  ScanContents contents{
      .version = formatted("LAS 1.{}, point format {}, {} bytes a point", header.minor_version,
                           header.point_format, header.record_bytes),
      .software = header.software,
      .coordinate_system = header.coordinate_system,
      .scans = {},
      .classes = {}};
  for (const auto& [number, points] : classes)
    contents.classes.emplace_back(class_name(number), points);
  for (const auto& [number, points] : sources)
    contents.scans.emplace_back(formatted("source {}", number), points);
  return contents;
}

}  // namespace planish
