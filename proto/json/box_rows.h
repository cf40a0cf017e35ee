#pragma once
/// BoxRows: reads boxes and other shapes from JSON, for all box queries. For files of this room
/// only.
///
///   {"min":[x,y,z],"max":[x,y,z]}                          closed; null leaves a side open
///   {"center":[x,y,z],"half":[x,y,z],"rotation":[x,y,z,w]} rotation: a unit quaternion
///   {"center":[x,y,z],"half":[x,y,z],"axes":[[x,y,z],[x,y,z],[x,y,z]]}  see OrientedBox
/// If the query allows shapes:
///   {"center":[x,y,z],"radius":r}                          a sphere
///   {"from":[x,y,z],"to":[x,y,z],"radius":r}               a capsule
///   {"planes":[[nx,ny,nz,d],...]}                          the points with n . p <= d for all
///   {"hull":[[x,y,z],...]}                                 the convex hull of the points
///   {"corners":[[x,y,z],...]}                              eight corners: see frustum_of
///   {"view":{"kind":"pinhole",...}}                        what a camera sees (generator_json.h)
/// If the answer is lists, a member of any of these:
///   "cursor":"..."                                         where the list of this box continues

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/query/box_batch.h"
#include "proto/file_camera.h"
#include "proto/json/json_reader.h"
#include "proto/json/list_cursor.h"

namespace sightline {

/// Reads the value of "boxes" of one body: read() once, then take_cursors() and
/// take_shape_hashes().
class BoxRows {
 public:
  /// Which shapes are allowed: boxes; all shapes; all shapes with cursors.
  enum class Takes : std::uint8_t { kBoxes, kShapes, kCursors };

  /// reader       gets the errors; must outlive this object
  /// most         the most boxes
  /// find_camera  null if there is no scene
  BoxRows(JsonReader& reader, std::size_t most, Takes takes, FindCamera find_camera = {})
      : reader_(reader), most_(most), takes_(takes), find_camera_(std::move(find_camera)) {}

  /// Reads "boxes" and checks them. Returns false if the reader has an error. Errors, 422:
  /// KEY_UNKNOWN, KEY_DUPLICATE, KEY_MISSING, KEYS_MIXED, TYPE_WRONG, LENGTH_WRONG,
  /// NUMBER_NOT_FINITE, BOX_ROTATION_NOT_UNIT, CURSOR_UNKNOWN, those of views (GeneratorReader,
  /// view_frustum.h) and corners (BOX_CORNERS), and the codes of check_boxes. 413: BOXES_TOO_MANY.
  bool read(JsonReader::Value value, BoxBatch& boxes);
  /// Moves the cursors out: one for each box if any box has one, else none.
  Column<ListCursor> take_cursors() { return std::move(cursors_); }
  /// Moves out a hash of the shape of each box, if cursors are allowed, else none. Different shapes
  /// almost surely have different hashes.
  Column<std::uint64_t> take_shape_hashes() { return std::move(shape_hashes_); }

 private:
  enum class Form : std::uint8_t { kCorners, kRotation, kAxes, kOther };
  struct Row;

  static std::uint64_t hash_of_shape(const Row& row);
  bool read_row(std::size_t box, JsonReader::Value value, BoxBatch& boxes);
  bool read_part(std::size_t box, std::size_t which, JsonReader::Value value, Row& row);
  bool read_planes(JsonReader::Value value, const JsonPointer& place, Row& row);
  bool read_hull(JsonReader::Value value, const JsonPointer& place, Row& row);
  bool read_corners(JsonReader::Value value, const JsonPointer& place, Row& row);
  bool read_view(JsonReader::Value value, const JsonPointer& place, Row& row);
  bool take_planes(const Result<std::vector<HalfSpace>>& planes, const JsonPointer& place,
                   Row& row);
  bool read_cursor(JsonReader::Value value, const JsonPointer& place, std::size_t box);
  bool finish_row(std::size_t box, const Row& row, BoxBatch& boxes);
  bool finish_round(std::size_t box, const Row& row, BoxBatch& boxes);

  JsonReader& reader_;
  std::size_t most_;
  Takes takes_;
  const FindCamera find_camera_;
  Column<ListCursor> cursors_;
  Column<std::uint64_t> shape_hashes_;
  Column<Form> forms_;
};

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
