#include "server/client/mcp_pages.h"

#include <algorithm>
#include <map>
#include <span>
#include <vector>

#include "server/client/json_depth.h"

namespace sightline {
namespace {

using Ordered = nlohmann::ordered_json;
using Values = std::vector<const Ordered*>;

constexpr std::size_t kMostAnswers = 8, kMostBytes = std::size_t{64} << 20;
/// A page never cuts short lists of numbers, such as positions, nor short texts and objects.
constexpr std::size_t kWholeNumbers = 16, kWholeText = 256, kWholeObject = 64;
constexpr std::size_t kMostPointers = 8, kMostFields = 32, kMostTexts = 5, kMostText = 80;

/// What values have in common: counts, extremes, frequent texts. Lists are summarised as one.
Ordered summary_of(const Values& values, int depth) {
  Ordered summary{{"count", values.size()}};
  std::size_t nulls = 0, trues = 0, flags = 0, numbers = 0;
  const Ordered *least = nullptr, *most = nullptr;
  std::map<std::string, std::size_t> texts;
  std::vector<std::pair<std::string, Values>> fields;
  Values elements;
  for (const Ordered* value : values) {
    if (value->is_null()) ++nulls;
    if (value->is_boolean()) ++flags, trues += value->get<bool>() ? 1U : 0U;
    if (value->is_number()) {
      ++numbers;
      if (least == nullptr || *value < *least) least = value;
      if (most == nullptr || *most < *value) most = value;
    }
    if (value->is_string()) ++texts[value->get_ref<const std::string&>()];
    if (value->is_array()) {
      for (const Ordered& element : *value) elements.push_back(&element);
    }
    if (!value->is_object()) continue;
    for (const auto& [name, member] : value->items()) {
      auto field = std::find_if(fields.begin(), fields.end(),
                                [&, &key = name](const auto& each) { return each.first == key; });
      if (field == fields.end()) {
        if (fields.size() == kMostFields) continue;
        field = fields.insert(field, {name, {}});
      }
      field->second.push_back(&member);
    }
  }
  if (nulls > 0) summary["null"] = nulls;
  if (flags > 0) summary["true"] = trues;
  if (numbers > 0) summary.update({{"min", *least}, {"max", *most}});
  if (!texts.empty()) {
    summary["different"] = texts.size();
    std::vector<std::pair<std::string, std::size_t>> frequent(texts.begin(), texts.end());
    std::stable_sort(frequent.begin(), frequent.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
    frequent.resize(std::min(frequent.size(), kMostTexts));
    for (const auto& [text, count] : frequent) {
      summary["frequent"].push_back({{"text", text.substr(0, kMostText)}, {"count", count}});
    }
  }
  if (depth == 0) return summary;
  if (!elements.empty()) summary["elements"] = summary_of(elements, depth - 1);
  for (const auto& [name, members] : fields) {
    summary["fields"][name] = summary_of(members, depth - 1);
  }
  return summary;
}

/// The lists in which the first element of a page counts: the value, or the direct lists of an
/// object.
template <typename Visit>
void visit_lists(const Ordered& value, const Visit& visit) {
  if (value.is_array() || value.is_string()) visit(std::string(), value);
  if (!value.is_object()) return;
  for (const auto& [name, member] : value.items()) {
    if (member.is_array()) visit(name, member);
  }
}

std::size_t elements_of(const Ordered& list) {
  return list.is_string() ? list.get_ref<const std::string&>().size() : list.size();
}

std::string below(const std::string& pointer, const std::string& name) {
  return pointer + (Ordered::json_pointer() / name).to_string();
}

/// Copies a value with at most `count` elements in each list, as long as it has room.
class Cutter {
 public:
  Cutter(std::size_t count, std::size_t room) : count_(count), room_(room) {}

  /// Returns false if the room is exhausted.
  bool copy(const Ordered& from, std::size_t first, bool is_top, const std::string& pointer,
            Ordered& to) {
    if (from.is_array()) return copy_list(from, first, is_top, pointer, to);
    if (from.is_object()) return copy_object(from, first, is_top, pointer, to);
    if (from.is_string()) {
      const auto& text = from.get_ref<const std::string&>();
      const std::size_t most = std::max(count_, kWholeText);
      if (!is_top && text.size() > most) mark(pointer);
      to = text.substr(std::min(first, text.size()), most);
      return take(to.get_ref<const std::string&>().size() + 3);
    }
    to = from;
    return take(from.dump().size() + 1);
  }
  [[nodiscard]] const Ordered& shortened() const { return shortened_; }

 private:
  bool take(std::size_t bytes) {
    if (bytes > room_) return false;
    room_ -= bytes;
    return true;
  }
  void mark(const std::string& pointer) {
    if (shortened_.size() < kMostPointers) shortened_.push_back(pointer);
  }
  bool copy_list(const Ordered& from, std::size_t first, bool is_top, const std::string& pointer,
                 Ordered& to) {
    to = Ordered::array();
    const std::size_t size = from.size();
    const bool is_short = !is_top && size <= kWholeNumbers && size > 0 && from[0].is_primitive();
    const std::size_t end =
        is_short ? size : first + std::min(count_, size - std::min(first, size));
    if (!is_top && end < size) mark(pointer);
    for (std::size_t i = first; i < end && i < size; ++i) {
      to.push_back(nullptr);
      if (!copy(from[i], 0, false, below(pointer, std::to_string(i)), to.back())) return false;
    }
    return take(3);
  }
  bool copy_object(const Ordered& from, std::size_t first, bool is_top, const std::string& pointer,
                   Ordered& to) {
    to = Ordered::object();
    const std::size_t most = std::max(count_, kWholeObject);
    if (from.size() > most) mark(pointer);
    for (const auto& [name, member] : from.items()) {
      if (to.size() == most) break;
      const bool is_list = is_top && member.is_array();
      if (!take(name.size() + 4) ||
          !copy(member, is_list ? first : 0, is_list, below(pointer, name), to[name])) {
        return false;
      }
    }
    return take(3);
  }

  const std::size_t count_;
  std::size_t room_;
  Ordered shortened_ = Ordered::array();
};

}  // namespace

int McpPages::add(const std::string& text) {
  Ordered value = is_nested_deeply(text) ? Ordered(Ordered::value_t::discarded)
                                         : Ordered::parse(text, nullptr, false);
  if (value.is_discarded()) value = text;
  answers_.push_back({++latest_, text.size(), std::move(value)});
  std::size_t total = 0;
  for (const Answer& each : answers_) total += each.bytes;
  while (answers_.size() > kMostAnswers || (total > kMostBytes && answers_.size() > 1)) {
    total -= answers_.front().bytes;
    answers_.pop_front();
  }
  return latest_;
}

Result<Ordered> McpPages::page(int answer, std::string_view pointer, std::size_t first,
                               std::size_t bytes) const {
  const auto found = std::find_if(answers_.begin(), answers_.end(),
                                  [&](const Answer& each) { return each.number == answer; });
  if (found == answers_.end()) {
    return Error{ErrorKind::kNotFound, "ANSWER_GONE",
                 "answer " + std::to_string(answer) + " is not retained: call the tool again", ""};
  }
  const Ordered* value = &found->value;
  try {
    value = &value->at(Ordered::json_pointer(std::string(pointer)));
  } catch (const Ordered::exception&) {
    return Error{ErrorKind::kNotFound, "POINTER_UNKNOWN",
                 "the answer has no value at this JSON pointer", std::string(pointer)};
  }
  Ordered page{{"answer", answer}, {"pointer", pointer}, {"first", first}};
  if (first == 0 && pointer.empty()) {
    page["bytes"] = found->bytes;
    visit_lists(*value, [&](const std::string& name, const Ordered& list) {
      if (!list.is_array()) return;
      Values values;
      for (const Ordered& each : list) values.push_back(&each);
      page["summary"][name] = summary_of(values, 2);
    });
    // Rows with very many different keys.
    if (page.dump().size() > bytes / 2) page.erase("summary");
  }
  const std::size_t used = page.dump(-1, ' ', false, Ordered::error_handler_t::replace).size();
  const std::size_t room = bytes - std::min(bytes, used + 512);
  // The largest count that has room: an element takes at least a byte.
  std::size_t good = 0, bad = bytes + 1;
  Ordered shown, shortened = Ordered::array();
  for (std::size_t count = 64; good + 1 < bad; count = good + (bad - good) / 2) {
    Cutter cutter(count, room);
    Ordered copy;
    const bool fits = cutter.copy(*value, first, true, std::string(pointer), copy);
    (fits ? good : bad) = count;
    if (!fits) continue;
    shown = std::move(copy);
    shortened = cutter.shortened();
  }
  std::size_t longest = 0;
  visit_lists(*value, [&](const std::string&, const Ordered& list) {
    longest = std::max(longest, elements_of(list));
  });
  const std::size_t step = value->is_string() ? std::max(good, kWholeText) : good;
  // No more than there are: a value that is no list is one element.
  page["count"] = std::min(step, std::max<std::size_t>(longest, 1) - std::min(first, longest));
  page["next"] = step > 0 && longest > first + step ? Ordered(first + step) : Ordered();
  page["shortened"] = std::move(shortened);
  page["page"] = std::move(shown);
  return page;
}

}  // namespace sightline
