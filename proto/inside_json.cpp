#include "proto/inside_json.h"

#include <array>

#include "proto/json_writer.h"
#include "proto/point_rows.h"
#include "proto/ray_reader.h"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 2> kMoreKeys{"points", "method"};

class InsideReader : public RayReader {
 public:
  explicit InsideReader(std::size_t max_points)
      : RayReader(
            {.has_fields = false, .has_rays = false, .has_marks = false, .has_culling = false}),
        max_points_(max_points) {}

  Result<InsideQuery> read_all(std::string& body) {
    Result<RayQuery> options = read(body);
    if (!options) return std::move(options).error();
    inside_.options = std::move(*options);
    return std::move(inside_);
  }

 private:
  std::span<const std::string_view> more_keys() const override { return kMoreKeys; }

  bool read_more(std::size_t which, Value value) override {
    const JsonPointer place = JsonPointer().key(kMoreKeys[which]);
    if (which == 0) {
      has_points_ = true;
      return read_points(
          *this, value, place, max_points_, inside_.points, [&](const JsonPointer& point_place) {
            return fail(ErrorKind::kTooLarge, "POINTS_TOO_MANY",
                        "a request may hold " + std::to_string(max_points_) + " points",
                        point_place);
          });
    }
    constexpr std::array<std::string_view, 2> kMethods{"parity", "winding"};
    std::size_t word = 0;
    if (!read_word(value, kMethods, word, place)) return false;
    inside_.by_winding = word == 1;
    return true;
  }

  bool finish_more() override {
    return has_points_ || invalid("KEY_MISSING", "needs \"points\"", {});
  }

  std::size_t max_points_;
  bool has_points_ = false;
  InsideQuery inside_;
};

template <class Values, class Write>
void write_list(JsonWriter& out, std::string_view name, const Values& values, Write write) {
  out.raw(name);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) out.raw(',');
    write(i);
  }
  out.raw(']');
}

}  // namespace

Result<InsideQuery> decode_inside(std::string& body, std::size_t max_points) {
  return InsideReader(max_points).read_all(body);
}

std::string encode_inside(const InsideQuery& query, std::span<const std::uint8_t> inside,
                          std::span<const std::uint8_t> on_surface,
                          std::span<const std::uint8_t> reliable,
                          std::span<const std::int64_t> winding) {
  JsonWriter out(96 + inside.size() * 20);
  out.raw(query.by_winding ? "{\"method\":\"winding\"" : "{\"method\":\"parity\"");
  write_list(out, ",\"inside\":[", inside, [&](std::size_t i) {
    if (on_surface[i] != 0) return out.raw("null");
    out.boolean(inside[i] != 0);
  });
  write_list(out, ",\"on_surface\":[", on_surface,
             [&](std::size_t i) { out.boolean(on_surface[i] != 0); });
  write_list(out, ",\"reliable\":[", reliable,
             [&](std::size_t i) { out.boolean(reliable[i] != 0); });
  if (query.by_winding) {
    write_list(out, ",\"winding\":[", winding,
               [&](std::size_t i) { out.raw(std::to_string(winding[i])); });
  }
  out.raw('}');
  return out.take();
}

}  // namespace sightline
