#include "planish/brep/analytic_part.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "planish/analytic/border_curves.h"
#include "planish/analytic/find_regions.h"
#include "planish/analytic/region_borders.h"
#include "planish/analytic/settle_surfaces.h"
#include "planish/brep/freeform_side.h"
#include "planish/core/portable_math.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
// Of the diagonal: points that are nearer are one.
constexpr double kSamePoint = 1e-7;

double wrapped(double angle) { return angle - kTurn * std::floor(angle / kTurn + 0.5); }

// A point on a chain: behind so many of its vertices.
struct ChainPlace {
  std::int32_t chain = 0;
  double place = 0;
};

// The part of the B-rep of faces that edges join, in unit coordinates.
class PartBuilder {
 public:
  // `freeform`: faces between those on surfaces; null: there are none.
  PartBuilder(const AnalyticParts& found, const MeshTopology& topology,
              const FreeformFaces* freeform, Brep& brep)
      : positions_(found.positions),
        topology_(topology),
        placement_(found.placement),
        regions_(found.regions),
        borders_(found.borders),
        settled_(found.settled),
        freeform_(freeform),
        brep_(brep) {}

  // The regions that are in the way of faces of these, whatever B-spline faces they end at; those
  // that only others had shown may be left out. Throws NotAnalytic where no region is to blame.
  [[nodiscard]] std::vector<std::int32_t> try_regions(std::span<const std::int32_t> regions) {
    is_trial_ = true;
    for (const std::int32_t r : regions) number_[r] = r;
    gather_chains(regions);
    if (in_the_way_.empty())
      for (const std::int32_t r : regions) attempt({&r, 1}, [&] { plan(r); });
    if (in_the_way_.empty())
      for (const std::int32_t c : chains_)
        if (borders_.chains[c].right >= 0) attempt(sides_of(c), [&] { make_edges(c); });
    // The smaller half: with these the others may not be.
    std::ranges::sort(in_the_way_, std::less<>(),
                      [&](std::int32_t r) { return std::pair(area_of(r), r); });
    in_the_way_.resize((in_the_way_.size() + 1) / 2);
    return in_the_way_;
  }
  // Adds the faces of these regions, in their order, and behind them these B-spline faces. Throws
  // NotAnalytic, and the B-rep is to be forgotten then.
  void build(std::span<const std::int32_t> regions, std::span<const std::int32_t> freeform) {
    std::int32_t count = 0;
    for (const std::int32_t r : regions) number_[r] = count++;
    if (!freeform.empty()) free_.emplace(*freeform_, placement_, freeform, count, brep_);
    gather_chains(regions);
    if (free_) {
      free_->move_borders();
      set_free_points();
    }
    for (const std::int32_t r : regions) plan(r);
    for (const std::int32_t c : chains_) make_edges(c);
    for (const std::int32_t r : regions) make_face(r);
    if (free_) free_->add_faces();
  }

 private:
  using Split = FreeformSide::Split;  // places are on the chain
  struct ChainPlan {
    BorderSides sides;               // beside freeform faces the left one alone
    std::vector<glm::dvec3> points;  // of its vertices, on both surfaces
    std::vector<Split> splits;       // of a closed chain all its vertices, else those between ends
    std::int32_t from = -1, to = -1;
    std::vector<std::int32_t> edges;  // in its order, from its first split where it is closed
    bool is_free = false;             // beside freeform faces: places are as FreeformSide has them
  };
  // A curve inside a face that closes it: from a vertex to another or to the same one.
  struct Seam {
    std::int32_t edge = 0;
    std::int32_t from_loop = -1, to_loop = -1;  // -1: a pole
  };
  struct FacePlan {
    std::vector<Seam> seams;
    bool is_whole_torus = false;
  };

  // In a trial what is in the way is noted, unless one of the regions that it is about is already:
  // without that all may be well.
  template <class Make>
  void attempt(std::span<const std::int32_t> about, const Make& make) {
    if (!is_trial_) return make();
    if (std::ranges::any_of(about, [&](std::int32_t r) {
          return std::ranges::find(in_the_way_, r) != in_the_way_.end();
        }))
      return;
    try {
      make();
    } catch (const NotAnalytic& reason) {
      if (reason.region < 0) throw;
      in_the_way_.push_back(reason.region);
    }
  }
  [[nodiscard]] std::array<std::int32_t, 2> sides_of(std::int32_t c) const {
    return {borders_.chains[c].left, borders_.chains[c].right};
  }
  [[nodiscard]] const AnalyticSurface& surface(std::int32_t region) const {
    return regions_.regions[region].surface;
  }
  [[nodiscard]] SidedSurface sided(std::int32_t region) const {
    return {&surface(region), regions_.regions[region].side()};
  }

  std::int32_t add_vertex(const glm::dvec3& point) {
    brep_.vertices.push_back(point);
    return static_cast<std::int32_t>(brep_.vertices.size()) - 1;
  }

