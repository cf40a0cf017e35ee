#pragma once
/// Boxes as JSON, strictly: what both kinds of box queries read. For files of this room only.
///
///   {"min":[x,y,z],"max":[x,y,z]}                          closed; null leaves a side open
///   {"center":[x,y,z],"half":[x,y,z],"rotation":[x,y,z,w]} a unit quaternion
///   {"center":[x,y,z],"half":[x,y,z],"axes":[[x,y,z],[x,y,z],[x,y,z]]}  as OrientedBox has them
///   {"center":[x,y,z],"radius":r}                          a sphere, where a query takes them

#include <cstddef>
#include <cstdint>

#include "core/query/box_batch.h"
#include "proto/json_reader.h"

namespace sightline {

class BoxRows {
 public:
  /// The reader outlives this object and gets the errors.
  BoxRows(JsonReader& reader, std::size_t most, bool takes_spheres)
      : reader_(reader), most_(most), takes_spheres_(takes_spheres) {}

  /// Reads the value of "boxes" and checks it.
  /// Errors, 422: KEY_UNKNOWN, KEY_DUPLICATE, KEY_MISSING, KEYS_MIXED, TYPE_WRONG, LENGTH_WRONG,
  /// NUMBER_NOT_FINITE, BOX_ROTATION_NOT_UNIT and the codes of check_boxes. 413: BOXES_TOO_MANY.
  bool read(JsonReader::Value value, BoxBatch& boxes);

 private:
  enum class Form : std::uint8_t { kCorners, kRotation, kAxes, kSphere };
  struct Row;

  bool read_row(std::size_t box, JsonReader::Value value, BoxBatch& boxes);
  bool read_part(std::size_t box, std::size_t which, JsonReader::Value value, Row& row);
  bool finish_row(std::size_t box, const Row& row, BoxBatch& boxes);
  bool read_numbers(JsonReader::Value value, const JsonPointer& place, double* out, int count,
                    bool may_be_open, double open);

  JsonReader& reader_;
  std::size_t most_;
  bool takes_spheres_;
  Column<Form> forms_;
};

}  // namespace sightline
