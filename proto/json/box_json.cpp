#include "proto/json/box_json.h"

#include <array>

#include "proto/json/box_rows.h"
#include "proto/json/json_writer.h"

namespace sightline {

namespace {

constexpr std::array<std::string_view, 7> kBoxQueryKeys{"boxes",   "of",    "mode",    "timeout_ms",
                                                        "threads", "limit", "contacts"};

class BoxQueryReader : private JsonReader {
 public:
  explicit BoxQueryReader(const BoxJsonRules& rules) : rules_(rules) {}

  Result<BoxQuery> read(std::string& body) {
    unsigned seen = 0;
    const auto read_object = [&](Object object) { return read_top(object, seen); };
    if (!read_body(body, read_object)) return error();
    if ((seen & 1u) == 0 && !invalid("KEY_MISSING", "needs \"boxes\"", {})) return error();
    if (query_.question.contacts && !check_contacts()) return error();
    if (query_.question.relation == BoxRelation::kContained) {
      for (std::uint64_t& question : query_.questions) question = ~question;
    }
    return std::move(query_);
  }

 private:
  bool read_top(Object object, unsigned& seen) {
    const unsigned known = rules_.has_limit ? 127u : 31u;
    for (auto entry : object) {
      Field field;
      if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
        return check_end(code, [] { return JsonPointer(); });
      }
      std::size_t which = 0;
      if (!read_key(field, kBoxQueryKeys, known, {}, which) ||
          !mark_seen(1u << which, seen, JsonPointer().key(kBoxQueryKeys[which])) ||
          !read_part(which, field.value())) {
        return false;
      }
    }
    return true;
  }

  bool check_contacts() {
    if (query_.question.targets != BoxTargets::kTriangles) {
      return invalid("KEYS_MIXED", "contacts are those of triangles, not of nodes",
                     JsonPointer().key("contacts"));
    }
    const BoxBatch& boxes = query_.boxes;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (!boxes.is_convex_region(i)) continue;
      return invalid("BOX_CONTACTS",
                     "planes, corners and views have no contacts; send the corners as a hull",
                     JsonPointer().key("boxes").index(i));
    }
    return true;
  }

  bool read_part(std::size_t which, Value value) {
    const JsonPointer place = JsonPointer().key(kBoxQueryKeys[which]);
    if (which == 0) {
      BoxRows rows(*this, rules_.max_boxes,
                   rules_.has_limit ? BoxRows::Takes::kCursors : BoxRows::Takes::kShapes,
                   rules_.find_camera);
      if (!rows.read(value, query_.boxes)) return false;
      query_.cursors = rows.take_cursors();
      query_.questions = rows.take_shape_hashes();
      return true;
    }
    if (which == 3) return read_timeout(value, query_.timeout_ms, place);
    if (which == 4) return read_threads(value, query_.threads, place);
    if (which == 5) return read_count(value, rules_.limit, query_.limit, place);
    if (which == 6) return read_boolean(value, query_.question.contacts, place);
    constexpr std::array<std::string_view, 2> kTargets{"triangles", "nodes"};
    constexpr std::array<std::string_view, 2> kModes{"intersecting", "contained"};
    std::size_t word = 0;
    if (!read_word(value, which == 1 ? kTargets : kModes, word, place)) return false;
    if (which == 1) {
      query_.question.targets = word == 1 ? BoxTargets::kNodes : BoxTargets::kTriangles;
    } else {
      query_.question.relation = word == 1 ? BoxRelation::kContained : BoxRelation::kIntersecting;
    }
    return true;
  }

  BoxJsonRules rules_;
  BoxQuery query_;
};

void write_triangle(JsonWriter& out, const BoxLists& lists, const HitTerms& terms,
                    const BoxContacts* contacts, std::size_t i) {
  out.raw('{');
  write_triangle_members(out, lists.triangles[i].instance, terms, i);
  if (contacts != nullptr) {
    const Vec3d& normal = contacts->normal[i];
    out.raw(",\"depth\":");
    out.number(contacts->depth[i]);
    out.raw(",\"contact_normal\":");
    if (normal == Vec3d{}) {
      out.raw("null");
    } else {
      out.vector(normal.x, normal.y, normal.z);
    }
  }
  out.raw('}');
}

void write_node(JsonWriter& out, const HitTerms& terms, std::size_t i) {
  out.raw("{\"node\":");
  out.name(terms.node_name[i]);
  out.raw(",\"node_id\":");
  out.number(terms.node[i]);
  out.raw('}');
}

}  // namespace

Result<BoxQuery> decode_boxes(std::string& body, const BoxJsonRules& rules) {
  return BoxQueryReader(rules).read(body);
}

std::string encode_box_lists(const BoxLists& lists, std::span<const std::uint64_t> totals,
                             BoxTargets targets, const HitTerms& terms, std::uint64_t revision,
                             std::span<const std::uint64_t> questions,
                             const BoxContacts* contacts) {
  const bool of_nodes = targets == BoxTargets::kNodes;
  JsonWriter out(32 + totals.size() * 32 +
                 terms.node_name.size() * (contacts != nullptr ? 160 : 64));
  out.raw("{\"results\":[");
  for (std::size_t box = 0; box < totals.size(); ++box) {
    out.raw(box > 0 ? ",{\"total\":" : "{\"total\":");
    out.number(totals[box]);
    out.raw(of_nodes ? ",\"nodes\":[" : ",\"triangles\":[");
    for (std::size_t i = lists.first[box]; i < lists.first[box + 1]; ++i) {
      if (i > lists.first[box]) out.raw(',');
      if (of_nodes) {
        write_node(out, terms, i);
      } else {
        write_triangle(out, lists, terms, contacts, i);
      }
    }
    out.raw(']');
    if (lists.next[box] != 0) {
      out.raw(",\"next\":");
      out.string(encode_cursor({revision, questions[box], of_nodes, lists.next[box]}));
    }
    out.raw('}');
  }
  out.raw("]}");
  return out.take();
}

}  // namespace sightline