  void gather_chains(std::span<const std::int32_t> regions) {
    for (const std::int32_t r : regions)
      for (const auto& loop : borders_.loops[r])
        for (const ChainUse& use : loop) chains_.push_back(use.chain);
    std::ranges::sort(chains_);
    chains_.erase(std::ranges::unique(chains_).begin(), chains_.end());
    std::map<std::int32_t, std::vector<std::int32_t>> chains_at;
    for (const std::int32_t c : chains_) {
      const BorderChain& chain = borders_.chains[c];
      if (chain.is_boundary)
        attempt({&chain.left, 1}, [&] { throw NotAnalytic{"it is open", chain.left}; });
      if (chain.is_closed) continue;
      chains_at[chain.vertices.front()].push_back(c);
      chains_at[chain.vertices.back()].push_back(c);
    }
    for (const auto& [vertex, chains] : chains_at) {
      std::vector<std::int32_t> around;
      for (const std::int32_t c : chains)
        for (const std::int32_t r : sides_of(c)) around.push_back(r);
      attempt(around, [&] { vertex_of_[vertex] = junction(vertex, chains); });
    }
    if (!in_the_way_.empty()) return;
    join_junctions();
    for (const std::int32_t c : chains_) {
      const BorderChain& chain = borders_.chains[c];
      ChainPlan& plan = plans_[c];
      if (!chain.is_closed) {
        plan.from = vertex_of_.at(chain.vertices.front());
        plan.to = vertex_of_.at(chain.vertices.back());
      }
      if (chain.right < 0) {
        plan_free_chain(c);
        continue;
      }
      attempt(sides_of(c), [&] { plan_chain(c); });
    }
  }
  void plan_chain(std::int32_t c) {
    const BorderChain& chain = borders_.chains[c];
    ChainPlan& plan = plans_.at(c);
    plan.sides = {sided(chain.left), sided(chain.right), settled_.is_tangent[c] != 0};
    const std::size_t last = chain.vertices.size() - 1;
    for (std::size_t i = 0; i <= last; ++i) {
      const glm::dvec3& given = positions_[chain.vertices[i]];
      if (i == last && chain.is_closed) {
        plan.points.push_back(plan.points.front());
      } else if ((i == 0 || i == last) && !chain.is_closed) {
        plan.points.push_back(brep_.vertices[i == 0 ? plan.from : plan.to]);
      } else {
        double reach = 0;
        plan.points.push_back(plan.sides.point(given, reach));
        require_near(
            reach, kOnSurface, chain.vertices[i], plan.points.back(), plan.sides.is_tangent,
            {"two surfaces do not meet where their faces do", smaller(chain.left, chain.right)});
      }
    }
  }
  // Those that a chain joins and that are one point: noise has put an edge between them.
  void join_junctions() {
    std::map<std::int32_t, std::int32_t> stands_for;  // vertices of the B-rep
    const auto of = [&](std::int32_t v) {
      while (stands_for.contains(v)) v = stands_for.at(v);
      return v;
    };
    for (const std::int32_t c : chains_) {
      const BorderChain& chain = borders_.chains[c];
      if (chain.is_closed || chain.right < 0) continue;
      const std::int32_t from = of(vertex_of_.at(chain.vertices.front())),
                         to = of(vertex_of_.at(chain.vertices.back()));
      if (from != to && glm::length(brep_.vertices[from] - brep_.vertices[to]) < kSamePoint)
        stands_for[to] = from;
    }
    for (auto& [vertex, junction] : vertex_of_) junction = of(junction);
  }
  [[nodiscard]] static bool is_point(const BorderChain& chain, const ChainPlan& plan) {
    return !chain.is_closed && plan.from == plan.to &&
           chain.vertices.front() != chain.vertices.back();
  }
  // Whether a point that surfaces have in common stands for a vertex: not much farther than its
  // edges reach, for noise moves these from one side of a border to the other, and farther where
  // surfaces touch.
  void require_near(double reach, double most, std::int32_t vertex, const glm::dvec3& to,
                    bool is_tangent, const NotAnalytic& otherwise) const {
    constexpr double kMostMoved = 2e-3, kMost = 0.02;  // of the diagonal
    const glm::dvec3& from = positions_[vertex];
    double longest = is_tangent ? kMost : 0;
    for (const std::int32_t corner : topology_.corners_at(vertex))
      longest = std::max(
          longest, glm::length(positions_[topology_.vertex_of(topology_.next(corner))] - from));
    if (!(reach <= most) || !(glm::length(to - from) <= std::clamp(2 * longest, kMostMoved, kMost)))
      throw otherwise;
  }
  [[nodiscard]] double area_of(std::int32_t region) const {
    double area = 0;
    for (const std::int32_t f : regions_.regions[region].faces)
      area += glm::length(area_vector(positions_, topology_.face(f)));
    return area;
  }
  [[nodiscard]] std::int32_t smaller(std::int32_t a, std::int32_t b) const {
    return area_of(a) < area_of(b) ? a : b;
  }
  std::int32_t junction(std::int32_t vertex, const std::vector<std::int32_t>& chains) {
    std::vector<std::int32_t> around;
    const auto index = [&](std::int32_t region) {
      const auto found = std::ranges::find(around, region);
      if (found != around.end()) return static_cast<std::size_t>(found - around.begin());
      around.push_back(region);
      return around.size() - 1;
    };
    std::vector<std::array<std::size_t, 2>> touching;
    for (const std::int32_t c : chains) {
      const std::size_t a = index(borders_.chains[c].left);
      if (borders_.chains[c].right < 0) continue;
      const std::size_t b = index(borders_.chains[c].right);
      if (settled_.is_tangent[c] != 0) touching.push_back({a, b});
    }
    std::vector<SidedSurface> surfaces;
    for (const std::int32_t r : around) surfaces.push_back(sided(r));
    double reach = 0;
    const glm::dvec3 point = common_point(positions_[vertex], surfaces, touching, reach);
    require_near(
        reach, kOnAll, vertex, point, !touching.empty(),
        {"surfaces that meet at a vertex have no point in common",
         *std::ranges::min_element(around, {}, [&](std::int32_t r) { return area_of(r); })});
    return add_vertex(point);
  }

