#include "proto/json/node_json.h"

#include "proto/json/strict_json.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

/// Leaves `out` empty where the key is missing.
Status read_numbers(const Json& object, const char* key, std::size_t count,
                    std::vector<double>& out) {
  const auto found = object.find(key);
  if (found == object.end()) return success();
  const std::string place = below("", key);
  if (!found->is_array()) return fault("TYPE_WRONG", "this must be an array", place);
  if (found->size() != count) {
    return fault(
        "LENGTH_WRONG",
        "this has " + std::to_string(found->size()) + " numbers, not " + std::to_string(count),
        place);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!(*found)[i].is_number()) {
      return fault("TYPE_WRONG", "this must be a number", below(place, std::to_string(i)));
    }
    out.push_back((*found)[i].get<double>());
  }
  return success();
}

}  // namespace

Result<NodePatch> decode_node_patch(std::string_view body) {
  const auto document = parse_strictly(body);
  if (!document) return document.error();
  Status status =
      check_object(*document, "", {"matrix", "translation", "rotation", "scale", "hidden", "mask"});
  if (!status) return std::move(status).error();
  NodePatch patch;
  for (const auto& [key, count, numbers] :
       {std::tuple{"matrix", 16, &patch.matrix}, std::tuple{"translation", 3, &patch.translation},
        std::tuple{"rotation", 4, &patch.rotation}, std::tuple{"scale", 3, &patch.scale}}) {
    status = read_numbers(*document, key, static_cast<std::size_t>(count), *numbers);
    if (!status) return std::move(status).error();
    if (!patch.matrix.empty() && numbers != &patch.matrix && !numbers->empty()) {
      return fault("KEYS_MIXED", "a node has a matrix, or translation, rotation and scale",
                   below("", key));
    }
  }
  if (const auto hidden = document->find("hidden"); hidden != document->end()) {
    if (!hidden->is_boolean()) return fault("TYPE_WRONG", "this must be true or false", "/hidden");
    patch.hidden = hidden->get<bool>();
  }
  if (const auto mask = document->find("mask"); mask != document->end()) {
    if (!mask->is_number()) return fault("TYPE_WRONG", "this must be a number", "/mask");
    if (!mask->is_number_unsigned() || mask->get<std::uint64_t>() > 0xffffffffu) {
      return fault("NUMBER_OUT_OF_RANGE", "a mask is 0 to 4294967295", "/mask");
    }
    patch.mask = mask->get<std::uint32_t>();
  }
  if (document->empty()) return fault("KEY_MISSING", "nothing is to be different", "");
  return patch;
}

}  // namespace sightline
