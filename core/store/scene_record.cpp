#include "core/store/scene_record.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <span>

#include "core/store/revision_counter.h"
#include "core/store/sha256.h"

namespace sightline {
namespace {

/// A file's name is any bytes, JSON is UTF-8: what is not plain ASCII is written %xx.
std::string ascii_name(const std::string& name) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte > 0x20 && byte < 0x7f && c != '%') {
      text += c;
    } else {
      text += {'%', kDigits[byte >> 4], kDigits[byte & 15u]};
    }
  }
  return text;
}

std::optional<std::string> plain_name(const std::string& text) {
  std::string name;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      name += text[i];
      continue;
    }
    unsigned byte = 0;
    const char* begin = text.data() + std::min(i + 1, text.size());
    const char* end = text.data() + std::min(i + 3, text.size());
    const auto [last, error] = std::from_chars(begin, end, byte, 16);
    if (error != std::errc() || last != begin + 2) return std::nullopt;
    name += static_cast<char>(byte);
    i += 2;
  }
  return name;
}

/// False when one of them is none.
bool decode_neighbours(const nlohmann::json& document, std::vector<NeighbourRecord>& neighbours) {
  const auto found = document.find("neighbours");
  if (found == document.end()) return true;
  if (!found->is_array()) return false;
  for (const auto& each : *found) {
    const auto good = [&](const char* key, auto is_type) {
      return each.is_object() && each.contains(key) && is_type(each[key]);
    };
    const auto is_text = [](const nlohmann::json& value) { return value.is_string(); };
    const auto is_count = [](const nlohmann::json& value) { return value.is_number_unsigned(); };
    if (!good("name", is_text) || !good("sha256", is_text) || !good("bytes", is_count)) {
      return false;
    }
    const auto name = plain_name(each["name"].get<std::string>());
    if (!name) return false;
    neighbours.push_back(
        {*name, each["sha256"].get<std::string>(), each["bytes"].get<std::uint64_t>()});
    if (!is_sha256(neighbours.back().sha256)) return false;
  }
  return true;
}

nlohmann::ordered_json changes_of(const NodeChanges& changes) {
  auto list = nlohmann::ordered_json::array();
  for (const NodeChange& change : changes) {
    nlohmann::ordered_json each{{"node", change.node}};
    if (change.parent_from_node) each["matrix"] = change.parent_from_node->m;
    if (change.hidden) each["hidden"] = *change.hidden;
    if (change.mask) each["mask"] = *change.mask;
    list.push_back(std::move(each));
  }
  return list;
}

/// False when one of them is none.
bool decode_changes(const nlohmann::json& document, NodeChanges& changes) {
  const auto found = document.find("changes");
  if (found == document.end()) return true;
  if (!found->is_array()) return false;
  for (const auto& each : *found) {
    if (!each.is_object() || !each.contains("node") || !each["node"].is_number_unsigned()) {
      return false;
    }
    NodeChange change;
    change.node = each["node"].get<std::uint32_t>();
    if (const auto hidden = each.find("hidden"); hidden != each.end()) {
      if (!hidden->is_boolean()) return false;
      change.hidden = hidden->get<bool>();
    }
    if (const auto mask = each.find("mask"); mask != each.end()) {
      if (!mask->is_number_unsigned()) return false;
      change.mask = mask->get<std::uint32_t>();
    }
    if (const auto matrix = each.find("matrix"); matrix != each.end()) {
      const auto is_row = [](const nlohmann::json& row) {
        return row.is_array() && row.size() == 4 &&
               std::all_of(row.begin(), row.end(), [](const auto& x) { return x.is_number(); });
      };
      if (!matrix->is_array() || matrix->size() != 3 ||
          !std::all_of(matrix->begin(), matrix->end(), is_row)) {
        return false;
      }
      Affine& own = change.parent_from_node.emplace();
      for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t k = 0; k < 4; ++k) own.m[row][k] = (*matrix)[row][k].get<double>();
      }
    }
    changes.push_back(change);
  }
  return true;
}

}  // namespace

std::string tag_of(const NodeChanges& changes) {
  if (changes.empty()) return {};
  const std::string text = changes_of(changes).dump();
  return "changed-" + sha256_of(std::as_bytes(std::span(text))).substr(0, 32);
}

std::string encode_record(const SceneRecord& record) {
  nlohmann::ordered_json document;
  document["id"] = record.id;
  document["sha256"] = record.sha256;
  document["bytes"] = record.bytes;
  document["revision"] = record.revision;
  document["scene"] = nullptr;
  if (record.scene) document["scene"] = *record.scene;
  if (record.fingerprint) document["fingerprint"] = *record.fingerprint;
  for (const NeighbourRecord& each : record.neighbours) {
    document["neighbours"].push_back(
        {{"name", ascii_name(each.name)}, {"sha256", each.sha256}, {"bytes", each.bytes}});
  }
  if (!record.changes.empty()) document["changes"] = changes_of(record.changes);
  return document.dump() + "\n";
}

std::optional<SceneRecord> decode_record(const std::string& text, const std::string& id) {
  const auto document = nlohmann::json::parse(text, nullptr, false);
  if (!document.is_object()) return std::nullopt;
  const auto number = [&](const char* key) -> std::optional<std::uint64_t> {
    const auto found = document.find(key);
    if (found == document.end() || !found->is_number_unsigned()) return std::nullopt;
    return found->get<std::uint64_t>();
  };
  const auto word = [&](const char* key) {
    const auto found = document.find(key);
    return found != document.end() && found->is_string() ? found->get<std::string>()
                                                         : std::string();
  };
  SceneRecord record;
  record.id = word("id");
  record.sha256 = word("sha256");
  const auto bytes = number("bytes"), revision = number("revision"), scene = number("scene");
  if (record.id != id || !is_sha256(record.sha256) || !bytes || !revision) return std::nullopt;
  if (*revision > kMostRevision) return std::nullopt;
  record.bytes = *bytes;
  record.revision = *revision;
  if (scene) record.scene = static_cast<std::uint32_t>(*scene);
  record.fingerprint = number("fingerprint");
  if (!decode_neighbours(document, record.neighbours) ||
      !decode_changes(document, record.changes)) {
    return std::nullopt;
  }
  return record;
}

}  // namespace sightline