  void plan_free_chain(std::int32_t c) {
    const BorderChain& chain = borders_.chains[c];
    ChainPlan& plan = plans_.at(c);
    plan.is_free = true;
    plan.sides.left = sided(chain.left);
    if (is_trial_) {
      for (const std::int32_t v : chain.vertices)
        plan.points.push_back(nearest_point(surface(chain.left), positions_[v]));
    } else if (free_) {
      plan.splits = free_->add_chain(c, surface(chain.left), plan.from, plan.to);
    } else {
      throw NotAnalytic{"some of its faces lie on no plane, cylinder, cone, sphere or torus"};
    }
  }
  void set_free_points() {
    for (auto& [c, plan] : plans_) {
      if (!plan.is_free) continue;
      for (double place = 0; place <= free_->length(c); ++place)
        plan.points.push_back(free_->point(c, place));
      if (borders_.chains[c].is_closed) plan.points.back() = plan.points.front();
    }
  }
  // The place between one point of a chain and the next at which it has an angle, which it passes
  // there.
  [[nodiscard]] double place_of_angle(std::int32_t c, const AnalyticSurface& s, double low,
                                      double angle, bool is_tube) const {
    // Such that sums and differences of parameters are exact.
    constexpr int kHalvings = 30;
    const auto off = [&](double place) {
      return wrapped(angle_of(s, free_->point(c, place), is_tube) - angle);
    };
    const bool rises = off(low + 1) > off(low);
    for (int i = 1; i <= kHalvings; ++i) {
      const double step = std::ldexp(1.0, -i);
      if ((off(low + step) < 0) == rises) low += step;
    }
    return low;
  }

  // Angle of a point about the axis, or around the tube.
  [[nodiscard]] static double angle_of(const AnalyticSurface& s, const glm::dvec3& p,
                                       bool is_tube) {
    const AxisFrame frame(s.axis);
    const glm::dvec3 from = p - s.origin;
    const double x = glm::dot(from, frame.x), y = glm::dot(from, frame.y);
    if (!is_tube) return portable::atan2(y, x);
    return portable::atan2(glm::dot(from, s.axis), portable::hypot(x, y) - s.radius);
  }
  // A surface on which that angle is one number, near the point.
  [[nodiscard]] static AnalyticSurface at_angle(const AnalyticSurface& s, double angle,
                                                bool is_tube) {
    const AxisFrame frame(s.axis);
    const double c = portable::cos(angle), n = portable::sin(angle);
    if (!is_tube)
      return {.kind = AnalyticKind::Plane, .origin = s.origin, .axis = c * frame.y - n * frame.x};
    if (std::abs(c) > 0.7)
      return {
          .kind = AnalyticKind::Plane, .origin = s.origin + s.minor * n * s.axis, .axis = s.axis};
    return {.kind = AnalyticKind::Cylinder,
            .origin = s.origin,
            .axis = s.axis,
            .radius = s.radius + s.minor * c};
  }

  // Points of a loop, one after another, and where they stand.
  struct LoopPoints {
    std::vector<glm::dvec3> points;  // the last one is the first one
    std::vector<ChainPlace> places;
  };
  [[nodiscard]] LoopPoints points_of(const std::vector<ChainUse>& loop) const {
    LoopPoints result;
    for (const ChainUse& use : loop) {
      const ChainPlan& plan = plans_.at(use.chain);
      const std::size_t count = plan.points.size();
      for (std::size_t i = result.points.empty() ? 0 : 1; i < count; ++i) {
        const std::size_t k = use.is_reversed ? count - 1 - i : i;
        result.points.push_back(plan.points[k]);
        result.places.push_back({use.chain, static_cast<double>(k)});
      }
    }
    return result;
  }
  [[nodiscard]] int winding(const AnalyticSurface& s, const LoopPoints& loop, bool is_tube) const {
    double turn = 0;
    for (std::size_t i = 0; i + 1 < loop.points.size(); ++i)
      turn +=
          wrapped(angle_of(s, loop.points[i + 1], is_tube) - angle_of(s, loop.points[i], is_tube));
    return static_cast<int>(std::lround(turn / kTurn));
  }

