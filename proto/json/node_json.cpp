#include "proto/json/node_json.h"

#include <cmath>
#include <limits>
#include <tuple>
#include <unordered_set>

#include "proto/json/strict_json.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

/// Leaves `out` empty where the key is missing. `count` 0: any number of them.
Status read_numbers(const Json& object, const std::string& at, const char* key, std::size_t count,
                    std::vector<double>& out) {
  const auto found = object.find(key);
  if (found == object.end()) return success();
  const std::string place = below(at, key);
  if (!found->is_array()) return fault("TYPE_WRONG", "this must be an array", place);
  if (count > 0 && found->size() != count) {
    return fault(
        "LENGTH_WRONG",
        "this has " + std::to_string(found->size()) + " numbers, not " + std::to_string(count),
        place);
  }
  for (std::size_t i = 0; i < found->size(); ++i) {
    if (!(*found)[i].is_number()) {
      return fault("TYPE_WRONG", "this must be a number", below(place, std::to_string(i)));
    }
    out.push_back((*found)[i].get<double>());
  }
  return success();
}

/// Leaves `out` as it is where the key is missing.
template <class Out>
Status read_uint32(const Json& object, const std::string& at, const char* key, const char* what,
                   Out& out) {
  const auto found = object.find(key);
  if (found == object.end()) return success();
  const std::string place = below(at, key);
  if (!found->is_number()) return fault("TYPE_WRONG", "this must be a number", place);
  if (!found->is_number_unsigned() || found->get<std::uint64_t>() > 0xffffffffu) {
    return fault("NUMBER_OUT_OF_RANGE", std::string(what) + " is 0 to 4294967295", place);
  }
  out = found->get<std::uint32_t>();
  return success();
}

Status read_weights(const Json& object, const std::string& at, NodePatch& patch) {
  Status status = read_numbers(object, at, "weights", 0, patch.weights);
  if (!status || !object.contains("weights")) return status;
  const std::string place = below(at, "weights");
  if (patch.weights.empty()) return fault("LENGTH_WRONG", "this has no weights", place);
  for (std::size_t i = 0; i < patch.weights.size(); ++i) {
    if (std::fabs(patch.weights[i]) <= std::numeric_limits<float>::max()) continue;
    return fault("NUMBER_OUT_OF_RANGE", "a weight is within the range of a float32",
                 below(place, std::to_string(i)));
  }
  return status;
}

/// Rounds to float32.
Status read_positions(const Json& object, const std::string& at, std::vector<float>& out) {
  const auto found = object.find("positions");
  if (found == object.end()) return success();
  const std::string place = below(at, "positions");
  if (!found->is_array()) return fault("TYPE_WRONG", "this must be an array", place);
  if (found->empty()) return fault("LENGTH_WRONG", "this has no positions", place);
  out.reserve(3 * found->size());
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Json& row = (*found)[i];
    const auto row_place = [&] { return below(place, std::to_string(i)); };
    if (!row.is_array()) return fault("TYPE_WRONG", "this must be an array", row_place());
    if (row.size() != 3) {
      return fault("LENGTH_WRONG",
                   "this has " + std::to_string(row.size()) + " numbers, a position has 3",
                   row_place());
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const auto fault_here = [&](const char* code, const char* message) {
        return fault(code, message, below(row_place(), std::to_string(k)));
      };
      if (!row[k].is_number()) return fault_here("TYPE_WRONG", "this must be a number");
      const double number = row[k].get<double>();
      if (!(std::fabs(number) <= std::numeric_limits<float>::max())) {
        return fault_here("NUMBER_OUT_OF_RANGE", "a coordinate is within the range of a float32");
      }
      out.push_back(static_cast<float>(number));
    }
  }
  return success();
}

/// Reads what an added node has beside a change.
Status read_added(const Json& object, const std::string& at, NodePatch& patch) {
  if (!object.contains("copy_of")) {
    for (const char* key : {"parent", "name"}) {
      if (!object.contains(key)) continue;
      return fault("KEY_MISSING", "only with \"copy_of\", which adds a node", below(at, key));
    }
    return success();
  }
  Status status = read_uint32(object, at, "copy_of", "a node's number", patch.copy_of);
  const auto parent = object.find("parent"), name = object.find("name");
  if (status && parent != object.end() && !parent->is_null())
    status = read_uint32(object, at, "parent", "a node's number", patch.parent);
  if (!status || name == object.end()) return status;
  if (!name->is_string()) return fault("TYPE_WRONG", "this must be a string", below(at, "name"));
  patch.name = name->get<std::string>();
  return status;
}

/// `own`: the members that say which change it is.
Status read_removed(const Json& object, const std::string& at, std::size_t own, NodePatch& patch) {
  const auto removed = object.find("removed");
  if (removed == object.end()) return success();
  const std::string place = below(at, "removed");
  if (!removed->is_boolean()) return fault("TYPE_WRONG", "this must be true", place);
  patch.removed = removed->get<bool>();
  if (!patch.removed)
    return fault("VALUE_UNKNOWN", "this must be true: a removed node does not come back", place);
  if (object.size() > own + 1)
    return fault("KEYS_MIXED", "a node that is removed has no other changes", place);
  return success();
}

