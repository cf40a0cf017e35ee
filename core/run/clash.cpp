#include "core/run/clash.h"

#include <algorithm>
#include <array>
#include <tuple>

#include "core/base/infinity.h"
#include "core/run/engine_state.h"
#include "core/trace/search/clearance.h"

namespace sightline {
namespace {

using Place = std::tuple<double, double, double>;

/// Corners in order, so that equal triangles compare equal.
std::array<Place, 3> sorted(const Triangle& t) {
  std::array<Place, 3> corners{Place{t.v0.x, t.v0.y, t.v0.z}, Place{t.v1.x, t.v1.y, t.v1.z},
                               Place{t.v2.x, t.v2.y, t.v2.z}};
  std::sort(corners.begin(), corners.end());
  return corners;
}

std::vector<std::array<Place, 3>> sorted(const std::vector<Triangle>& triangles) {
  std::vector<std::array<Place, 3>> all;
  all.reserve(triangles.size());
  for (const Triangle& t : triangles) all.push_back(sorted(t));
  std::sort(all.begin(), all.end());
  return all;
}

bool contains(const Box3d& outer, const Box3d& inner) {
  for (int k = 0; k < 3; ++k) {
    if (inner.min[k] < outer.min[k] || inner.max[k] > outer.max[k]) return false;
  }
  return true;
}

}  // namespace

NodeClashes::NodeClashes(const Engine& engine, const Scene& scene, const Side& a, const Side& b,
                         const ClearanceQuestion& question, const Deadline& deadline)
    : engine_(engine),
      scene_(scene),
      a_(a),
      b_(b),
      question_(question),
      deadline_(deadline),
      is_alike_(&a.group == &b.group),
      bodies_a_(bodies_of(scene, a.group)),
      bodies_b_(is_alike_ ? Bodies() : bodies_of(scene, b.group)) {}

NodeClashes::Bodies NodeClashes::bodies_of(const Scene& scene, const TriangleGroup& group) {
  Bodies bodies;
  for (std::uint32_t i = 0; i < group.size(); ++i) {
    const Triangle triangle = group.triangle(i);
    Body& body = bodies[scene.description().instances[group.id(i).instance].node];
    body.triangles.push_back(triangle);
    for (const Vec3d& corner : {triangle.v0, triangle.v1, triangle.v2}) body.box.include(corner);
  }
  return bodies;
}

ResolvedFilter NodeClashes::only(const Side& side, std::uint32_t node) const {
  ResolvedFilter some = side.resolved;
  const auto& instances = scene_.description().instances;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (instances[i].node == node) continue;
    const std::size_t end = i + 1 < some.first.size() ? some.first[i + 1] : some.sides.size();
    std::fill(some.sides.begin() + static_cast<std::ptrdiff_t>(some.first[i]),
              some.sides.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{0});
  }
  return some;
}

Result<bool> NodeClashes::is_inside(const Body& body, const Side& side, std::uint32_t node) const {
  Column<Vec3d> corners;
  for (const Triangle& t : body.triangles) corners.insert(corners.end(), {t.v0, t.v1, t.v2});
  const auto key = [](const Vec3d& p) { return Place{p.x, p.y, p.z}; };
  std::sort(corners.begin(), corners.end(),
            [&](const Vec3d& p, const Vec3d& q) { return key(p) < key(q); });
  corners.erase(std::unique(corners.begin(), corners.end(),
                            [&](const Vec3d& p, const Vec3d& q) { return key(p) == key(q); }),
                corners.end());
  const ResolvedFilter resolved = only(side, node);
  InsideAnswers answers;
  const Status status = engine_.inside(scene_, corners, InsideMethod::kParity, deadline_, answers,
                                       {.resolved = &resolved});
  if (!status) return status.error();
  if (answers.open_edges != 0) return false;
  bool has_inner = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (answers.inside[i] == 0 && answers.on_surface[i] == 0) return false;
    has_inner = has_inner || answers.inside[i] != 0;
  }
  return has_inner;
}

const std::optional<ConvexBody>& NodeClashes::convex(Body& body) {
  if (!body.convex) body.convex = ConvexBody::of(body.triangles);
  return *body.convex;
}

