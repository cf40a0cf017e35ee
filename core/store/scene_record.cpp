#include "core/store/scene_record.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "core/store/revision_counter.h"
#include "core/store/sha256.h"

namespace sightline {
namespace {

using nlohmann::json;

constexpr std::string_view kChecksumBegin = ",\"checksum\":\"";
constexpr std::string_view kChangesBegin = ",\"changes\":";
constexpr std::string_view kChecksumEnd = "\"}\n";
constexpr std::size_t kHashLength = 64;

std::string checksum_of(std::string_view text) {
  return sha256_of(std::as_bytes(std::span(text.data(), text.size())));
}

/// Whether the text ends with the checksum of what precedes it.
bool has_checksum(std::string_view text) {
  constexpr std::size_t kTail = kChecksumBegin.size() + kHashLength + kChecksumEnd.size();
  if (text.size() < kTail) return false;
  const std::string_view body = text.substr(0, text.size() - kTail);
  const std::string_view tail = text.substr(body.size());
  return tail.starts_with(kChecksumBegin) && tail.ends_with(kChecksumEnd) &&
         tail.substr(kChecksumBegin.size(), kHashLength) == checksum_of(body);
}

/// The text of a record with a checksum, without its changes. They are its last member but for the
/// checksum, and a string of JSON cannot contain the text at which they begin.
std::string without_changes(const std::string& text) {
  const std::size_t end = text.find(kChangesBegin);
  return end == std::string::npos ? text : text.substr(0, end) + "}";
}

/// Whether `value` is an object with no other members.
bool has_only(const json& value, std::initializer_list<std::string_view> keys) {
  if (!value.is_object()) return false;
  for (const auto& [key, member] : value.items()) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) return false;
  }
  return true;
}

bool is_uint32(const json& value) {
  return value.is_number_unsigned() &&
         value.get<std::uint64_t>() <= std::numeric_limits<std::uint32_t>::max();
}

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

std::optional<NeighbourRecord> decode_neighbour(const json& value) {
  if (!has_only(value, {"name", "sha256", "bytes"})) return std::nullopt;
  const auto name = value.find("name"), sha256 = value.find("sha256"), bytes = value.find("bytes");
  if (name == value.end() || !name->is_string()) return std::nullopt;
  if (sha256 == value.end() || !sha256->is_string()) return std::nullopt;
  if (bytes == value.end() || !bytes->is_number_unsigned()) return std::nullopt;
  auto plain = plain_name(name->get<std::string>());
  if (!plain) return std::nullopt;
  NeighbourRecord record{*std::move(plain), sha256->get<std::string>(),
                         bytes->get<std::uint64_t>()};
  if (!is_sha256(record.sha256)) return std::nullopt;
  return record;
}

bool is_list_of_numbers(const json& value) {
  return value.is_array() &&
         std::all_of(value.begin(), value.end(), [](const json& x) { return x.is_number(); });
}

std::optional<Affine> decode_matrix(const json& value) {
  const auto is_row = [](const json& row) { return is_list_of_numbers(row) && row.size() == 4; };
  if (!value.is_array() || value.size() != 3) return std::nullopt;
  if (!std::all_of(value.begin(), value.end(), is_row)) return std::nullopt;
  Affine matrix;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t k = 0; k < 4; ++k) matrix.m[row][k] = value[row][k].get<double>();
  }
  return matrix;
}

/// Decodes what makes the change add its node, if it does. False where a member is invalid.
bool decode_added(const json& value, NodeChange& change) {
  const auto copy_of = value.find("copy_of"), parent = value.find("parent"),
             name = value.find("name");
  const auto end = value.end();
  if (copy_of == end) return parent == end && name == end;
  if (!is_uint32(*copy_of)) return false;
  AddedNode added{copy_of->get<std::uint32_t>(), {}};
  if (parent != end) {
    if (!is_uint32(*parent)) return false;
    added.parent = parent->get<std::uint32_t>();
  }
  if (name != end) {
    if (!name->is_string()) return false;
    added.name = name->get<std::string>();
  }
  change.added = std::move(added);
  return true;
}

constexpr std::size_t kFloatDigits = 8;  ///< the bits of a float32 in hexadecimal

void append_positions(std::string& text, std::span<const Vec3f> positions) {
  constexpr char kDigits[] = "0123456789abcdef";
  for (const Vec3f& position : positions) {
    for (const float number : {position.x, position.y, position.z}) {
      const auto bits = std::bit_cast<std::uint32_t>(number);
      for (int shift = 28; shift >= 0; shift -= 4) text += kDigits[(bits >> shift) & 15u];
    }
  }
}

