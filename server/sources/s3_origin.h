#pragma once
/// S3Origin: an Origin in a bucket of an object store that speaks the protocol of Amazon S3.

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/store/origin.h"

namespace sightline {

/// A bucket, and the credentials for it.
struct S3Bucket {
  std::string
      endpoint;  ///< scheme, host and port of the store: "https://s3.eu-west-1.amazonaws.com"
  std::string bucket;
  std::string prefix;  ///< of all names; empty, or ends with '/'
  std::string region;  ///< "us-east-1"
  std::string key_id;
  std::string secret;
  std::string token;  ///< of temporary credentials; empty: none
};

/// Requests are signed with Signature Version 4 by libcurl, and name the bucket in the path. The
/// bytes of files are not signed; their names tell their hash. Requests that only read are repeated
/// twice if the store is unreachable. Connections are reused.
///
/// The store must support `If-None-Match: *` for PUT; Amazon S3 does since August 2024. A listing
/// must show what was written before it.
class S3Origin final : public Origin {
 public:
  explicit S3Origin(S3Bucket bucket);
  ~S3Origin() override;

  Result<bool> create(const std::string& name, std::string_view content) override;
  /// At most 5 GiB, as S3 accepts in one request.
  Result<bool> create(const std::string& name, const FileDescriptor& file,
                      std::uint64_t bytes) override;
  Result<bool> read(const std::string& name,
                    const std::function<Status(std::span<const std::byte>)>& sink) override;
  Result<std::vector<OriginObject>> list(const std::string& prefix,
                                         const std::string& after) override;
  Status remove(const std::string& name) override;

 private:
  struct Request;
  class Connection;
  /// Sends a request, and returns the status of the answer. Errors: ORIGIN_UNREACHABLE.
  Result<long> send(Request& request);
  Result<long> send_again(Request& request);

  const S3Bucket bucket_;
  std::mutex mutex_;  ///< protects idle_
  std::vector<std::unique_ptr<Connection>> idle_;
};

}  // namespace sightline

// Tests: tests/integration/origin_test.py
