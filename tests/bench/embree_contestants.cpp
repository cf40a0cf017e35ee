#include <algorithm>
#include <cstring>
#include <limits>
#include <map>

#include "tests/bench/contestant.h"
#include "tests/bench/embree_scene.h"

namespace sightline::bench {

namespace {

constexpr unsigned kNobody = RTC_INVALID_GEOMETRY_ID;

class EmbreeContestant : public Contestant {
 public:
  EmbreeContestant(std::string name, std::shared_ptr<const EmbreeScene> scene, bool coherent)
      : Contestant(std::move(name)), scene_(std::move(scene)), coherent_(coherent) {}

  /// Where there are instances, rtcOccluded16 and rtcOccluded1M of Embree 3.13.5 with the coherent
  /// flag read stack memory that they never wrote, and may loop for ever (they do after calls
  /// without the flag; never on a stack of zeros).
  bool knows_any() const override { return !(coherent_ && scene_->has_instances()); }

 protected:
  RTCScene top() const { return scene_->top(); }
  RTCIntersectContext context() const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags =
        coherent_ ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return context;
  }

 private:
  std::shared_ptr<const EmbreeScene> scene_;
  bool coherent_;
};

void fill(const FloatRays& from, std::size_t i, RTCRay& to) {
  to.org_x = from.ox[i];
  to.org_y = from.oy[i];
  to.org_z = from.oz[i];
  to.tnear = from.tmin[i];
  to.dir_x = from.dx[i];
  to.dir_y = from.dy[i];
  to.dir_z = from.dz[i];
  to.time = 0;
  to.tfar = from.tmax[i];
  to.mask = ~0u;
  to.id = 0;
  to.flags = 0;
}

void fill(const FloatRays& from, std::size_t i, RTCRayHit& to) {
  fill(from, i, to.ray);
  to.hit.geomID = kNobody;
  to.hit.instID[0] = kNobody;
}

void unpack(const RTCRayHit& from, Answers& to, std::size_t i) {
  const bool hit = from.hit.geomID != kNobody;
  to.t[i] = hit ? from.ray.tfar : std::numeric_limits<float>::infinity();
  to.hits.instance[i] = hit ? EmbreeScene::instance_of(from.hit.geomID, from.hit.instID[0]) : kNone;
  to.hits.triangle[i] = hit ? from.hit.primID : kNone;
}

/// rtcIntersect1 and rtcOccluded1.
class EmbreeSingle : public EmbreeContestant {
 public:
  using EmbreeContestant::EmbreeContestant;

  void closest(const RaySet& rays, Answers& answers) const override {
    RTCIntersectContext how = context();
    RTCRayHit one;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      fill(rays.floats, i, one);
      rtcIntersect1(top(), &how, &one);
      unpack(one, answers, i);
    }
  }
  void any(const RaySet& rays, Answers& answers) const override {
    RTCIntersectContext how = context();
    RTCRay one;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      fill(rays.floats, i, one);
      rtcOccluded1(top(), &how, &one);
      answers.occluded[i] = one.tfar < 0 ? 1 : 0;
    }
  }
};

template <std::size_t kWidth>
struct Packet;
template <>
struct Packet<8> {
  using RayHit = RTCRayHit8;
  using Ray = RTCRay8;
  static constexpr auto intersect = rtcIntersect8;
  static constexpr auto occluded = rtcOccluded8;
};
template <>
struct Packet<16> {
  using RayHit = RTCRayHit16;
  using Ray = RTCRay16;
  static constexpr auto intersect = rtcIntersect16;
  static constexpr auto occluded = rtcOccluded16;
};

/// rtcIntersect8/16 and rtcOccluded8/16 over neighbours in the set.
template <std::size_t kWidth>
class EmbreePacket : public EmbreeContestant {
 public:
  using EmbreeContestant::EmbreeContestant;

