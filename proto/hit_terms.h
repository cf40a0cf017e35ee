#pragma once
/// Layouts of an answer, and the meaning of its hits in terms of the scene's file.

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/column.h"
#include "core/query/hit_batch.h"

namespace sightline {

enum class AnswerLayout {
  kRows,     ///< {"hits":[{"t":5,"triangle":12}, null]}
  kColumns,  ///< {"t":[5,null],"triangle":[12,-1]}
  kBinary,   ///< the same as bytes: hit_binary.h
  kImage,    ///< a picture: hit_image.h
  kLines,    ///< {"t":5,"triangle":12}\nnull\n: hit_lines.h
};

/// What hits mean in the file's own terms and units. Columns of n slots, one for each hit; a column
/// whose field is not asked for may be empty. Numbers that do not apply are kNone, names that the
/// file does not give are empty. Names live elsewhere, as long as the scene.
struct HitTerms {
  Column<std::uint32_t> primitive, triangle, node, mesh, material, node_instance;
  std::vector<std::string_view> node_name, node_path, mesh_name, material_name;
  HitAttributes attributes;
  Column<double> distance;       ///< t * |direction|
  bool t_is_distance = false;    ///< what stands as t is the distance too
  Column<std::uint32_t> visits;  ///< of a picture: boxes that each ray was tested with
  /// that node_path refers to; moving this struct moves none of them
  std::deque<std::string> own_texts;
};

}  // namespace sightline