  void plan(std::int32_t region) {
    try {
      plan_seams(region);
    } catch (NotAnalytic& reason) {
      if (reason.region < 0) reason.region = region;
      throw;
    }
  }
  void plan_seams(std::int32_t region) {
    const auto& loops = borders_.loops[region];
    AnalyticSurface s = surface(region);
    FacePlan& face = faces_[region];
    if (s.kind == AnalyticKind::Plane) {
      if (loops.empty()) throw NotAnalytic{"a plane has no border"};
      return;
    }
    std::vector<LoopPoints> points;
    for (const auto& loop : loops) points.push_back(points_of(loop));
    if (s.kind == AnalyticKind::Sphere) {
      s.axis = sphere_axis(region, points);
      axes_[region] = s.axis;
    }
    std::array<std::vector<std::int32_t>, 2> wound;  // about the axis, around the tube
    for (std::size_t l = 0; l < points.size(); ++l) {
      const int about = winding(s, points[l], false);
      const int around = s.kind == AnalyticKind::Torus ? winding(s, points[l], true) : 0;
      if (about != 0 && around != 0) throw NotAnalytic{"a border winds around a torus both ways"};
      if (std::abs(about) > 1 || std::abs(around) > 1)
        throw NotAnalytic{"a border winds around a surface more than once"};
      if (about != 0) wound[0].push_back(static_cast<std::int32_t>(l));
      if (around != 0) wound[1].push_back(static_cast<std::int32_t>(l));
    }
    if (s.kind == AnalyticKind::Torus && loops.empty()) {
      whole_torus(region, s, face);
      return;
    }
    if (s.kind == AnalyticKind::Sphere && loops.empty()) {
      const std::int32_t from = add_vertex(s.origin - s.radius * s.axis),
                         to = add_vertex(s.origin + s.radius * s.axis);
      const AxisFrame frame(s.axis);
      BorderCurve half = arc(s.origin, -frame.y, brep_.vertices[from]);
      if (glm::dot(glm::cross(half.axis, half.along), frame.x) < 0) half.axis = -half.axis;
      face.seams.push_back({add_edge(from, to, half, region, region), -1, -1});
      return;
    }
    if (loops.empty()) throw NotAnalytic{"a surface that does not close has no border"};
    if (!wound[0].empty() && !wound[1].empty())
      throw NotAnalytic{"borders wind around a torus both ways"};
    const bool is_tube = !wound[1].empty();
    const auto& ends = wound[is_tube ? 1 : 0];
    if (ends.empty()) return;
    if (ends.size() == 2) {
      join(region, s, points, ends[0], ends[1], is_tube, face);
    } else if (ends.size() == 1 && !is_tube && s.kind != AnalyticKind::Torus &&
               s.kind != AnalyticKind::Cylinder) {
      join_pole(region, s, points, ends[0], face);
    } else {
      throw NotAnalytic{"borders wind around a surface otherwise than in pairs"};
    }
  }

  void whole_torus(std::int32_t region, const AnalyticSurface& s, FacePlan& face) {
    const AxisFrame frame(s.axis);
    const glm::dvec3 p = s.origin + (s.radius + s.minor) * frame.x;
    const std::int32_t vertex = add_vertex(p);
    face.seams.push_back(
        {add_edge(vertex, vertex, arc(s.origin, s.axis, p), region, region), -1, -1});
    face.seams.push_back(
        {add_edge(vertex, vertex, arc(s.origin + s.radius * frame.x, -frame.y, p), region, region),
         -1, -1});
    face.is_whole_torus = true;
  }
  // Where a loop passes an angle.
  [[nodiscard]] std::vector<ChainPlace> crossings(const AnalyticSurface& s, const LoopPoints& loop,
                                                  double angle, bool is_tube) const {
    std::vector<ChainPlace> result;
    constexpr double kSame = 1e-9;
    for (std::size_t i = 0; i + 1 < loop.points.size(); ++i) {
      double a = wrapped(angle_of(s, loop.points[i], is_tube) - angle),
             b = wrapped(angle_of(s, loop.points[i + 1], is_tube) - angle);
      if (std::abs(a) < kSame) a = 0;
      if (std::abs(b) < kSame) b = 0;
      if (b == 0) {
        result.push_back(loop.places[i + 1]);
        continue;
      }
      if (a == 0 || a * b > 0 || std::abs(a - b) > std::numbers::pi) continue;
      const double part = a / (a - b);
      const ChainPlace from = loop.places[i], to = loop.places[i + 1];
      // The next chain's first point stands on both.
      const double last = static_cast<double>(plans_.at(to.chain).points.size() - 1);
      const double begin = from.chain == to.chain && std::abs(from.place - to.place) <= 1
                               ? from.place
                               : (to.place < 1.5 ? 0.0 : last);
      result.push_back({to.chain, begin + part * (to.place - begin)});
    }
    return result;
  }

