// Changes of nodes: an error with a place, or changes that another parser reads alike.
// Run:  scripts/stress.sh fuzz --target node_json_fuzz

#include <cmath>
#include <set>
#include <string>

#include "proto/json/node_json.h"
#include "tests/fuzz/body_check.h"

using namespace sightline;

namespace {

using Json = nlohmann::json;
using fuzz::require;

void check_numbers(const Json& object, const char* key, const std::vector<double>& read) {
  const Json* list = fuzz::find(object, key);
  require((list == nullptr ? 0 : list->size()) == read.size(), "as many numbers");
  for (std::size_t i = 0; i < read.size(); ++i)
    require(fuzz::same((*list)[i], read[i]), "numbers read alike");
}

void check_patch(const Json& object, const NodePatch& patch) {
  check_numbers(object, "matrix", patch.matrix);
  check_numbers(object, "translation", patch.translation);
  check_numbers(object, "rotation", patch.rotation);
  check_numbers(object, "scale", patch.scale);
  check_numbers(object, "weights", patch.weights);
  require(patch.matrix.empty() || patch.matrix.size() == 16, "a matrix has 16 numbers");
  require(patch.matrix.empty() || (patch.translation.empty() && patch.scale.empty()),
          "a matrix stands alone");
  const Json* positions = fuzz::find(object, "positions");
  require((positions == nullptr ? 0 : positions->size() * 3) == patch.positions.size(),
          "three numbers for each vertex");
  for (const float number : patch.positions) require(std::isfinite(number), "vertices are finite");
  require(object.contains("copy_of") == patch.copy_of.has_value(), "copies are copies");
  require(patch.copy_of || (!patch.parent && patch.name.empty()), "only copies have a parent");
  require(object.contains("removed") == patch.removed, "removed nodes are removed");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string sent(reinterpret_cast<const char*>(data), size);
  const Json document = Json::parse(sent, nullptr, false);
  if (const auto patch = decode_node_patch(sent)) {
    require(document.is_object() && !document.empty(), "what is accepted is JSON");
    check_patch(document, *patch);
  } else {
    fuzz::check_error(patch.error());
  }
  const auto patches = decode_node_patches(sent);
  if (!patches) {
    fuzz::check_error(patches.error());
    return 0;
  }
  require(document.is_object(), "what is accepted is JSON");
  const Json* list = fuzz::find(document, "nodes");
  require((list == nullptr ? 0 : list->size()) == patches->nodes.size(), "as many changes");
  require(list != nullptr || patches->animation, "something changes");
  std::set<std::uint32_t> nodes;
  for (std::size_t i = 0; i < patches->nodes.size(); ++i) {
    check_patch((*list)[i], patches->nodes[i]);
    require((*list)[i]["node"] == patches->nodes[i].node, "nodes read alike");
    require(nodes.insert(patches->nodes[i].node).second, "a node is changed once");
  }
  return 0;
}