  void closest(const RaySet& rays, Answers& answers) const override {
    RTCIntersectContext how = context();
    typename Packet<kWidth>::RayHit packet;
    alignas(64) int valid[kWidth];
    for (std::size_t i = 0; i < rays.size(); i += kWidth) {
      const std::size_t count = fill_packet(rays.floats, i, packet.ray, valid);
      std::fill_n(packet.hit.geomID, kWidth, kNobody);
      std::fill_n(packet.hit.instID[0], kWidth, kNobody);
      Packet<kWidth>::intersect(valid, top(), &how, &packet);
      for (std::size_t lane = 0; lane < count; ++lane) {
        const unsigned geometry = packet.hit.geomID[lane];
        const bool hit = geometry != kNobody;
        answers.t[i + lane] = hit ? packet.ray.tfar[lane] : std::numeric_limits<float>::infinity();
        answers.hits.instance[i + lane] =
            hit ? EmbreeScene::instance_of(geometry, packet.hit.instID[0][lane]) : kNone;
        answers.hits.triangle[i + lane] = hit ? packet.hit.primID[lane] : kNone;
      }
    }
  }
  void any(const RaySet& rays, Answers& answers) const override {
    RTCIntersectContext how = context();
    typename Packet<kWidth>::Ray packet;
    alignas(64) int valid[kWidth];
    for (std::size_t i = 0; i < rays.size(); i += kWidth) {
      const std::size_t count = fill_packet(rays.floats, i, packet, valid);
      Packet<kWidth>::occluded(valid, top(), &how, &packet);
      for (std::size_t lane = 0; lane < count; ++lane) {
        answers.occluded[i + lane] = packet.tfar[lane] < 0 ? 1 : 0;
      }
    }
  }

 private:
  /// Lanes past the end are switched off, and repeat the first ray.
  static std::size_t fill_packet(const FloatRays& from, std::size_t i,
                                 typename Packet<kWidth>::Ray& to, int* valid) {
    const std::size_t count = std::min(kWidth, from.ox.size() - i);
    const auto column = [&](float* lanes, const Column<float>& values) {
      if (count == kWidth) {
        std::memcpy(lanes, values.data() + i, kWidth * sizeof(float));
        return;
      }
      std::fill_n(lanes, kWidth, values[i]);
      std::copy_n(values.data() + i, count, lanes);
    };
    column(to.org_x, from.ox);
    column(to.org_y, from.oy);
    column(to.org_z, from.oz);
    column(to.tnear, from.tmin);
    column(to.dir_x, from.dx);
    column(to.dir_y, from.dy);
    column(to.dir_z, from.dz);
    column(to.tfar, from.tmax);
    std::fill_n(to.time, kWidth, 0.0f);
    std::fill_n(to.mask, kWidth, ~0u);
    std::fill_n(to.id, kWidth, 0u);
    std::fill_n(to.flags, kWidth, 0u);
    for (std::size_t lane = 0; lane < kWidth; ++lane) valid[lane] = lane < count ? -1 : 0;
    return count;
  }
};

/// rtcIntersect1M and rtcOccluded1M, a piece that stays in the second-level cache at a time.
class EmbreeStream : public EmbreeContestant {
 public:
  using EmbreeContestant::EmbreeContestant;

  void closest(const RaySet& rays, Answers& answers) const override {
    RTCIntersectContext how = context();
    std::vector<RTCRayHit> stream(kPiece);
    for (std::size_t i = 0; i < rays.size(); i += kPiece) {
      const std::size_t count = std::min(kPiece, rays.size() - i);
      for (std::size_t k = 0; k < count; ++k) fill(rays.floats, i + k, stream[k]);
      rtcIntersect1M(top(), &how, stream.data(), static_cast<unsigned>(count), sizeof(RTCRayHit));
      for (std::size_t k = 0; k < count; ++k) unpack(stream[k], answers, i + k);
    }
  }
  void any(const RaySet& rays, Answers& answers) const override {
    RTCIntersectContext how = context();
    std::vector<RTCRay> stream(kPiece);
    for (std::size_t i = 0; i < rays.size(); i += kPiece) {
      const std::size_t count = std::min(kPiece, rays.size() - i);
      for (std::size_t k = 0; k < count; ++k) fill(rays.floats, i + k, stream[k]);
      rtcOccluded1M(top(), &how, stream.data(), static_cast<unsigned>(count), sizeof(RTCRay));
      for (std::size_t k = 0; k < count; ++k) answers.occluded[i + k] = stream[k].tfar < 0 ? 1 : 0;
    }
  }