  // A vertex of a chain there, which may be one that it has.
  std::int32_t split(const AnalyticSurface& s, ChainPlace at, double angle, bool is_tube) {
    ChainPlan& plan = plans_.at(at.chain);
    const BorderChain& chain = borders_.chains[at.chain];
    const double last = static_cast<double>(plan.points.size() - 1);
    const auto before = static_cast<std::size_t>(std::clamp(std::floor(at.place), 0.0, last));
    const std::size_t after = std::min(before + 1, plan.points.size() - 1);
    const double part = at.place - static_cast<double>(before);
    const glm::dvec3 near = (1 - part) * plan.points[before] + part * plan.points[after];
    glm::dvec3 p;
    double place = at.place;
    if (plan.is_free && is_trial_) {
      p = nearest_point(surface(chain.left), near);
    } else if (!plan.is_free) {
      const AnalyticSurface cut = at_angle(s, angle, is_tube);
      double reach = 0;
      p = plan.sides.point(near, reach, &cut);
      // Where surfaces touch, their common points are told by the square root of rounding.
      constexpr double kTold = 2e-8;
      if (!(reach <= kTold)) throw NotAnalytic{"a seam ends on no border"};
    } else {
      if (part > 0)
        place = place_of_angle(at.chain, s, static_cast<double>(before), angle, is_tube);
      p = free_->point(at.chain, place);
    }
    for (const std::int32_t v : {plan.from, plan.to})
      if (v >= 0 && glm::length(brep_.vertices[v] - p) < kSamePoint) return v;
    for (const Split& known : plan.splits)
      if (glm::length(brep_.vertices[known.vertex] - p) < kSamePoint) return known.vertex;
    if (chain.is_closed && place >= last) place -= last;
    const std::int32_t vertex = add_vertex(p);
    plan.splits.push_back({place, vertex});
    std::ranges::sort(plan.splits, std::less<>(), &Split::place);
    return vertex;
  }

  // Angles at which a seam may lie, those of vertices that are there first.
  [[nodiscard]] std::vector<double> seam_angles(const AnalyticSurface& s,
                                                std::span<const std::vector<ChainUse>> loops,
                                                bool is_tube) const {
    std::vector<double> angles;
    for (const auto& loop : loops) {
      for (const ChainUse& use : loop) {
        const ChainPlan& plan = plans_.at(use.chain);
        for (const Split& known : plan.splits)
          angles.push_back(angle_of(s, brep_.vertices[known.vertex], is_tube));
        if (plan.from >= 0) angles.push_back(angle_of(s, brep_.vertices[plan.from], is_tube));
      }
    }
    constexpr int kOthers = 16;
    for (int i = 0; i < kOthers; ++i)
      angles.push_back(wrapped(kTurn * (i % 2 == 0 ? i / 2 : kOthers / 2 + i / 2) / kOthers));
    return angles;
  }

  void join(std::int32_t region, const AnalyticSurface& s, const std::vector<LoopPoints>& points,
            std::int32_t a, std::int32_t b, bool is_tube, FacePlan& face) {
    const auto& loops = borders_.loops[region];
    const std::array<std::vector<ChainUse>, 2> ends{loops[a], loops[b]};
    for (const double angle : seam_angles(s, ends, is_tube)) {
      const auto at_a = crossings(s, points[a], angle, is_tube),
                 at_b = crossings(s, points[b], angle, is_tube);
      if (at_a.size() != 1 || at_b.size() != 1 || !is_clear(s, points, a, b, angle, is_tube))
        continue;
      const std::int32_t from = split(s, at_a[0], angle, is_tube),
                         to = split(s, at_b[0], angle, is_tube);
      const glm::dvec3 p = brep_.vertices[from], q = brep_.vertices[to];
      if (glm::length(p - q) < kSamePoint) throw NotAnalytic{"borders touch"};
      face.seams.push_back(
          {add_edge(from, to, seam_curve(region, s, p, q, is_tube), region, region), a, b});
      return;
    }
    throw NotAnalytic{"no seam between two borders passes its holes by"};
  }
  [[nodiscard]] bool is_clear(const AnalyticSurface& s, const std::vector<LoopPoints>& points,
                              std::int32_t a, std::int32_t b, double angle, bool is_tube) const {
    for (std::int32_t l = 0; l < std::ssize(points); ++l)
      if (l != a && l != b && !crossings(s, points[l], angle, is_tube).empty()) return false;
    return true;
  }

  // From a border to a cone's apex or a sphere's pole, which the region holds.
  void join_pole(std::int32_t region, const AnalyticSurface& s,
                 const std::vector<LoopPoints>& points, std::int32_t a, FacePlan& face) {
    const auto& loops = borders_.loops[region];
    glm::dvec3 pole = s.origin;
    if (s.kind == AnalyticKind::Sphere) {
      const double side =
          (winding(s, points[a], false) > 0 ? 1.0 : -1.0) * regions_.regions[region].side();
      pole += side * s.radius * s.axis;
    }
    for (const double angle : seam_angles(s, std::span(&loops[a], 1), false)) {
      const auto at = crossings(s, points[a], angle, false);
      if (at.size() != 1 || !is_clear(s, points, a, a, angle, false)) continue;
      const std::int32_t from = split(s, at[0], angle, false), to = add_vertex(pole);
      const glm::dvec3 p = brep_.vertices[from];
      face.seams.push_back(
          {add_edge(from, to, seam_curve(region, s, p, pole, false), region, region), a, -1});
      return;
    }
    throw NotAnalytic{"no seam to a pole passes its holes by"};
  }

