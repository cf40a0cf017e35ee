#pragma once
/// Answers that are too long for an agent: a summary, and pages of a bounded length.

#include <deque>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline {

/// Retains the latest long answers and cuts pages from them. Not thread-safe.
class McpPages {
 public:
  using Ordered = nlohmann::ordered_json;

  /// `text` is JSON, or a text that is no JSON. Returns the number of the answer. Removes older
  /// answers: at most 8 are retained, and several of them have at most 64 MiB of text.
  int add(const std::string& text);

  /// A page of about `bytes` bytes as JSON:
  /// - `answer`, `pointer`, `first`: which part, as the caller asked for it.
  /// - `count`: how many elements each list of the page has at most.
  /// - `next`: the `first` of the next page, or null.
  /// - `shortened`: pointers of some inner lists and texts that the page has cut.
  /// - `page`: the value at `pointer`; its list, text, or direct lists begin at element `first`.
  /// - `bytes`, `summary`: length of the answer; counts, extremes and frequent texts of its lists.
  ///   Only with `first` 0 and an empty `pointer`.
  /// Cost: the summary reads the whole answer; a page reads what it shows, about ten times.
  /// Errors: ANSWER_GONE for an answer that is no longer retained, POINTER_UNKNOWN.
  [[nodiscard]] Result<Ordered> page(int answer, std::string_view pointer, std::size_t first,
                                     std::size_t bytes) const;
  /// The number of the latest answer; 0 if there is none.
  [[nodiscard]] int latest() const { return latest_; }

 private:
  struct Answer {
    int number = 0;
    std::size_t bytes = 0;
    Ordered value;
  };
  std::deque<Answer> answers_;
  int latest_ = 0;
};

}  // namespace sightline

// Tests: tests/integration/mcp_test.py