/// The number that `kFloatDigits` lower-case digits mean; NaN if they mean none.
float decode_float(const char* digits) {
  std::uint32_t bits = 0;
  const auto [end, error] = std::from_chars(digits, digits + kFloatDigits, bits, 16);
  const bool is_good = error == std::errc() && end == digits + kFloatDigits &&
                       std::none_of(digits, end, [](char c) { return c >= 'A' && c <= 'F'; });
  return is_good ? std::bit_cast<float>(bits) : std::numeric_limits<float>::quiet_NaN();
}

/// False if the text is not that of finite positions, at least one.
bool decode_positions(std::string_view text, NodeChange& change) {
  if (text.empty() || text.size() % (3 * kFloatDigits) != 0) return false;
  UnsetColumn<Vec3f> positions(text.size() / (3 * kFloatDigits));
  const char* at = text.data();
  for (Vec3f& position : positions) {
    for (float* number : {&position.x, &position.y, &position.z}) {
      *number = decode_float(at);
      at += kFloatDigits;
      if (!std::isfinite(*number)) return false;
    }
  }
  change.positions = SharedColumn<Vec3f>::shared(std::move(positions));
  return true;
}

std::optional<NodeChange> decode_change(const json& value) {
  if (!has_only(value, {"node", "copy_of", "parent", "name", "matrix", "hidden", "mask", "weights",
                        "positions", "removed"})) {
    return std::nullopt;
  }
  const auto node = value.find("node");
  if (node == value.end() || !is_uint32(*node)) return std::nullopt;
  NodeChange change;
  change.node = node->get<std::uint32_t>();
  if (const auto hidden = value.find("hidden"); hidden != value.end()) {
    if (!hidden->is_boolean()) return std::nullopt;
    change.hidden = hidden->get<bool>();
  }
  if (const auto mask = value.find("mask"); mask != value.end()) {
    if (!is_uint32(*mask)) return std::nullopt;
    change.mask = mask->get<std::uint32_t>();
  }
  if (const auto matrix = value.find("matrix"); matrix != value.end()) {
    change.parent_from_node = decode_matrix(*matrix);
    if (!change.parent_from_node) return std::nullopt;
  }
  if (const auto weights = value.find("weights"); weights != value.end()) {
    if (!is_list_of_numbers(*weights)) return std::nullopt;
    change.weights = weights->get<std::vector<double>>();
  }
  if (const auto positions = value.find("positions"); positions != value.end()) {
    if (!positions->is_string()) return std::nullopt;
    if (!decode_positions(positions->get_ref<const std::string&>(), change)) return std::nullopt;
  }
  if (const auto removed = value.find("removed"); removed != value.end()) {
    if (!removed->is_boolean()) return std::nullopt;
    change.removed = removed->get<bool>();
  }
  if (!decode_added(value, change)) return std::nullopt;
  return change;
}

/// Decodes the array `key` of the document, if it has one. False where an element is invalid.
template <class Element>
bool decode_list(const json& document, const char* key, std::vector<Element>& elements,
                 std::optional<Element> (*decode)(const json&)) {
  const auto found = document.find(key);
  if (found == document.end()) return true;
  if (!found->is_array()) return false;
  for (const json& each : *found) {
    auto element = decode(each);
    if (!element) return false;
    elements.push_back(*std::move(element));
  }
  return true;
}

/// The shortest text that reads as this number and its sign. Precondition: it is finite.
void append_number(std::string& text, double number) {
  char digits[32];
  const auto [end, error] = std::to_chars(std::begin(digits), std::end(digits), number);
  const std::string_view written(digits, static_cast<std::size_t>(end - digits));
  text += written;
  // "-0" would be an integer, which has no sign.
  if (written.find_first_of(".e") == std::string_view::npos) text += ".0";
}

/// Appends a list of numbers. Precondition: there is at least one.
void append_numbers(std::string& text, std::span<const double> numbers) {
  char before = '[';
  for (const double number : numbers) {
    text += before;
    before = ',';
    append_number(text, number);
  }
  text += ']';
}

