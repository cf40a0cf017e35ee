#include "core/import/gltf/alpha_image.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <vector>

#include "core/import/input/refusal.h"

namespace sightline::gltf {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMostTexels = std::uint64_t{1} << 26;
constexpr std::uint64_t kPixelBytes = 4;  ///< of a decoded row, besides its alpha

double wrapped(double x, AlphaEntry::Wrap wrap) {
  switch (wrap) {
    case AlphaEntry::Wrap::kRepeat:
      return x - std::floor(x);
    case AlphaEntry::Wrap::kClamp:
      return std::clamp(x, 0.0, 1.0);
    case AlphaEntry::Wrap::kMirror:
      break;
  }
  const double m = x - 2 * std::floor(x / 2);
  return m > 1 ? 2 - m : m;
}

/// The image of a texture in the bytes of a file.
class AlphaImage final : public AlphaTexture {
 public:
  AlphaImage(AlphaEntry entry, SharedColumn<std::byte> bytes, std::string material)
      : entry_(std::move(entry)), bytes_(std::move(bytes)), material_(std::move(material)) {}

  Status prepare(const ReserveBytes& reserve) const override {
    const std::lock_guard guard(mutex_);
    if (is_decoded_) return success();
    if (!entry_.problem.empty()) return refused(entry_.problem);
    if (Status status = decode(reserve); !status) return status;
    is_decoded_ = true;
    return success();
  }

  std::uint8_t at(double u, double v) const override {
    if (alpha_.empty()) return 255;
    const auto place = [&](double x, std::size_t k, std::uint32_t size) {
      const double moved = entry_.offset[k] + entry_.scale[k] * x;
      const double cell = std::floor(wrapped(moved, entry_.wrap[k]) * size);
      return static_cast<std::size_t>(std::min(cell, static_cast<double>(size - 1)));
    };
    return alpha_[place(v, 1, height_) * width_ + place(u, 0, width_)];
  }

 private:
  Status refused(const std::string& why) const {
    return Error{ErrorKind::kInvalid, "ALPHA_UNREADABLE",
                 "the alpha of material " + material_ + " cannot be tested: " + why, "/alpha"};
  }

  bool begins_with(std::initializer_list<std::uint8_t> magic) const {
    return bytes_.size() >= magic.size() &&
           std::equal(magic.begin(), magic.end(), bytes_.begin(),
                      [](std::uint8_t a, std::byte b) { return std::byte{a} == b; });
  }

  Status decode(const ReserveBytes& reserve) const {
    if (begins_with({0xff, 0xd8, 0xff})) return success();  // a JPEG has no alpha
    if (!begins_with({0x89, 'P', 'N', 'G'})) return refused("its image is no PNG and no JPEG");
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    const std::unique_ptr<png_image, void (*)(png_image*)> owner(&image, png_image_free);
    if (png_image_begin_read_from_memory(&image, bytes_.data(), bytes_.size()) == 0)
      return refused(std::string("its image is damaged: ") + image.message);
    const std::uint64_t texels = std::uint64_t{image.width} * image.height;
    if (texels > kMostTexels) {
      return refused("its image has " + std::to_string(texels) + " texels, the limit is " +
                     std::to_string(kMostTexels));
    }
    if ((image.format & PNG_FORMAT_FLAG_ALPHA) == 0) return success();
    if (Status status = ask_for(reserve, texels * (kPixelBytes + 1)); !status) return status;
    image.format = PNG_FORMAT_RGBA;
    std::vector<std::uint8_t> pixels(texels * kPixelBytes);
    if (png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) == 0)
      return refused(std::string("its image is damaged: ") + image.message);
    alpha_.resize(texels);
    for (std::size_t i = 0; i < texels; ++i) alpha_[i] = pixels[i * kPixelBytes + 3];
    width_ = image.width;
    height_ = image.height;
    return success();
  }

  const AlphaEntry entry_;
  const SharedColumn<std::byte> bytes_;
  const std::string material_;
  mutable std::mutex mutex_;
  mutable bool is_decoded_ = false;
  mutable std::vector<std::uint8_t> alpha_;  ///< row by row; empty: 255 everywhere
  mutable std::uint32_t width_ = 0, height_ = 0;
};

/// An element of a section, or null.
const json* element(const json& root, const char* section, const json* index) {
  const auto list = root.find(section);
  if (list == root.end() || !list->is_array() || index == nullptr || !index->is_number_unsigned() ||
      index->get<std::uint64_t>() >= list->size()) {
    return nullptr;
  }
  const json& found = (*list)[index->get<std::size_t>()];
  return found.is_object() ? &found : nullptr;
}

const json* member(const json* object, const char* key) {
  if (object == nullptr || !object->is_object()) return nullptr;
  const auto found = object->find(key);
  return found == object->end() ? nullptr : &*found;
}

