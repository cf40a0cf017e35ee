#include "core/import/pov/pov_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "core/import/input/budget.h"
#include "core/import/input/refusal.h"
#include "core/import/pov/pov_tokens.h"

namespace sightline::pov {

namespace {

constexpr std::array<std::string_view, 6> kSkipped = {
    "camera", "light_source", "global_settings", "background", "sky_sphere", "fog"};
/// What a box may say about its appearance: with braces, and without.
constexpr std::array<std::string_view, 6> kLooks = {"pigment", "texture",  "finish",
                                                    "normal",  "interior", "photons"};
constexpr std::array<std::string_view, 5> kFlags = {"no_shadow", "no_image", "no_reflection",
                                                    "hollow", "double_illuminate"};

template <std::size_t N>
bool contains(const std::array<std::string_view, N>& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

Error unsupported(const Token& token) {
  return {ErrorKind::kUnsupported, "POV_FEATURE_UNSUPPORTED",
          "line " + std::to_string(token.line) + ": \"" + gltf::shortened(token.text) +
              "\" is not understood, only boxes without transforms are",
          ""};
}

/// Linear red, green, blue and alpha.
using Colour = std::array<double, 4>;

/// What a file says of the colour of a box.
struct Pigment {
  std::string text;              ///< "{...}"; empty: nothing
  std::optional<Colour> colour;  ///< empty: not a plain colour
};

/// x * (to - from) + from is `to` for x = 1, if there is such a float64 edge.
double edge_between(double from, double to) {
  const double edge = to - from;
  const double limit = std::numeric_limits<double>::infinity();
  for (const double near : {edge, std::nextafter(edge, limit), std::nextafter(edge, -limit)}) {
    if (near + from == to) return near;
  }
  return edge;
}

/// The colour of a pigment, at every vertex.
class PigmentColour : public VertexNumbers {
 public:
  explicit PigmentColour(const Colour& colour) : colour_(colour) {}
  std::uint32_t components() const override { return 4; }
  bool load(std::uint64_t, double* out, std::uint64_t&) const override {
    std::copy(colour_.begin(), colour_.end(), out);
    return true;
  }
  std::uint64_t bytes() const override { return sizeof *this; }

 private:
  Colour colour_;
};

std::shared_ptr<const Mesh> make_cube(std::uint32_t number, const std::optional<Colour>& colour) {
  Mesh cube;
  cube.name = "box";
  cube.file_mesh = number;
  for (int i = 0; i < 8; ++i) {
    cube.positions.own().push_back({static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1),
                                    static_cast<float>(i >> 2 & 1)});
  }
  // Counter-clockwise seen from outside, two for each of -x +x -y +y -z +z.
  cube.indices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                  2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  cube.primitives = {{0, 12, 0, number}};
  if (colour) {
    PrimitiveAttributes attributes;
    attributes.entries.push_back(
        {VertexAttribute::kColour, std::make_shared<const PigmentColour>(*colour)});
    cube.attributes.push_back(std::move(attributes));
  }
  return std::make_shared<const Mesh>(std::move(cube));
}

class Reader {
 public:
  Reader(std::string_view text, const ImportLimits& limits)
      : tokens_(text), limits_(limits), budget_(limits) {}

  Result<SceneDescription> read();

 private:
  Status advance() {
    auto token = tokens_.next();
    if (!token) return token.error();
    token_ = *token;
    return success();
  }
  Status expect(const char* sign) {
    if (!token_.is(sign)) {
      return broken(token_.line, std::string("\"") + sign + "\" is missing before \"" +
                                     gltf::shortened(token_.text) + "\"");
    }
    return advance();
  }
  Status skip_braces();
  Status skip_rest(std::size_t line);
  Status read_pigment(Pigment& pigment);
  Status read_texture(Pigment& pigment);
  Status read_colour(std::optional<Colour>& colour);
  Status read_channels(std::size_t count, std::array<double, 5>& channels, bool& is_known);
  Status read_number(double& out);
  Status read_vector(Vec3d& out);
  Status read_box();
  Status add_box(const Vec3d& a, const Vec3d& b, std::size_t line, const Pigment& pigment);