  [[nodiscard]] BorderCurve seam_curve(std::int32_t region, const AnalyticSurface& s,
                                       const glm::dvec3& p, const glm::dvec3& q,
                                       bool is_tube) const {
    if (s.kind == AnalyticKind::Cylinder || s.kind == AnalyticKind::Cone)
      return {.kind = CurveKind::Line};
    BorderCurve curve;
    if (s.kind == AnalyticKind::Sphere) {
      const glm::dvec3 cross = glm::cross(p - s.origin, q - s.origin);
      curve = arc(s.origin, glm::normalize(cross), p);
      return curve;  // never past a pole
    }
    if (is_tube) {
      curve = arc(s.origin, s.axis, p);
    } else {
      const glm::dvec3 from = p - s.origin;
      const glm::dvec3 away = glm::normalize(from - glm::dot(from, s.axis) * s.axis);
      curve = arc(s.origin + s.radius * away, glm::cross(s.axis, away), p);
    }
    // Of both ways the one on which the region lies.
    const auto middle = [&](const BorderCurve& of) {
      const glm::dvec3 y = glm::cross(of.axis, of.along), to = q - of.centre;
      double angle = portable::atan2(glm::dot(to, y), glm::dot(to, of.along));
      if (angle <= 0) angle += kTurn;
      return of.centre +
             of.radius * (portable::cos(angle / 2) * of.along + portable::sin(angle / 2) * y);
    };
    BorderCurve other = curve;
    other.axis = -other.axis;
    const glm::dvec3 one = middle(curve), two = middle(other);
    double to_one = std::numeric_limits<double>::max(), to_two = to_one;
    for (const std::int32_t f : regions_.regions[region].faces) {
      glm::dvec3 centre(0.0);
      for (const std::int32_t v : topology_.face(f))
        centre += positions_[v] / static_cast<double>(topology_.face_size(f));
      to_one = std::min(to_one, glm::length(centre - one));
      to_two = std::min(to_two, glm::length(centre - two));
    }
    return to_one <= to_two ? curve : other;
  }