/// The JSON of a list of changes. Written here because nlohmann's document takes four times as
/// long, and each PATCH writes all changes.
std::string json_of(const NodeChanges& changes) {
  std::string text = "[";
  for (const NodeChange& change : changes) {
    if (text.size() > 1) text += ',';
    text.append("{\"node\":").append(std::to_string(change.node));
    if (const auto& added = change.added) {
      text.append(",\"copy_of\":").append(std::to_string(added->copy_of));
      if (added->parent) text.append(",\"parent\":").append(std::to_string(*added->parent));
      if (!added->name.empty()) text.append(",\"name\":").append(json(added->name).dump());
    }
    if (change.parent_from_node) {
      text += ",\"matrix\":";
      char before_row = '[';
      for (const auto& row : change.parent_from_node->m) {
        text += before_row;
        before_row = ',';
        append_numbers(text, row);
      }
      text += ']';
    }
    if (change.hidden) text.append(",\"hidden\":").append(*change.hidden ? "true" : "false");
    if (change.mask) text.append(",\"mask\":").append(std::to_string(*change.mask));
    if (!change.weights.empty()) append_numbers(text += ",\"weights\":", change.weights);
    if (!change.positions.empty()) {
      append_positions(text += ",\"positions\":\"", change.positions);
      text += '"';
    }
    if (change.removed) text += ",\"removed\":true";
    text += '}';
  }
  return text += ']';
}

}  // namespace

std::string tag_of(const NodeChanges& changes) {
  if (changes.empty()) return {};
  // Bytes of the members, not JSON: the digits of all numbers take fifty times as long.
  std::string bytes;
  const auto append = [&](const auto& member) {
    bytes += member ? '\1' : '\0';
    if (member) bytes.append(reinterpret_cast<const char*>(&*member), sizeof(*member));
  };
  for (const NodeChange& change : changes) {
    append(&change.node);
    append(change.parent_from_node);
    append(change.hidden);
    append(change.mask);
    // The tags of changes without the members below are those of versions that did not know them.
    if (!change.weights.empty()) {
      bytes += "weights" + std::to_string(change.weights.size());
      bytes.append(reinterpret_cast<const char*>(change.weights.data()),
                   change.weights.size() * sizeof(double));
    }
    if (const auto& added = change.added) {
      bytes += "added";
      append(&added->copy_of);
      append(added->parent);
      bytes += std::to_string(added->name.size()) + ":" + added->name;
    }
    if (!change.positions.empty()) {
      bytes += "positions" + std::to_string(change.positions.size());
      bytes.append(reinterpret_cast<const char*>(change.positions.data()),
                   change.positions.size() * sizeof(Vec3f));
    }
    if (change.removed) bytes += "removed";
  }
  return "changed-" + checksum_of(bytes).substr(0, 32);
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
  std::string text = document.dump();
  text.pop_back();  // the brace that ends the object
  if (!record.changes.empty()) text.append(kChangesBegin).append(json_of(record.changes));
  const std::string checksum = checksum_of(text);
  return text.append(kChecksumBegin).append(checksum).append(kChecksumEnd);
}

std::optional<SceneRecord> decode_record(const std::string& text, const std::string& id,
                                         RecordForm form, RecordPart part) {
  const bool is_checked = has_checksum(text);
  if (!is_checked && form == RecordForm::kChecked) return std::nullopt;
  const bool is_whole = part == RecordPart::kWhole || !is_checked;
  auto document = json::parse(is_whole ? text : without_changes(text), nullptr, false);
  if (!document.is_object()) return std::nullopt;
  // Without a valid checksum the key is unknown: a damaged record is not read as an older one.
  if (is_checked) document.erase("checksum");
  if (!has_only(document, {"id", "sha256", "bytes", "revision", "scene", "fingerprint",
                           "neighbours", "changes"})) {
    return std::nullopt;
  }
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
  const auto bytes = number("bytes"), revision = number("revision");
  if (record.id != id || !is_sha256(record.sha256) || !bytes || !revision) return std::nullopt;
  if (*revision > kMostRevision) return std::nullopt;
  record.bytes = *bytes;
  record.revision = *revision;
  if (const auto scene = document.find("scene"); scene != document.end() && !scene->is_null()) {
    if (!is_uint32(*scene)) return std::nullopt;
    record.scene = scene->get<std::uint32_t>();
  }
  record.fingerprint = number("fingerprint");
  if (!record.fingerprint && document.contains("fingerprint")) return std::nullopt;
  if (!decode_list(document, "neighbours", record.neighbours, decode_neighbour) ||
      !decode_list(document, "changes", record.changes, decode_change)) {
    return std::nullopt;
  }
  return record;
}

}  // namespace sightline