  Tokens tokens_;
  Token token_;
  const ImportLimits& limits_;
  gltf::Budget budget_;
  SceneDescription scene_;
  std::map<std::string, std::uint32_t> mesh_of_pigment_;
};

/// From "{" to behind its "}".
Status Reader::skip_braces() {
  const std::size_t line = token_.line;
  if (Status status = expect("{"); !status) return status;
  return skip_rest(line);
}

/// From within braces, which begin in a line, to behind their "}".
Status Reader::skip_rest(std::size_t line) {
  std::size_t depth = 1;
  do {
    if (token_.kind == TokenKind::kEnd) return broken(line, "\"{\" has no \"}\"");
    if (token_.is("{")) ++depth;
    if (token_.is("}")) --depth;
    if (depth > limits_.json_depth) {
      return gltf::beyond_limit("JSON_DEPTH", "line " + std::to_string(token_.line) + ": braces",
                                depth, limits_.json_depth);
    }
    if (Status status = advance(); !status) return status;
  } while (depth > 0);
  return success();
}

/// From "{" to behind its "}".
Status Reader::read_pigment(Pigment& pigment) {
  const Token first = token_;
  if (Status status = expect("{"); !status) return status;
  std::optional<Colour> colour;
  if (Status status = read_colour(colour); !status) return status;
  // With anything more, such as a pattern, a transform or a map, it is not one colour.
  const bool is_plain = token_.is("}");
  if (Status status = skip_rest(first.line); !status) return status;
  if (!pigment.text.empty()) return success();
  const std::string_view written = tokens_.between(first, token_);
  pigment.text = gltf::shortened(written.substr(0, written.rfind('}') + 1), 200);
  if (is_plain) pigment.colour = colour;
  return success();
}

/// The pigment in a texture. From "{" to behind its "}".
Status Reader::read_texture(Pigment& pigment) {
  const std::size_t line = token_.line;
  if (Status status = expect("{"); !status) return status;
  while (!token_.is("}") && token_.kind != TokenKind::kEnd) {
    const bool is_pigment = token_.is("pigment");
    Status status = token_.is("{") ? skip_braces() : advance();
    if (status && is_pigment && token_.is("{")) status = read_pigment(pigment);
    if (!status) return status;
  }
  return skip_rest(line);
}

/// "rgb <1, 0, 0>" and its kin, if that comes next: POV-Ray 3.7, 3.4.5. Alpha is what neither the
/// filter nor the transmit channel lets through.
Status Reader::read_colour(std::optional<Colour>& colour) {
  if (token_.is("color") || token_.is("colour")) {
    if (Status status = advance(); !status) return status;
  }
  const std::string_view kind = token_.text;
  if (token_.kind != TokenKind::kName || kind.substr(0, 3) != "rgb") return success();
  const std::string_view more = kind.substr(3);
  if (!more.empty() && more != "f" && more != "t" && more != "ft") return success();
  if (Status status = advance(); !status) return status;
  std::array<double, 5> channels{};
  bool is_known = false;
  if (Status status = read_channels(3 + more.size(), channels, is_known); !status) return status;
  if (is_known) colour = {channels[0], channels[1], channels[2], 1 - channels[3] - channels[4]};
  return success();
}

/// A vector, one number for all channels, or a unit vector.
Status Reader::read_channels(std::size_t count, std::array<double, 5>& channels, bool& is_known) {
  constexpr std::array<std::string_view, 3> kUnits = {"x", "y", "z"};
  if (const auto unit = std::find(kUnits.begin(), kUnits.end(), token_.text);
      token_.kind == TokenKind::kName && unit != kUnits.end()) {
    channels[static_cast<std::size_t>(unit - kUnits.begin())] = 1;
    is_known = true;
    return advance();
  }
  const bool is_vector = token_.is("<");
  if (is_vector) {
    if (Status status = advance(); !status) return status;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_number = token_.kind == TokenKind::kNumber || token_.is("-") || token_.is("+");
    if (!is_number && (is_vector || i == 0)) return success();
    if (i > 0 && !is_vector) {
      channels[i] = channels[0];
      continue;
    }
    if (Status status = read_number(channels[i]); !status) return status;
    if (is_vector && i + 1 < count) {
      if (!token_.is(",")) return success();
      if (Status status = advance(); !status) return status;
    }
  }
  is_known = !is_vector || token_.is(">");
  return is_known && is_vector ? advance() : success();
}

Status Reader::read_number(double& out) {
  double sign = 1;
  if (token_.is("-") || token_.is("+")) {
    sign = token_.is("-") ? -1 : 1;
    if (Status status = advance(); !status) return status;
  }
  if (token_.kind == TokenKind::kName) return unsupported(token_);
  if (token_.kind != TokenKind::kNumber) return broken(token_.line, "a number is missing");
  out = sign * token_.number;
  // As for glTF's matrices: then world positions stay far from overflow.
  if (!(std::fabs(out) <= static_cast<double>(std::numeric_limits<float>::max()))) {
    return broken(token_.line, "a corner is more than a float32 can hold");
  }
  return advance();
}

Status Reader::read_vector(Vec3d& out) {
  if (Status status = expect("<"); !status) return status;
  if (Status status = read_number(out.x); !status) return status;
  if (Status status = expect(","); !status) return status;
  if (Status status = read_number(out.y); !status) return status;
  if (Status status = expect(","); !status) return status;
  if (Status status = read_number(out.z); !status) return status;
  return expect(">");
}

Status Reader::read_box() {
  const std::size_t line = token_.line;
  Vec3d a, b;
  if (Status status = advance(); !status) return status;
  if (Status status = expect("{"); !status) return status;
  if (Status status = read_vector(a); !status) return status;
  if (Status status = expect(","); !status) return status;
  if (Status status = read_vector(b); !status) return status;
  Pigment pigment;
  while (!token_.is("}")) {
    if (token_.kind == TokenKind::kEnd) return broken(line, "\"{\" has no \"}\"");
    const bool has_braces = contains(kLooks, token_.text);
    if (token_.kind != TokenKind::kName || !(has_braces || contains(kFlags, token_.text))) {
      return unsupported(token_);
    }
    const bool is_pigment = token_.is("pigment"), is_texture = token_.is("texture");
    if (Status status = advance(); !status) return status;
    if (!has_braces) continue;
    Status status = is_pigment   ? read_pigment(pigment)
                    : is_texture ? read_texture(pigment)
                                 : skip_braces();
    if (!status) return status;
  }
  if (Status status = advance(); !status) return status;
  return add_box(a, b, line, pigment);
}

Status Reader::add_box(const Vec3d& a, const Vec3d& b, std::size_t line, const Pigment& pigment) {
  if (scene_.instances.size() >= limits_.instances) {
    return gltf::beyond_limit("INSTANCES", "line " + std::to_string(line) + ": boxes",
                              scene_.instances.size() + 1, limits_.instances);
  }
  const auto [known, is_new] =
      mesh_of_pigment_.try_emplace(pigment.text, static_cast<std::uint32_t>(scene_.meshes.size()));
  std::uint64_t bytes = sizeof(Instance) + sizeof(Node);
  if (is_new) bytes += sizeof(Mesh) + 8 * sizeof(Vec3f) + 36 * sizeof(std::uint32_t);
  if (Status status = budget_.spend_bytes(bytes); !status) return status;
  if (is_new) {
    scene_.meshes.push_back(make_cube(known->second, pigment.colour));
    scene_.materials.push_back({pigment.text, false});
  }
  Affine matrix;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::min(a[axis], b[axis]), high = std::max(a[axis], b[axis]);
    matrix.m[axis][axis] = edge_between(low, high);
    matrix.m[axis][3] = low;
  }
  const auto number = static_cast<std::uint32_t>(scene_.nodes.size());
  Node node;
  node.name = "box, line " + std::to_string(line);
  node.file_node = number;
  node.parent_from_node = matrix;
  node.world_from_node = matrix;
  scene_.nodes.push_back(std::move(node));
  scene_.instances.push_back({known->second, number, matrix});
  return success();
}

Result<SceneDescription> Reader::read() {
  if (Status status = advance(); !status) return status.error();
  while (token_.kind != TokenKind::kEnd) {
    Status status = success();
    if (token_.is("box")) {
      status = read_box();
    } else if (token_.kind == TokenKind::kName && contains(kSkipped, token_.text)) {
      status = advance();
      if (status) status = skip_braces();
    } else if (token_.is("#")) {
      status = advance();
      if (status && !token_.is("version")) return unsupported(token_);
      if (status) status = advance();
      double version = 0;
      if (status) status = read_number(version);
      if (status) status = expect(";");
    } else {
      return token_.kind == TokenKind::kName
                 ? unsupported(token_)
                 : broken(token_.line,
                          "\"" + gltf::shortened(token_.text) + "\" is not expected here");
    }
    if (!status) return status.error();
  }
  return std::move(scene_);
}

}  // namespace

bool looks_like_pov(std::string_view text) {
  Tokens tokens(text);
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) return false;
  const auto first = tokens.next();
  if (!first) return false;
  if (first->is("#")) {
    const auto second = tokens.next();
    return second.ok() && second->kind == TokenKind::kName;
  }
  return first->kind == TokenKind::kName && (first->is("box") || contains(kSkipped, first->text));
}

Result<SceneDescription> import_boxes(std::string_view text, const ImportLimits& limits) {
  if (text.size() > limits.json_bytes) {
    return gltf::beyond_limit("JSON_BYTES", "bytes of text", text.size(), limits.json_bytes);
  }
  auto scene = Reader(text, limits).read();
  if (!scene) return scene;
  scene->counts.file_bytes = text.size();
  scene->counts.touched.json = text.size();
  scene->counts.bytes_touched = text.size();
  return scene;
}

}  // namespace sightline::pov