  // About which a sphere's borders wind least: so that its poles lie outside, else in the middle of
  // what they bound.
  [[nodiscard]] glm::dvec3 sphere_axis(std::int32_t region,
                                       const std::vector<LoopPoints>& points) const {
    const AnalyticSurface& s = surface(region);
    if (points.empty()) return s.axis;
    glm::dvec3 middle(0.0);
    for (const std::int32_t f : regions_.regions[region].faces)
      middle += area_vector(positions_, topology_.face(f));
    std::vector<glm::dvec3> candidates;
    const auto add = [&](const glm::dvec3& axis) {
      if (glm::length(axis) > 1e-12) candidates.push_back(glm::normalize(axis));
    };
    const AxisFrame beside(glm::length(middle) > 1e-12 ? glm::normalize(middle) : s.axis);
    for (int i = 0; i < 4; ++i) {
      const double angle = 0.25 * std::numbers::pi * i;
      add(portable::cos(angle) * beside.x + portable::sin(angle) * beside.y);
    }
    for (const LoopPoints& loop : points) {
      glm::dvec3 area(0.0);
      for (std::size_t i = 0; i + 1 < loop.points.size(); ++i)
        area += glm::cross(loop.points[i] - loop.points[0], loop.points[i + 1] - loop.points[0]);
      add(area);
    }
    add(middle);
    for (const glm::dvec3 axis : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)})
      add(axis);
    // All borders without winding and no pole inside; one with, and its pole; two, and no pole.
    for (const std::size_t wanted : {0u, 1u, 2u}) {
      for (const glm::dvec3& axis : candidates) {
        AnalyticSurface turned = s;
        turned.axis = axis;
        std::size_t wound = 0;
        bool is_clear_of_poles = true;
        for (const LoopPoints& loop : points) {
          if (winding(turned, loop, false) != 0) ++wound;
          for (std::size_t i = 0; i + 1 < loop.points.size(); ++i)
            if (passes_pole((loop.points[i] - s.origin) / s.radius,
                            (loop.points[i + 1] - s.origin) / s.radius, axis))
              is_clear_of_poles = false;
        }
        if (wound != wanted || !is_clear_of_poles) continue;
        const int poles = (holds(region, axis) ? 1 : 0) + (holds(region, -axis) ? 1 : 0);
        if (poles == (wanted == 1 ? 1 : 0)) return axis;
      }
    }
    throw NotAnalytic{"borders of a sphere leave no place for its poles"};
  }
  // Whether a chord of the unit sphere comes near the axis.
  [[nodiscard]] static bool passes_pole(const glm::dvec3& from, const glm::dvec3& to,
                                        const glm::dvec3& axis) {
    constexpr double kNear = 0.05;
    const glm::dvec3 a = from - glm::dot(from, axis) * axis,
                     along = to - from - glm::dot(to - from, axis) * axis;
    const double squared = glm::dot(along, along);
    const double part = squared > 0 ? std::clamp(-glm::dot(a, along) / squared, 0.0, 1.0) : 0;
    return glm::length(a + part * along) < kNear;
  }
  // Whether a region of a sphere holds the point in a direction from its centre.
  [[nodiscard]] bool holds(std::int32_t region, const glm::dvec3& direction) const {
    const AnalyticSurface& s = surface(region);
    for (const std::int32_t f : regions_.regions[region].faces) {
      const auto v = topology_.face(f);
      for (std::size_t i = 1; i + 1 < v.size(); ++i) {
        const glm::dvec3 a = positions_[v[0]] - s.origin, b = positions_[v[i]] - s.origin,
                         c = positions_[v[i + 1]] - s.origin;
        const double volume = glm::dot(a, glm::cross(b, c));
        const double x = glm::dot(direction, glm::cross(b, c)) * volume,
                     y = glm::dot(direction, glm::cross(c, a)) * volume,
                     z = glm::dot(direction, glm::cross(a, b)) * volume;
        if (x >= 0 && y >= 0 && z >= 0 && glm::dot(direction, a + b + c) > 0) return true;
      }
    }
    return false;
  }

  std::int32_t add_edge(std::int32_t from, std::int32_t to, BorderCurve curve, std::int32_t left,
                        std::int32_t right) {
    Brep::Edge edge;
    edge.from = from;
    edge.to = to;
    edge.curve = std::move(curve);
    edge.lines[0].face = number_.at(left);
    edge.lines[1].face = number_.at(right);
    brep_.edges.push_back(std::move(edge));
    return static_cast<std::int32_t>(brep_.edges.size()) - 1;
  }

  void make_edges(std::int32_t c) {
    const BorderChain& chain = borders_.chains[c];
    ChainPlan& plan = plans_.at(c);
    if (is_point(chain, plan)) return;
    if (chain.is_closed && plan.splits.empty())
      plan.splits.push_back({0, add_vertex(plan.points[0])});
    // Vertices in order, with their places; of a closed one the first once more.
    std::vector<Split> ends;
    const double last = static_cast<double>(plan.points.size() - 1);
    if (!chain.is_closed) ends.push_back({0, plan.from});
    ends.insert(ends.end(), plan.splits.begin(), plan.splits.end());
    if (chain.is_closed) {
      ends.push_back({plan.splits.front().place + last, plan.splits.front().vertex});
    } else {
      ends.push_back({last, plan.to});
    }
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
      if (plan.is_free) {
        plan.edges.push_back(free_->add_edge(c, ends[i], ends[i + 1], number_.at(chain.left)));
        continue;
      }
      std::vector<glm::dvec3> points{brep_.vertices[ends[i].vertex]};
      const glm::dvec3 target = brep_.vertices[ends[i + 1].vertex];
      for (double k = std::floor(ends[i].place) + 1; k < ends[i + 1].place; ++k) {
        const glm::dvec3& p =
            plan.points[static_cast<std::size_t>(k >= last && chain.is_closed ? k - last : k)];
        if (glm::length(p - points.back()) > 10 * kSamePoint &&
            glm::length(p - target) > 10 * kSamePoint)
          points.push_back(p);
      }
      points.push_back(target);
      const auto curve = curve_along(plan.sides, points);
      if (!curve)
        throw NotAnalytic{"two surfaces do not meet between their vertices",
                          smaller(chain.left, chain.right)};
      plan.edges.push_back(
          add_edge(ends[i].vertex, ends[i + 1].vertex, *curve, chain.left, chain.right));
    }
  }

  [[nodiscard]] std::vector<Brep::Use> uses_of(const std::vector<ChainUse>& loop) const {
    std::vector<Brep::Use> uses;
    for (const ChainUse& use : loop) {
      const auto& edges = plans_.at(use.chain).edges;
      for (std::size_t i = 0; i < edges.size(); ++i)
        uses.push_back({edges[use.is_reversed ? edges.size() - 1 - i : i], use.is_reversed});
    }
    return uses;
  }
  [[nodiscard]] std::int32_t start_of(const Brep::Use& use) const {
    const Brep::Edge& edge = brep_.edges[use.edge];
    return use.is_reversed ? edge.to : edge.from;
  }
  // The loop's uses from a vertex on.
  [[nodiscard]] std::vector<Brep::Use> from_vertex(std::vector<Brep::Use> uses,
                                                   std::int32_t vertex) const {
    const auto found =
        std::ranges::find_if(uses, [&](const Brep::Use& use) { return start_of(use) == vertex; });
    if (found == uses.end()) throw NotAnalytic{"a seam ends on no border"};
    std::ranges::rotate(uses, found);
    return uses;
  }

  // Where a face's angle begins: at its seam, where OpenCASCADE wants it, else opposite its middle.
  [[nodiscard]] glm::dvec3 along_of(const AnalyticSurface& s, std::int32_t region) const {
    const auto across = [&](const glm::dvec3& p) {
      const glm::dvec3 from = p - s.origin;
      return from - glm::dot(from, s.axis) * s.axis;
    };
    const FacePlan& plan = faces_.at(region);
    glm::dvec3 wanted(0.0);
    if (!plan.seams.empty() && s.kind != AnalyticKind::Sphere)
      wanted = across(brep_.vertices[brep_.edges[plan.seams[0].edge].from]);
    if (s.kind == AnalyticKind::Sphere && !plan.seams.empty()) {
      // Poles are on the axis, the middle of the seam is not.
      const Brep::Edge& seam = brep_.edges[plan.seams[0].edge];
      const auto places =
          places_along(*seam.curve, brep_.vertices[seam.from], brep_.vertices[seam.to]);
      wanted = across(places[places.size() / 2]);
    }
    if (plan.seams.empty())
      for (const std::int32_t f : regions_.regions[region].faces)
        for (const std::int32_t v : topology_.face(f)) wanted -= across(positions_[v]);
    constexpr double kLeast = 1e-9;
    return glm::length(wanted) > kLeast ? glm::normalize(wanted) : AxisFrame(s.axis).x;
  }

  void make_face(std::int32_t region) {
    const AnalyticRegion& r = regions_.regions[region];
    const FacePlan& plan = faces_[region];
    Brep::Face face;
    face.surface = r.surface;
    face.is_inward = r.is_inward;
    if (const auto axis = axes_.find(region); axis != axes_.end())
      face.surface->axis = axis->second;
    face.along = along_of(*face.surface, region);
    std::vector<std::vector<Brep::Use>> loops;
    const auto& given = borders_.loops[region];
    std::vector<char> is_done(given.size(), 0);
    for (const Seam& seam : plan.seams) {
      if (plan.is_whole_torus) break;
      const Brep::Edge& edge = brep_.edges[seam.edge];
      std::vector<Brep::Use> loop;
      const auto append = [&](std::int32_t index, std::int32_t vertex) {
        if (index < 0) return;
        const auto uses = from_vertex(uses_of(given[index]), vertex);
        loop.insert(loop.end(), uses.begin(), uses.end());
        is_done[index] = 1;
      };
      append(seam.from_loop, edge.from);
      loop.push_back({seam.edge, false});
      append(seam.to_loop, edge.to);
      loop.push_back({seam.edge, true});
      loops.push_back(std::move(loop));
    }
    if (plan.is_whole_torus) {
      const std::int32_t u = plan.seams[0].edge, v = plan.seams[1].edge;
      loops.push_back({{u, false}, {v, false}, {u, true}, {v, true}});
    }
    for (std::size_t l = 0; l < given.size(); ++l)
      if (is_done[l] == 0) loops.push_back(uses_of(given[l]));
    // The first is the outer one: the largest, where no seam makes it.
    if (plan.seams.empty()) {
      std::vector<double> sizes;
      for (const auto& loop : given) {
        const LoopPoints points = points_of(loop);
        glm::dvec3 low = points.points[0], high = low;
        for (const glm::dvec3& p : points.points) {
          low = glm::min(low, p);
          high = glm::max(high, p);
        }
        sizes.push_back(glm::length(high - low));
      }
      const auto largest = std::ranges::max_element(sizes) - sizes.begin();
      std::swap(loops[0], loops[static_cast<std::size_t>(largest)]);
    }
    face.loop = std::move(loops[0]);
    face.holes.assign(std::make_move_iterator(loops.begin() + 1),
                      std::make_move_iterator(loops.end()));
    brep_.faces.push_back(std::move(face));
  }

  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  const Placement& placement_;
  const AnalyticRegions& regions_;
  const RegionBorders& borders_;
  const SettledRegions& settled_;
  const FreeformFaces* freeform_;
  Brep& brep_;
  bool is_trial_ = false;
  std::vector<std::int32_t> in_the_way_;
  std::optional<FreeformSide> free_;
  std::map<std::int32_t, std::int32_t> number_;  // of faces of the part, by region
  std::vector<std::int32_t> chains_;
  std::map<std::int32_t, ChainPlan> plans_;
  std::map<std::int32_t, FacePlan> faces_;
  std::map<std::int32_t, glm::dvec3> axes_;  // of spheres
  std::map<std::int32_t, std::int32_t> vertex_of_;
};

}  // namespace

std::vector<std::int32_t> regions_in_the_way(const AnalyticParts& found,
                                             const MeshTopology& topology,
                                             std::span<const std::int32_t> regions) {
  Brep brep;
  return PartBuilder(found, topology, nullptr, brep).try_regions(regions);
}

Brep analytic_part(const AnalyticParts& found, const MeshTopology& topology,
                   std::span<const std::int32_t> regions, const FreeformFaces* freeform,
                   std::span<const std::int32_t> freeform_faces) {
  Brep brep;
  PartBuilder(found, topology, freeform, brep).build(regions, freeform_faces);
  return brep;
}

}  // namespace planish