Status NodeClashes::classify(ClearancePair& pair, std::uint32_t a, std::uint32_t b) {
  Body &of_a = bodies_a_.at(a), &of_b = this->of_b().at(b);
  if (Status status = find_kind(pair, of_a, a, of_b, b); !status) return status;
  const bool is_inside = pair.kind == ClashKind::kAInB || pair.kind == ClashKind::kBInA;
  if ((pair.distance != 0 && !is_inside) || !convex(of_a) || !convex(of_b)) return success();
  const auto depth = penetration_depth(*convex(of_a), *convex(of_b), deadline_);
  if (!depth) return out_of_time(deadline_);
  pair.depth = depth->rounded();
  // Interiors may overlap although triangles only touch: boxes with faces in common planes.
  if (pair.kind == ClashKind::kTouching && depth->square.sign() > 0)
    pair.kind = ClashKind::kCrossing;
  return success();
}

Status NodeClashes::find_kind(ClearancePair& pair, const Body& of_a, std::uint32_t a,
                              const Body& of_b, std::uint32_t b) const {
  const bool is_in_a = contains(of_a.box, of_b.box), is_in_b = contains(of_b.box, of_a.box);
  if (pair.distance == 0 && is_in_a && is_in_b && of_a.triangles.size() == of_b.triangles.size() &&
      sorted(of_a.triangles) == sorted(of_b.triangles)) {
    pair.kind = ClashKind::kDuplicate;
    return success();
  }
  if (pair.triangles_cross) return success();
  for (const bool is_a_inner : {true, false}) {
    if (!(is_a_inner ? is_in_b : is_in_a)) continue;
    const auto inside = is_a_inner ? is_inside(of_a, b_, b) : is_inside(of_b, a_, a);
    if (!inside) return inside.error();
    if (!*inside) continue;
    pair.kind = is_a_inner ? ClashKind::kAInB : ClashKind::kBInA;
    return success();
  }
  return success();
}

Status NodeClashes::add_inside(std::uint32_t a, std::uint32_t b, ClearanceAnswer& answer) {
  ClearancePair pair;
  pair.distance = kInf;  // the surfaces do not meet; the search below finds how far they are
  if (Status status = classify(pair, a, b); !status) return status;
  if (pair.kind == ClashKind::kApart) return success();
  const ResolvedFilter in_a = only(a_, a), in_b = only(b_, b);
  const TriangleGroup group_a(scene_, in_a, deadline_), group_b(scene_, in_b, deadline_);
  Clearance search(scene_, group_a, group_b, deadline_);
  if (!deadline_.passed()) search.find({}, question_.total_max);
  if (search.stopped() || deadline_.passed()) return out_of_time(deadline_);
  ClearanceAnswer closest;
  search.write(1, closest);
  closest.pairs[0].kind = pair.kind;
  closest.pairs[0].depth = pair.depth;
  answer.pairs.push_back(closest.pairs[0]);
  return success();
}

Status NodeClashes::complete(ClearanceAnswer& answer) {
  const auto& instances = scene_.description().instances;
  const auto nodes_of = [&](const ClearancePair& pair) {
    return std::pair(instances[pair.a.instance].node, instances[pair.b.instance].node);
  };
  const std::size_t within = answer.pairs.size();
  for (ClearancePair& pair : answer.pairs) {
    const auto [a, b] = nodes_of(pair);
    if (Status status = classify(pair, a, b); !status) return status;
  }
  // The pairs within the distance are sorted by nodes.
  std::size_t next = 0;
  std::uint64_t all = 0;
  for (const auto& [a, of_a] : bodies_a_) {
    for (const auto& [b, other] : of_b()) {
      if (!may_pair_nodes(scene_.description(), question_, is_alike_, a, b)) continue;
      ++all;
      if (next < within && nodes_of(answer.pairs[next]) == std::pair(a, b)) {
        ++next;
        continue;
      }
      if (deadline_.passed()) return out_of_time(deadline_);
      if (!contains(of_a.box, other.box) && !contains(other.box, of_a.box)) continue;
      if (Status status = add_inside(a, b, answer); !status) return status;
      if (answer.pairs.size() > question_.total_max) {
        return Error{ErrorKind::kTooLarge, "TOO_MANY_HITS",
                     "more than " + std::to_string(question_.total_max) + " pairs", ""};
      }
    }
  }
  std::sort(
      answer.pairs.begin(), answer.pairs.end(),
      [&](const ClearancePair& x, const ClearancePair& y) { return nodes_of(x) < nodes_of(y); });
  answer.total = answer.pairs.size();
  answer.kinds = {};
  for (const ClearancePair& pair : answer.pairs)
    ++answer.kinds[static_cast<std::size_t>(pair.kind)];
  answer.kinds[static_cast<std::size_t>(ClashKind::kApart)] = all - answer.total;
  if (answer.pairs.size() > question_.limit) answer.pairs.resize(question_.limit);
  return success();
}

}  // namespace sightline
