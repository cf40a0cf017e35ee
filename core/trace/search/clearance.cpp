#include "core/trace/search/clearance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/triangle_crossing.h"
#include "core/geometry/triangle_distance.h"

namespace sightline {

namespace {

/// At most the distance of two boxes. Parts of the largest gap: nothing overflows.
double box_gap(const Box3d& a, const Box3d& b) {
  std::array<double, 3> gap{};
  double most = 0, sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double apart = std::max({0.0, a.min[k] - b.max[k], b.min[k] - a.max[k]});
    gap[static_cast<std::size_t>(k)] = apart;
    most = std::max(most, apart);
  }
  if (most == 0) return 0;
  for (const double g : gap) sum += (g / most) * (g / most);
  return std::min(most * (std::sqrt(sum) * (1 - 0x1p-48)), 0x1.fffffffffffffp1023);
}

double size_of(const Box3d& box) {
  return std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
}

}  // namespace

/// Pairs that are farther are of no interest.
double Clearance::reach() const {
  return question_.pairs == ClearancePairs::kClosest && closest_
             ? std::min(question_.max_distance, closest_->range.high)
             : question_.max_distance;
}

bool Clearance::is_of_interest(const TriangleGroup::Node& a, const TriangleGroup::Node& b) const {
  if (box_gap(a.box, b.box) > reach()) return false;
  // Where two meet, only smaller ids are better.
  return question_.pairs != ClearancePairs::kClosest || !closest_ || !closest_->is_zero ||
         std::pair(a.least, b.least) < closest_->ids();
}

void Clearance::find(const ClearanceQuestion& question, std::uint64_t most) {
  question_ = question;
  most_ = most;
  if (a_.empty() || b_.empty()) return;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> stack{{0, 0}};
  while (!stack.empty() && !too_many_) {
    const auto [i, j] = stack.back();
    stack.pop_back();
    const TriangleGroup::Node &a = a_.node(i), &b = b_.node(j);
    if (!is_of_interest(a, b)) continue;
    // Two leaves may take some milliseconds.
    if (++counts_.nodes % 8 == 0 && deadline_.passed()) stopped_ = true;
    if (stopped_) return;
    if (a.child == 0 && b.child == 0) {
      look_at_leaves(a, b);
      continue;
    }
    // The larger one is opened, and the nearer half of it tested first.
    const bool opens_a = b.child == 0 || (a.child != 0 && size_of(a.box) >= size_of(b.box));
    std::pair<std::uint32_t, std::uint32_t> first{opens_a ? a.child : i, opens_a ? j : b.child};
    std::pair<std::uint32_t, std::uint32_t> second{opens_a ? a.child + 1 : i,
                                                   opens_a ? j : b.child + 1};
    if (box_gap(a_.node(second.first).box, b_.node(second.second).box) <
        box_gap(a_.node(first.first).box, b_.node(first.second).box)) {
      std::swap(first, second);
    }
    stack.push_back(second);
    stack.push_back(first);
  }
}

bool may_pair_nodes(const SceneDescription& scene, const ClearanceQuestion& question, bool is_alike,
                    std::uint32_t a, std::uint32_t b) {
  if (!question.self && (a == b || (is_alike && b < a))) return false;
  return question.adjacent || (scene.nodes[a].parent != b && scene.nodes[b].parent != a);
}

void Clearance::look_at_leaves(const TriangleGroup::Node& a, const TriangleGroup::Node& b) {
  std::array<Triangle, TriangleGroup::kLeafMembers> of_b;
  for (std::uint32_t j = 0; j < b.count; ++j) of_b[j] = b_.triangle(b.first + j);
  for (std::uint32_t i = a.first; i < a.first + a.count; ++i) {
    const Triangle of_a = a_.triangle(i);
    for (std::uint32_t j = 0; j < b.count; ++j) {
      Found found{a_.id(i), b_.id(b.first + j), {}, nullptr};
      if (!may_pair_nodes(scene_.description(), question_, &a_ == &b_, node_of(found.a),
                          node_of(found.b))) {
        continue;
      }
      if (question_.pairs == ClearancePairs::kClosest && closest_ && closest_->is_zero &&
          closest_->ids() < found.ids()) {
        continue;
      }
      found.range = distance_range(corners_of(of_a), corners_of(of_b[j]));
      if (found.range.low <= reach() && is_within(found)) offer(std::move(found));
      if (too_many_) return;
    }
  }
}

