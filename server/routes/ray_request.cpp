#include "server/routes/ray_request.h"

#include <algorithm>

#include "core/run/resolved_filter.h"
#include "core/run/unmatched_names.h"
#include "proto/binary/hit_binary.h"
#include "proto/binary/point_binary.h"
#include "proto/binary/ray_binary.h"
#include "proto/binary/ray_frames.h"
#include "proto/binary/sweep_binary.h"
#include "proto/json/hit_lines.h"
#include "server/http/body_reader.h"
#include "server/http/media_type.h"
#include "server/http/request_body.h"
#include "server/routes/column_reply.h"
#include "server/routes/ray_stream.h"
#include "server/routes/scene_admission.h"
#include "server/service/answer_memory.h"
#include "server/service/camera_rays.h"

namespace sightline {

bool RayRequest::is_for_worker() const {
  constexpr std::size_t kFew = 8;
  if (!exchange_.on_event_loop) return false;
  return query_.rays.size() > kFew || !query_.filter.accepts_all() || !query_.rays.mask.empty() ||
         scene_->has_empty_mask() || query_.alpha_cutoff || query_.wants_explanation ||
         !query_.ray_filters.empty() || query_.image || query_.fields.has_any_of(kAttributeFields);
}

std::uint64_t RayRequest::cost(std::size_t body_bytes) const {
  // Points, pairs and sweeps have no fewer bytes of JSON or binary columns each.
  constexpr std::size_t kItemBytes = 12;
  const std::string_view route = exchange_.route;
  if (route.ends_with("/rays:closest") || route.ends_with("/rays:any")) return query_.ray_count();
  // The pairs of triangles that it compares are not known before.
  if (route.ends_with("/clearance")) return scene_->instanced_triangle_count();
  return 8 * std::max<std::uint64_t>(exchange_.rays, body_bytes / kItemBytes);
}

bool RayRequest::read_query(const Decode& decode) {
  if (!scene_) scene_ = admit_query_of_scene(exchange_, service_);
  std::string body = std::move(begin_);
  if (!scene_ || !read_body(exchange_, service_.limits.query_bytes, kRayJsonPadding, body)) {
    return false;
  }
  timer_.restart();
  const Status read = decode(body, query_);
  if (!read) {
    exchange_.reply_error(with_form_hint(exchange_, read.error(), body));
    return false;
  }
  if (is_for_worker()) return false;
  if (exchange_.body != nullptr && !exchange_.body->may_cost(cost(body.size()))) return false;
  // What was decoded into something else than rays has no more bytes than twice its text.
  const std::uint64_t decoded = 2 * body.size();
  forget_body(exchange_, body, std::max(decoded, query_.rays.size() * kRayBytes));
  // To work a filter out takes time too, of a scene with many nodes or long names.
  deadline_ = deadline_of(exchange_, service_, query_.timeout_ms, query_.threads);
  auto resolved = resolve_for_rays(*scene_, query_.filter, query_.rays.mask, deadline_,
                                   reserve_from(exchange_.memory), warnings());
  if (!resolved) {
    exchange_.reply_error(resolved.error());
    return false;
  }
  resolved_ = std::move(*resolved);
  const Status known =
      tell_unknown_fields(scene_->description(), query_.named_fields, deadline_, warnings());
  if (!went_well(known)) return false;
  if (!query_.ray_filters.empty() && !group()) return false;
  add_time(&WorkReport::parse_us);
  return true;
}

bool RayRequest::group() {
  // The number of each ray, and a copy of the rays with their answers.
  const std::uint64_t bytes = sizeof(std::size_t) + kRayBytes + kHitBytes;
  if (!reserve(query_.rays.size() * bytes)) return false;
  auto groups = group_rays(*scene_, query_.rays, query_.ray_filters, query_.filter_of, deadline_,
                           reserve_from(exchange_.memory), warnings());
  if (groups) groups_ = std::move(*groups);
  return went_well(groups ? success() : Status(groups.error()));
}

bool RayRequest::streamed(RayQuestionKind kind, const Journal& journal) {
  if (!says_media_type(exchange_)) return false;
  const auto type = admit_rays_type(exchange_, true);
  if (type == QueryType::kJson) return false;
  if (!type || !admit_stream(exchange_)) return true;
  const bool is_lines = type == QueryType::kLines;
  // Where a stream is not admitted its body is not read: a client may wait to be told.
  const SceneSnapshot stored = admit_scene(exchange_, service_);
  if (!stored) return true;
  scene_ = stored->scene;
  const auto begun = [&](std::span<const char> piece) {
    begin_.append(piece.data(), piece.size());
    return begin_.size() < kStreamMagic.size();
  };
  // The first bytes say whether it is a stream.
  if (!is_lines && exchange_.body != nullptr && !exchange_.body->ask_for(kStreamMagic.size())) {
    return true;
  }
  if (!is_lines && exchange_.body != nullptr && !exchange_.body->read(begun) &&
      exchange_.body->fault() != BodyReader::Fault::kNoFault) {
    reply_body_fault(exchange_);
    return true;
  }
  if (!is_lines && !is_stream(begin_)) return !admit_body(exchange_, service_.limits.query_bytes);
  if (exchange_.body == nullptr || !exchange_.body->may_wait()) return true;
  RayStream::reply(exchange_, service_, journal, scene_, kind,
                   is_lines ? RayStream::Form::kLines : RayStream::Form::kFrames,
                   std::move(begin_));
  return true;
}

bool RayRequest::read_columns(FieldSet binary_fields, const DecodeColumns& decode) {
  const std::optional<QueryType> type = admit_rays_type(exchange_);
  return type && read_query([&](std::string& body, QueryOptions&) -> Status {
           const auto count = decode(body, *type == QueryType::kBinary);
           if (!count) return count.error();
           exchange_.rays = *count;
           return choose_bytes(binary_fields);
         });
}

bool RayRequest::read(RayJsonRules rules, Tables tables) {
  tables_ = tables;
  rules.max_rays = service_.limits.rays;
  rules.max_hits = service_.limits.hits;
  rules.has_filters = true;
  rules.find_camera = [this](const FileCamera& camera) { return camera_rays(*scene_, camera); };
  rules.admit_made = [this](std::uint64_t rays) { return exchange_.reserve(rays * kRayBytes); };
  const auto decode = [&](std::string& body, bool is_binary) -> Result<std::size_t> {
    auto decoded = is_binary ? decode_rays_binary(body, rules) : decode_rays(body, rules);
    if (!decoded) return decoded.error();
    query_ = std::move(*decoded);
    if (Status status = check_filters(query_); !status) return std::move(status).error();
    return query_.ray_count();
  };
  return read_columns(kDefaultBinaryFields, decode);
}

bool RayRequest::read_points(PointJsonRules rules, PointQuery& points) {
  rules.max_points = service_.limits.rays;
  const auto decode = [&](std::string& body, bool is_binary) -> Result<std::size_t> {
    auto decoded = is_binary ? decode_points_binary(body, rules) : decode_points(body, rules);
    if (!decoded) return decoded.error();
    points = std::move(*decoded);
    static_cast<QueryOptions&>(query_) = points.options;
    return points.items();
  };
  return read_columns(kDefaultBinaryNearestFields, decode);
}

bool RayRequest::read_sweeps(SweepJsonRules rules, SweepQuery& sweeps) {
  rules.max_sweeps = service_.limits.rays;
  const auto decode = [&](std::string& body, bool is_binary) -> Result<std::size_t> {
    auto decoded = is_binary ? decode_sweeps_binary(body, rules) : decode_sweeps(body, rules);
    if (!decoded) return decoded.error();
    sweeps = std::move(*decoded);
    static_cast<QueryOptions&>(query_) = sweeps.options;
    return sweeps.sweeps.count();
  };
  return read_columns(kDefaultBinaryFields, decode);
}

Status RayRequest::choose_bytes(FieldSet default_fields) {
  if (exchange_.wants(kBinaryMediaType)) {
    query_.layout = AnswerLayout::kBinary;
  }
  if (query_.image) {
    query_.layout = AnswerLayout::kImage;
    query_.image->floats = exchange_.wants(kFloatMapMediaType);
    return success();
  }
  choose_table();
  if (query_.layout != AnswerLayout::kBinary && !query_.table) return success();
  if (query_.wants_explanation) {
    return Error{ErrorKind::kInvalid, "EXPLAIN_IS_TEXT", "an explanation comes as JSON alone",
                 "/explain"};
  }
  if (!query_.chose_fields) query_.fields = default_fields;
  if (query_.table && is_point_cloud(*query_.table)) query_.fields.add(HitField::kPosition);
  const auto& named = query_.named_fields;
  if (tables_ != Tables::kHits) return check_binary_fields(query_.fields, named);
  if (query_.table == TableFormat::kNpz &&
      exchange_.rays > most_npz_rows(query_.fields, named.size())) {
    return Error{ErrorKind::kTooLarge, "REQUEST_TOO_LARGE",
                 "an .npz file has at most 4 GiB; ask for fewer rays or fields, or for .npy", ""};
  }
  if (query_.table == TableFormat::kCsv) return success();
  return check_binary_fields(query_.fields, query_.table ? std::span<const std::string>() : named);
}

void RayRequest::choose_table() {
  if (tables_ == Tables::kJson) return;
  query_.table = wanted_table(exchange_, tables_ == Tables::kHits);
  if (!query_.table) return;
  query_.layout = tables_ == Tables::kHits ? AnswerLayout::kTable : AnswerLayout::kBinary;
}

bool RayRequest::read_json(const Decode& decode, Tables tables) {
  tables_ = tables;
  const auto read = [&](std::string& body, QueryOptions& options) {
    Status status = decode(body, options);
    if (status && tables_ != Tables::kJson) status = choose_bytes(kDefaultBinaryFields);
    return status;
  };
  return admit_query_type(exchange_) && read_query(read);
}

bool RayRequest::describe(const RayBatch& rays, const HitBatch& hits, HitDescription& about) {
  const Status status = describe_within(reserve_from(exchange_.memory), service_.engine,
                                        {*scene_, rays, hits, query_.fields, query_.normalize,
                                         resolved_ ? &*resolved_ : nullptr, query_.named_fields},
                                        deadline_, about);
  add_time(&WorkReport::describe_us);
  return went_well(status);
}

void RayRequest::reply(std::string encoded, std::string_view media_type) {
  add_time(&WorkReport::print_us);
  // A client that has set a time no longer waits.
  if (query_.timeout_ms && !exchange_.on_event_loop && deadline_.passed()) {
    return exchange_.reply_error(out_of_time(deadline_));
  }
  if (query_.table && is_binary()) {
    auto table = table_of_columns(exchange_, *query_.table, encoded);
    if (!table) return exchange_.reply_error(table.error());
    encoded = std::move(*table);
  }
  if (media_type.empty() && query_.table) media_type = table_media_type(*query_.table);
  if (media_type.empty() && query_.image) media_type = query_.image->media_type();
  if (media_type.empty() && is_binary()) media_type = kBinaryMediaType;
  if (!media_type.empty()) {
    if (query_.wants_work)
      exchange_.response.set_header("X-Sightline-Work", encode_work(timer_.report));
    if (!warnings_.empty())
      exchange_.response.set_header("X-Sightline-Warnings", encode_warnings_header(warnings_));
    return exchange_.reply(200, std::move(encoded), media_type);
  }
  if (invalid() != nullptr) add_member(encoded, "invalid", encode_invalid(query_.invalid));
  if (!warnings_.empty()) add_member(encoded, "warnings", encode_warnings(warnings_));
  if (query_.wants_work) add_member(encoded, "work", encode_work(timer_.report));
  exchange_.reply_json(200, std::move(encoded));
}

void RayRequest::reply_hits(const HitBatch& hits, const HitDescription& about) {
  const FieldSet fields = query_.fields;
  reply(is_binary() ? encode_hits_binary(hits, about.details, about.terms, fields, nullptr)
                    : encode_hits(hits, about.details, about.terms, fields, AnswerLayout::kRows));
}

}  // namespace sightline
