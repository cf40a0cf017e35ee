#include "server/sources/scene_sources.h"

namespace sightline {
namespace {

using Rules = std::shared_ptr<const SourceRules>;

Error at(Error error, const char* pointer) {
  error.pointer = pointer;
  return error;
}

Result<SceneFetch> fetch_path(const LoadRequest& request, const Rules& rules, std::uint64_t limit) {
  if (!rules->root) {
    return Error{ErrorKind::kInvalid, "PATH_NOT_ALLOWED",
                 "this server takes no paths: it runs without --scene-root", "/source/path"};
  }
  // Opened again when its turn comes: what waits should hold no files.
  if (auto file = rules->root->open_file(request.path, limit); !file) {
    return at(std::move(file).error(), "/source/path");
  }
  return SceneFetch([path = request.path, sha256 = request.sha256, rules,
                     limit](IncomingScene& incoming) -> Status {
    auto file = rules->root->open_file(path, limit);
    if (!file) return at(std::move(file).error(), "/source/path");
    incoming.expect(file->bytes);
    incoming.demand_sha256(sha256);
    const auto take = [&](std::span<const std::byte> piece) { return incoming.append(piece); };
    if (Status status = read_file(*file, limit, take); !status) return status;
    // All files of a scene share the limit; one thread asks for them.
    const auto left = std::make_shared<std::uint64_t>(limit - incoming.size());
    incoming.find_neighbours(
        [rules, path, limit, left](const std::string& name, const ByteSink& sink) -> Status {
          auto neighbour = rules->root->open_neighbour(path, name, limit);
          if (!neighbour) return std::move(neighbour).error();
          const auto count = [&](std::span<const std::byte> piece) -> Status {
            if (piece.size() > *left) return source_too_large(limit);
            *left -= piece.size();
            return sink(piece);
          };
          return read_file(*neighbour, limit, count);
        });
    return success();
  });
}

Result<SceneFetch> fetch_address(const LoadRequest& request, const Rules& rules,
                                 std::uint64_t limit) {
  auto url = SourceUrl::parse(request.url);
  if (!url) return at(std::move(url).error(), "/source/url");
  if (!matches_any(rules->urls.patterns, *url)) return at(url_not_allowed(), "/source/url");
  return SceneFetch([text = request.url, sha256 = request.sha256, rules,
                     limit](IncomingScene& incoming) -> Status {
    auto parsed = SourceUrl::parse(text);
    if (!parsed) return at(std::move(parsed).error(), "/source/url");
    incoming.demand_sha256(sha256);
    const UrlReceiver receiver{
        [&](std::uint64_t total) { incoming.expect(total); },
        [&](std::span<const std::byte> piece) { return incoming.append(piece); },
        [&] { return incoming.cancelled(); }};
    Status fetched = fetch_url(std::move(*parsed), rules->urls, limit, receiver);
    if (!fetched && fetched.error().pointer.empty()) {
      return at(std::move(fetched).error(), "/source/url");
    }
    return fetched;
  });
}

}  // namespace

Result<SceneFetch> fetch_of(const LoadRequest& request,
                            const std::shared_ptr<const SourceRules>& rules, std::uint64_t limit) {
  return request.url.empty() ? fetch_path(request, rules, limit)
                             : fetch_address(request, rules, limit);
}

}  // namespace sightline
