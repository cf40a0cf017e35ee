#pragma once
/// BoxContactSearch: the contacts of a shape of a box query with triangles that it meets.

#include <cstddef>
#include <optional>

#include "core/base/deadline.h"
#include "core/geometry/convex/shape_contact.h"
#include "core/query/box_batch.h"

namespace sightline {

/// The contacts of one shape with one triangle after the other. The batch and the deadline must
/// outlive this object.
class BoxContactSearch {
 public:
  /// Finds the faces of a hull. Precondition: shape `box` is no convex region. Throws
  /// std::bad_alloc.
  BoxContactSearch(const BoxBatch& boxes, std::size_t box, const Deadline& deadline);

  /// The contact with a triangle that the shape meets. Empty if the deadline passed. Throws
  /// std::bad_alloc.
  std::optional<ShapeContact> with(const Triangle& triangle) const;

 private:
  const BoxBatch& boxes_;
  const std::size_t box_;
  const Deadline& deadline_;
  BodyParts hull_;
};

}  // namespace sightline

// Tests: tests/integration/boxes_test.py
