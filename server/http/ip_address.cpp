#include "server/http/ip_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <charconv>
#include <cstring>

namespace sightline {
namespace {

bool same_bits(const IpAddress& a, const IpAddress& b, int bits) {
  const auto whole = static_cast<std::size_t>(bits / 8);
  if (!std::equal(a.bytes.begin(), a.bytes.begin() + static_cast<std::ptrdiff_t>(whole),
                  b.bytes.begin())) {
    return false;
  }
  if (bits % 8 == 0) return true;
  const unsigned mask = 0xff00u >> (bits % 8) & 0xffu;
  return (a.bytes[whole] & mask) == (b.bytes[whole] & mask);
}

bool is_in(const IpAddress& address, std::initializer_list<const char*> ranges) {
  return std::any_of(ranges.begin(), ranges.end(), [&](const char* text) {
    const auto range = AddressRange::parse(text);
    return range.ok() && range->contains(address);
  });
}

}  // namespace

std::optional<IpAddress> IpAddress::parse(const std::string& text) {
  IpAddress address;
  if (::inet_pton(AF_INET, text.c_str(), address.bytes.data()) == 1) {
    address.is_v4 = true;
    return address;
  }
  if (::inet_pton(AF_INET6, text.c_str(), address.bytes.data()) == 1) return address;
  return std::nullopt;
}

std::optional<IpAddress> IpAddress::of(const sockaddr* address) {
  IpAddress result;
  if (address->sa_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, address, sizeof v4);
    result.is_v4 = true;
    std::memcpy(result.bytes.data(), &v4.sin_addr, 4);
    return result;
  }
  if (address->sa_family == AF_INET6) {
    sockaddr_in6 v6{};
    std::memcpy(&v6, address, sizeof v6);
    std::memcpy(result.bytes.data(), &v6.sin6_addr, 16);
    return result;
  }
  return std::nullopt;
}

IpAddress IpAddress::unmapped() const {
  const bool is_mapped =
      !is_v4 &&
      std::all_of(bytes.begin(), bytes.begin() + 10, [](std::uint8_t byte) { return byte == 0; }) &&
      bytes[10] == 0xff && bytes[11] == 0xff;
  if (!is_mapped) return *this;
  IpAddress v4;
  v4.is_v4 = true;
  std::copy(bytes.begin() + 12, bytes.end(), v4.bytes.begin());
  return v4;
}

bool is_public(const IpAddress& address) {
  if (address.is_v4) {
    return !is_in(address,
                  {"0.0.0.0/8", "10.0.0.0/8", "100.64.0.0/10", "127.0.0.0/8", "169.254.0.0/16",
                   "172.16.0.0/12", "192.0.0.0/24", "192.0.2.0/24", "192.31.196.0/24",
                   "192.52.193.0/24", "192.88.99.0/24", "192.168.0.0/16", "192.175.48.0/24",
                   "198.18.0.0/15", "198.51.100.0/24", "203.0.113.0/24", "224.0.0.0/3"});
  }
  // Of IPv6 only 2000::/3 is given to the public; what follows are its exceptions.
  return is_in(address, {"2000::/3"}) && !is_in(address, {"2001::/23", "2001:db8::/32", "2002::/16",
                                                          "2620:4f:8000::/48", "3fff::/20"});
}

bool is_loopback(const IpAddress& address) {
  return is_in(address.unmapped(), {"127.0.0.0/8", "::1"});
}

bool is_local_host(const std::string& host) {
  const auto address = IpAddress::parse(host);
  return address ? is_loopback(*address) : host == "localhost";
}

std::optional<std::string> host_name(std::string_view host) {
  std::string name;
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    name = host.substr(1, end - 1);
    const auto address = IpAddress::parse(name);
    if (!address || address->is_v4) return std::nullopt;
    host.remove_prefix(end + 1);
  } else {
    name = host.substr(0, host.find(':'));
    if (name.find('[') != name.npos || name.find(']') != name.npos) return std::nullopt;
    host.remove_prefix(name.size());
  }
  const bool is_port =
      host.starts_with(':') &&
      std::all_of(host.begin() + 1, host.end(), [](char c) { return c >= '0' && c <= '9'; });
  return host.empty() || is_port ? std::optional(name) : std::nullopt;
}

Result<AddressRange> AddressRange::parse(const std::string& text) {
  const Error invalid{ErrorKind::kInvalid, "ADDRESS_RANGE_INVALID",
                      "'" + text + "' is no range of addresses: write 10.0.0.0/8 or fd00::/8", ""};
  const std::size_t slash = text.find('/');
  const auto base = IpAddress::parse(text.substr(0, slash));
  if (!base) return invalid;
  AddressRange range;
  range.base_ = *base;
  const int most = base->is_v4 ? 32 : 128;
  range.bits_ = most;
  if (slash != std::string::npos) {
    const char* begin = text.data() + slash + 1;
    const char* end = text.data() + text.size();
    const auto [last, error] = std::from_chars(begin, end, range.bits_);
    if (begin == end || error != std::errc() || last != end) return invalid;
    if (range.bits_ < 0 || range.bits_ > most) return invalid;
  }
  return range;
}

bool AddressRange::contains(const IpAddress& address) const {
  return address.is_v4 == base_.is_v4 && same_bits(address, base_, bits_);
}

}  // namespace sightline
