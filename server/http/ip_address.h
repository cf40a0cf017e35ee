#pragma once
/// Internet addresses, and which of them a server may connect to at the request of a client.

#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline {

/// An IPv4 or IPv6 address, without a port.
struct IpAddress {
  bool is_v4 = false;
  std::array<std::uint8_t, 16> bytes{};  ///< in network order; an IPv4 address has the first four

  /// Parses an address in text form; empty if it is none.
  static std::optional<IpAddress> parse(const std::string& text);
  /// The address of a socket; empty for families other than IPv4 and IPv6.
  static std::optional<IpAddress> of(const sockaddr* address);
  /// The IPv4 address in ::ffff:a.b.c.d; other addresses unchanged.
  IpAddress unmapped() const;
};

/// True if the address is reachable from the public internet. False for private, loopback,
/// link-local, shared (CGNAT), multicast, reserved and documentation addresses of both versions,
/// and for IPv6 addresses that contain an IPv4 address (mapped, translated, 6to4, Teredo).
/// [RFC6890] and its registries.
bool is_public(const IpAddress& address);

/// True for 127.0.0.0/8 and ::1, which only programs on this machine can reach; also for their
/// mapped form.
bool is_loopback(const IpAddress& address);
/// True for the text of a loopback address, without brackets, and for "localhost". Other names may
/// resolve to any address.
bool is_local_host(const std::string& host);

/// The name or address in a Host field or an origin, without its port and without the brackets of
/// [::1]. Empty if the text is not "name", "name:port", "[IPv6]" or "[IPv6]:port" [RFC3986] 3.2.
std::optional<std::string> host_name(std::string_view host);

/// A range of addresses: "10.0.0.0/8", "fd00::/8", or a single address. An address of the other
/// version is in no range, not even in its mapped form: see IpAddress::unmapped.
class AddressRange {
 public:
  /// Parses a range. Errors: ADDRESS_RANGE_INVALID.
  static Result<AddressRange> parse(const std::string& text);
  /// True if the address is in the range.
  bool contains(const IpAddress& address) const;

 private:
  IpAddress base_;
  int bits_ = 0;
};

}  // namespace sightline