/// Reads the members of a change. `at`: pointer of the object.
Status read_patch(const Json& object, const std::string& at, NodePatch& patch) {
  for (const auto& [key, count, numbers] :
       {std::tuple{"matrix", 16, &patch.matrix}, std::tuple{"translation", 3, &patch.translation},
        std::tuple{"rotation", 4, &patch.rotation}, std::tuple{"scale", 3, &patch.scale}}) {
    Status status = read_numbers(object, at, key, static_cast<std::size_t>(count), *numbers);
    if (!status) return status;
    if (!patch.matrix.empty() && numbers != &patch.matrix && !numbers->empty()) {
      return fault("KEYS_MIXED", "a node has a matrix, or translation, rotation and scale",
                   below(at, key));
    }
  }
  if (const auto hidden = object.find("hidden"); hidden != object.end()) {
    if (!hidden->is_boolean()) {
      return fault("TYPE_WRONG", "this must be true or false", below(at, "hidden"));
    }
    patch.hidden = hidden->get<bool>();
  }
  if (Status status = read_weights(object, at, patch); !status) return status;
  if (Status status = read_positions(object, at, patch.positions); !status) return status;
  if (Status status = read_added(object, at, patch); !status) return status;
  const std::size_t own = object.contains("node") ? 1 : 0;
  if (Status status = read_removed(object, at, own, patch); !status) return status;
  return read_uint32(object, at, "mask", "a mask", patch.mask);
}

Status read_animation(const Json& object, std::optional<AnimationPatch>& out) {
  const std::string at = "/animation";
  if (Status status = check_object(object, at, {"name", "index", "time"}); !status) return status;
  AnimationPatch animation;
  const auto name = object.find("name"), time = object.find("time");
  const bool has_index = object.contains("index");
  if (name != object.end() && has_index) {
    return fault("KEYS_MIXED", "an animation is called by its name or by its index", at + "/index");
  }
  if (name == object.end() && !has_index) {
    return fault("KEY_MISSING", "needs \"name\" or \"index\"", at);
  }
  if (time == object.end()) return fault("KEY_MISSING", "needs \"time\", in seconds", at);
  if (name != object.end()) {
    if (!name->is_string()) return fault("TYPE_WRONG", "this must be a string", at + "/name");
    animation.name = name->get<std::string>();
  }
  if (Status status = read_uint32(object, at, "index", "an index", animation.index); !status)
    return status;
  if (!time->is_number()) return fault("TYPE_WRONG", "this must be a number", at + "/time");
  animation.time = time->get<double>();
  if (!std::isfinite(animation.time)) {
    return fault("NUMBER_OUT_OF_RANGE", "the time must be finite", at + "/time");
  }
  out = std::move(animation);
  return success();
}

}  // namespace

Result<NodePatch> decode_node_patch(std::string_view body) {
  const auto document = parse_strictly(body);
  if (!document) return document.error();
  Status status = check_object(*document, "",
                               {"copy_of", "parent", "name", "matrix", "translation", "rotation",
                                "scale", "hidden", "mask", "weights", "positions", "removed"});
  NodePatch patch;
  if (status) status = read_patch(*document, "", patch);
  if (!status) return std::move(status).error();
  if (document->empty()) return fault("KEY_MISSING", "the change is empty", "");
  return patch;
}

Result<NodePatches> decode_node_patches(std::string_view body) {
  const auto document = parse_strictly(body);
  if (!document) return document.error();
  Status status = check_object(*document, "", {"nodes", "animation"});
  if (!status) return std::move(status).error();
  NodePatches decoded;
  if (const auto animation = document->find("animation"); animation != document->end()) {
    status = read_animation(*animation, decoded.animation);
    if (!status) return std::move(status).error();
  }
  const auto list = document->find("nodes");
  if (list == document->end() && decoded.animation) return decoded;
  if (list == document->end()) {
    return fault("KEY_MISSING", "needs \"nodes\" or \"animation\"", "");
  }
  if (!list->is_array()) return fault("TYPE_WRONG", "this must be an array", "/nodes");
  if (list->empty()) return fault("KEY_MISSING", "the change is empty", "/nodes");
  std::vector<NodePatch>& patches = decoded.nodes;
  patches.resize(list->size());
  std::unordered_set<std::uint32_t> seen;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const Json& object = (*list)[i];
    const std::string at = "/nodes/" + std::to_string(i);
    status = check_object(object, at,
                          {"node", "copy_of", "parent", "name", "matrix", "translation", "rotation",
                           "scale", "hidden", "mask", "weights", "positions", "removed"});
    if (status && !object.contains("node")) {
      status = fault("KEY_MISSING", "needs \"node\", the number of a node", at);
    }
    if (status) status = read_uint32(object, at, "node", "an index", patches[i].node);
    if (status) status = read_patch(object, at, patches[i]);
    if (!status) return std::move(status).error();
    if (object.size() < 2) return fault("KEY_MISSING", "the change is empty", at);
    if (!seen.insert(patches[i].node).second) {
      return fault("KEY_DUPLICATE", "node " + std::to_string(patches[i].node) + " is changed twice",
                   at);
    }
  }
  return decoded;
}

}  // namespace sightline