std::uint32_t Clearance::node_of(TriangleId triangle) const {
  return scene_.description().instances[triangle.instance].node;
}

const ExactDistance& Clearance::exact_of(Found& found) {
  if (!found.exact) {
    ++counts_.decisions.exact_compares;
    found.exact = std::make_unique<const ExactDistance>(
        exact_distance(corners_of(scene_.world_triangle(found.a)), scene_.world_triangle(found.b)));
    found.is_zero = found.exact->square.sign() == 0;
    if (found.is_zero) found.range = {0, 0};
  }
  return *found.exact;
}

bool Clearance::is_within(Found& found) {
  if (found.range.high <= question_.max_distance) return true;
  return compare(exact_of(found), question_.max_distance) <= 0;
}

bool Clearance::comes_before(Found& x, Found& y) {
  if (x.range.high < y.range.low) return true;
  if (y.range.high < x.range.low) return false;
  // What is known to be zero is not worked out again.
  for (Found* each : {&x, &y}) {
    if (!each->is_zero) exact_of(*each);
  }
  const int order =
      x.is_zero || y.is_zero ? int{y.is_zero} - int{x.is_zero} : compare(exact_of(x), exact_of(y));
  return order != 0 ? order < 0 : x.ids() < y.ids();
}

void Clearance::offer(Found found) {
  switch (question_.pairs) {
    case ClearancePairs::kClosest:
      if (!closest_ || comes_before(found, *closest_)) closest_ = std::move(found);
      // Whether they meet decides what is tested next.
      if (closest_->range.low == 0) exact_of(*closest_);
      return;
    case ClearancePairs::kTriangles:
      // Large numbers are of use no more.
      found.exact.reset();
      all_.push_back(std::move(found));
      too_many_ = all_.size() > most_;
      return;
    case ClearancePairs::kNodes: {
      const std::pair nodes{node_of(found.a), node_of(found.b)};
      const auto known = by_nodes_.find(nodes);
      const bool crosses =
          (known != by_nodes_.end() && known->second.crosses) ||
          (question_.kinds && found.range.low == 0 &&
           triangles_cross(scene_.world_triangle(found.a), scene_.world_triangle(found.b)));
      const auto [place, is_new] = by_nodes_.try_emplace(nodes, std::move(found));
      // What was not taken has not been moved from.
      if (!is_new && comes_before(found, place->second)) place->second = std::move(found);
      place->second.crosses = crosses;
      // There may be millions of pairs: large numbers are worked out again where two are as near.
      place->second.exact.reset();
      too_many_ = by_nodes_.size() > most_;
      return;
    }
  }
}

void Clearance::write(std::uint64_t limit, ClearanceAnswer& answer) const {
  std::vector<const Found*> found;
  if (closest_) found.push_back(&*closest_);
  for (const Found& each : all_) found.push_back(&each);
  std::sort(found.begin(), found.end(),
            [](const Found* x, const Found* y) { return x->ids() < y->ids(); });
  for (const auto& [nodes, each] : by_nodes_) found.push_back(&each);
  answer.total = found.size();
  if (found.size() > limit) found.resize(limit);
  answer.pairs.clear();
  for (const Found* each : found) {
    const Triangle a = scene_.world_triangle(each->a), b = scene_.world_triangle(each->b);
    const NearestPair near = nearest_pair(corners_of(a), b);
    const double distance = exact_distance(corners_of(a), b).rounded();
    answer.pairs.push_back({each->a, each->b, distance, near.on_a, near.on_b});
    ClearancePair& pair = answer.pairs.back();
    pair.triangles_cross = each->crosses;
    pair.kind = each->crosses        ? ClashKind::kCrossing
                : pair.distance == 0 ? ClashKind::kTouching
                                     : ClashKind::kNear;
  }
}

}  // namespace sightline
