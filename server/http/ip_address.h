#pragma once
/// Addresses of the internet, and which of them a server may be sent to by a stranger.

#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline {

struct IpAddress {
  bool is_v4 = false;
  std::array<std::uint8_t, 16> bytes{};  ///< network order; of IPv4 the first four

  static std::optional<IpAddress> parse(const std::string& text);
  /// Empty for another family.
  static std::optional<IpAddress> of(const sockaddr* address);
  /// The IPv4 address inside ::ffff:a.b.c.d, else itself.
  IpAddress unmapped() const;
};

/// Whether anybody on the internet could reach it. Not: private, loopback, link-local, shared
/// (CGNAT), multicast, reserved and documentation addresses of either version, and IPv6 addresses
/// that carry an IPv4 address (mapped, translated, 6to4, Teredo). [RFC6890] and its registries.
bool is_public(const IpAddress& address);

/// Whether only programs of this machine can reach it.
bool is_loopback(const IpAddress& address);
/// Whether a host is "127.0.0.1", "::1" or "localhost". Other names may lead anywhere.
bool is_local_host(const std::string& host);

/// The name or address in a Host field or in an origin, without its port and without the brackets
/// of
/// [::1]. Nothing where it is not "name", "name:port", "[IPv6]" or "[IPv6]:port" [RFC3986] 3.2.
std::optional<std::string> host_name(std::string_view host);

/// "10.0.0.0/8", "fd00::/8", or one address.
class AddressRange {
 public:
  /// Errors: ADDRESS_RANGE_INVALID.
  static Result<AddressRange> parse(const std::string& text);
  bool contains(const IpAddress& address) const;

 private:
  IpAddress base_;
  int bits_ = 0;
};

}  // namespace sightline
