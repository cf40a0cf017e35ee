#pragma once
/// HitTerms: hits in terms of the scene's file. AnswerLayout: the formats of an answer.

#include <cstdint>
#include <list>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/column.h"
#include "core/query/hit_batch.h"
#include "core/query/query_work.h"

namespace sightline {

/// The formats of an answer.
enum class AnswerLayout {
  kRows,     ///< {"hits":[{"t":5,"triangle":12}, null]}
  kColumns,  ///< {"t":[5,null],"triangle":[12,-1]}
  kBinary,   ///< columns as bytes: hit_binary.h
  kImage,    ///< an image: hit_image.h
  kTable,    ///< a table for other programs: hit_table.h
  kLines,    ///< one line for each ray, {"t":5,"triangle":12}\nnull\n: hit_lines.h
};

/// The names, indices and other terms of n hits as columns of n slots. A column whose field is not
/// requested may be empty. An index is kNone if it does not apply; a name is empty if the file has
/// none. The names refer to texts of the scene, which must outlive this struct.
struct HitTerms {
  /// Indices in the file: of the primitive in its mesh, and of the triangle in its primitive.
  Column<std::uint32_t> primitive, triangle;
  /// Indices in the file's lists of nodes, meshes and materials.
  Column<std::uint32_t> node, mesh, material;
  /// Index of the instance among those of its node; 0 unless the node has several.
  Column<std::uint32_t> node_instance;
  std::vector<std::string_view> node_name, node_path, mesh_name, material_name;
  RayCosts costs;              ///< of the ray of each hit, and of misses
  HitAttributes attributes;    ///< interpolated vertex attributes of the file
  Column<double> distance;     ///< t * |direction|
  bool t_is_distance = false;  ///< the distance is also answered as t
  /// The texts to which node_path refers. Moving this struct does not move them.
  std::list<std::string> own_texts;
};

}  // namespace sightline