bool read_pair(const json* list, std::array<double, 2>& out) {
  if (list == nullptr) return true;
  if (!list->is_array() || list->size() != 2 || !(*list)[0].is_number() || !(*list)[1].is_number())
    return false;
  out = {(*list)[0].get<double>(), (*list)[1].get<double>()};
  return true;
}

AlphaEntry::Wrap wrap_of(const json* sampler, const char* key) {
  constexpr int kClampToEdge = 33071, kMirroredRepeat = 33648;  // [glTF2] 5.26
  const json* stated = member(sampler, key);
  if (stated == nullptr || *stated == 10497) return AlphaEntry::Wrap::kRepeat;
  return *stated == kClampToEdge      ? AlphaEntry::Wrap::kClamp
         : *stated == kMirroredRepeat ? AlphaEntry::Wrap::kMirror
                                      : AlphaEntry::Wrap::kRepeat;
}

/// Reads a textureInfo.
void read_texture(const json& root, const json& info, AlphaEntry& entry) {
  const auto fail = [&](const char* why) { entry.problem = why; };
  const json* texture = element(root, "textures", member(&info, "index"));
  const json* image = element(root, "images", member(texture, "source"));
  if (image == nullptr) return fail("its texture has no PNG or JPEG image");
  const json* view = member(image, "bufferView");
  if (view == nullptr) return fail("its image is not in the scene's own file");
  if (element(root, "bufferViews", view) == nullptr) return fail("its bufferView does not exist");
  entry.view = view->get<std::size_t>();
  const json* sampler = element(root, "samplers", member(texture, "sampler"));
  entry.wrap = {wrap_of(sampler, "wrapS"), wrap_of(sampler, "wrapT")};
  const json* set = member(&info, "texCoord");
  const json* transform = member(member(&info, "extensions"), "KHR_texture_transform");
  if (const json* other = member(transform, "texCoord")) set = other;
  if (set != nullptr && *set != 0)
    return fail("its texture uses other coordinates than TEXCOORD_0");
  if (const json* rotation = member(transform, "rotation"); rotation != nullptr && *rotation != 0)
    return fail("its texture is rotated");
  if (!read_pair(member(transform, "offset"), entry.offset) ||
      !read_pair(member(transform, "scale"), entry.scale)) {
    fail("its texture transform is invalid");
  }
}

}  // namespace

void take_alpha(const json& root, GltfDocument& document) {
  const auto materials = root.find("materials");
  if (materials == root.end() || !materials->is_array()) return;
  for (std::size_t i = 0; i < materials->size(); ++i) {
    const json* mode = member(&(*materials)[i], "alphaMode");
    if (mode == nullptr || *mode != "MASK") continue;
    AlphaEntry entry;
    if (const json* cutoff = member(&(*materials)[i], "alphaCutoff")) {
      if (cutoff->is_number()) {
        entry.cutoff = cutoff->get<double>();
      } else {
        entry.problem = "its alphaCutoff is no number";
      }
    }
    const json* metallic = member(&(*materials)[i], "pbrMetallicRoughness");
    const json* texture = member(metallic, "baseColorTexture");
    entry.has_texture = texture != nullptr;
    if (texture != nullptr && entry.problem.empty()) read_texture(root, *texture, entry);
    document.alpha[i] = std::move(entry);
  }
}

Status attach_alpha(const GltfDocument& document, ViewStore& views, const SharedBytes& shared,
                    bool copies, Budget& budget, SceneDescription& scene) {
  for (const auto& [number, stated] : document.alpha) {
    if (number >= scene.materials.size()) continue;
    Material& material = scene.materials[number];
    material.alpha_cutoff = stated.cutoff;
    if (!stated.has_texture && stated.problem.empty()) continue;
    AlphaEntry entry = stated;
    SharedColumn<std::byte> bytes;
    if (entry.problem.empty() && views.is_at_hand(entry.view) && !views.is_meshopt(entry.view)) {
      if (const auto found = views.bytes(entry.view)) {
        bytes = shared.share<std::byte>(found->data(), found->size());
        if (bytes.empty() && copies) {
          if (Status status = budget.spend_bytes(found->size()); !status) return status;
          bytes = UnsetColumn<std::byte>(found->begin(), found->end());
        }
      }
    }
    if (entry.problem.empty() && bytes.empty())
      entry.problem = "its image is not in the scene's own file";
    const std::string name =
        material.name.empty() ? std::to_string(number) : "\"" + shortened(material.name) + "\"";
    material.alpha_texture =
        std::make_shared<const AlphaImage>(std::move(entry), std::move(bytes), name);
  }
  return success();
}

}  // namespace sightline::gltf