 private:
  static constexpr std::size_t kPiece = 1024;
};

enum class Entry { kSingle, kPacket8, kPacket16, kStream };

struct Variant {
  std::string name;
  Entry entry = Entry::kSingle;
  bool coherent = false;
  EmbreeOptions options;
};

/// Every way to ask Embree on a device of that configuration.
std::vector<Variant> variants_of(const char* device) {
  std::vector<Variant> all;
  const EmbreeOptions usual{device, RTC_SCENE_FLAG_NONE}, robust{device, RTC_SCENE_FLAG_ROBUST};
  all.push_back({"embree1", Entry::kSingle, false, usual});
  all.push_back({"embree1_robust", Entry::kSingle, false, robust});
  const std::pair<std::string, Entry> groups[] = {{"embree8", Entry::kPacket8},
                                                  {"embree16", Entry::kPacket16},
                                                  {"embree_stream", Entry::kStream}};
  for (const auto& [name, entry] : groups) {
    for (bool coherent : {true, false}) {
      const std::string flag = coherent ? "_coherent" : "_incoherent";
      all.push_back({name + flag, entry, coherent, usual});
      all.push_back({name + flag + "_robust", entry, coherent, robust});
    }
  }
  return all;
}

std::vector<Variant> variants() {
  std::vector<Variant> all = variants_of("");
  all.push_back({"embree1_avx2", Entry::kSingle, false, {"isa=avx2", RTC_SCENE_FLAG_NONE}});
  for (const auto& [suffix, device] :
       {std::pair{"@avx2", "isa=avx2"}, std::pair{"@sse4.2", "isa=sse4.2"}}) {
    for (Variant& variant : variants_of(device)) {
      variant.name += suffix;
      all.push_back(std::move(variant));
    }
  }
  return all;
}

}  // namespace

std::vector<std::string> embree_names() {
  std::vector<std::string> names;
  for (const Variant& variant : variants()) names.push_back(variant.name);
  return names;
}

std::vector<std::unique_ptr<Contestant>> make_embree(const std::vector<std::string>& names,
                                                     const BenchScene& scene) {
  std::map<std::pair<std::string, int>, std::shared_ptr<const EmbreeScene>> scenes;
  std::vector<std::unique_ptr<Contestant>> contestants;
  for (const Variant& v : variants()) {
    if (std::find(names.begin(), names.end(), v.name) == names.end()) continue;
    auto& built = scenes[{v.options.device, static_cast<int>(v.options.flags)}];
    if (!built) built = std::make_shared<EmbreeScene>(*scene.scene, v.options);
    switch (v.entry) {
      case Entry::kSingle:
        contestants.push_back(std::make_unique<EmbreeSingle>(v.name, built, v.coherent));
        break;
      case Entry::kPacket8:
        contestants.push_back(std::make_unique<EmbreePacket<8>>(v.name, built, v.coherent));
        break;
      case Entry::kPacket16:
        contestants.push_back(std::make_unique<EmbreePacket<16>>(v.name, built, v.coherent));
        break;
      case Entry::kStream:
        contestants.push_back(std::make_unique<EmbreeStream>(v.name, built, v.coherent));
        break;
    }
  }
  return contestants;
}

}  // namespace sightline::bench
