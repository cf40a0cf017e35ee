#include "tests/bench/http_bodies.h"

#include <cstring>

#include "proto/json/json_writer.h"

namespace sightline::bench {
namespace {

constexpr std::string_view kFields = R"("fields":["t","instance","primitive","triangle"])";

void write_ray(JsonWriter& out, const Ray& ray) {
  out.raw("{\"origin\":");
  out.vector(ray.origin.x, ray.origin.y, ray.origin.z);
  out.raw(",\"direction\":");
  out.vector(ray.direction.x, ray.direction.y, ray.direction.z);
  out.raw('}');
}

std::string rows_of(const RayBatch& rays) {
  JsonWriter out(rays.size() * 160);
  out.raw("{\"rays\":[");
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (i > 0) out.raw(',');
    write_ray(out, rays[i]);
  }
  out.raw("],");
  out.raw(kFields);
  out.raw('}');
  return out.take();
}

std::string columns_of(const RayBatch& rays) {
  JsonWriter out(rays.size() * 130);
  const auto column = [&](std::string_view key, Vec3d Ray::*part) {
    out.raw(key);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Ray ray = rays[i];
      const Vec3d& v = ray.*part;
      for (int k = 0; k < 3; ++k) {
        if (i > 0 || k > 0) out.raw(',');
        out.number(v[k]);
      }
    }
  };
  column("{\"origins\":[", &Ray::origin);
  column("],\"directions\":[", &Ray::direction);
  out.raw("],");
  out.raw(kFields);
  out.raw('}');
  return out.take();
}

std::string lines_of(const RayBatch& rays) {
  JsonWriter out(rays.size() * 160);
  out.raw("{\"options\":{");
  out.raw(kFields);
  out.raw("}}\n");
  for (std::size_t i = 0; i < rays.size(); ++i) {
    write_ray(out, rays[i]);
    out.raw('\n');
  }
  return out.take();
}

std::string binary_of(const RayBatch& rays) {
  constexpr std::size_t kHeaderBytes = 24;
  constexpr std::uint32_t kFloat64 = 1;
  const std::uint64_t count = rays.size();
  std::string out(kHeaderBytes, '\0');
  std::memcpy(out.data(), "SLR1", 4);
  std::memcpy(out.data() + 4, &kFloat64, 4);
  std::memcpy(out.data() + 8, &count, 8);
  for (const auto* column : {&rays.ox, &rays.oy, &rays.oz, &rays.dx, &rays.dy, &rays.dz}) {
    out.append(reinterpret_cast<const char*>(column->data()), column->size() * sizeof(double));
  }
  return out;
}

std::string_view media_type_of(Form form) {
  switch (form) {
    case Form::kLines:
      return "application/x-ndjson";
    case Form::kBinary:
      return "application/octet-stream";
    case Form::kRows:
    case Form::kColumns:
      break;
  }
  return "application/json";
}

}  // namespace

std::string_view form_name(Form form) {
  constexpr std::array<std::string_view, 4> kNames{"JSON rows", "JSON columns", "NDJSON", "binary"};
  return kNames[static_cast<std::size_t>(form)];
}

std::string body_of(const RayBatch& rays, Form form) {
  switch (form) {
    case Form::kRows:
      return rows_of(rays);
    case Form::kColumns:
      return columns_of(rays);
    case Form::kLines:
      return lines_of(rays);
    case Form::kBinary:
      break;
  }
  return binary_of(rays);
}

std::string request_of(const std::string& body, Form form) {
  std::string request =
      "POST /v1/scenes/bench/rays:closest HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: ";
  request.append(media_type_of(form)).append("\r\nContent-Length: ");
  return request.append(std::to_string(body.size())).append("\r\n\r\n").append(body);
}

}  // namespace sightline::bench
