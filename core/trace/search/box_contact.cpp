#include "core/trace/search/box_contact.h"

#include <type_traits>

namespace sightline {

BoxContactSearch::BoxContactSearch(const BoxBatch& boxes, std::size_t box, const Deadline& deadline)
    : boxes_(boxes), box_(box), deadline_(deadline) {
  boxes_.visit(box, [&](const auto& shape) {
    if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, PointHull>)
      hull_ = ConvexHull(shape).parts();
  });
}

std::optional<ShapeContact> BoxContactSearch::with(const Triangle& triangle) const {
  if (deadline_.passed()) return std::nullopt;
  return boxes_.visit(box_, [&](const auto& shape) -> std::optional<ShapeContact> {
    using Shape = std::decay_t<decltype(shape)>;
    if constexpr (std::is_same_v<Shape, PointHull>) {
      return contact_of(hull_, triangle, deadline_);
    } else if constexpr (std::is_same_v<Shape, ConvexRegion>) {
      return std::nullopt;
    } else {
      return contact_of(shape, triangle);
    }
  });
}

}  // namespace sightline
