#include "server/http/ip_address.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

bool is_public(const char* text) {
  const auto address = IpAddress::parse(text);
  EXPECT_TRUE(address) << text;
  return address && sightline::is_public(*address);
}

TEST(IpAddress, tells_what_the_public_reaches_from_what_it_does_not) {
  for (const char* text :
       {"1.1.1.1", "8.8.8.8", "9.255.255.255", "11.0.0.0", "100.63.255.255", "100.128.0.0",
        "126.255.255.255", "128.0.0.0", "172.15.255.255", "172.32.0.0", "192.167.255.255",
        "192.169.0.0", "223.255.255.255", "2606:4700::1", "2a00:1450::1", "2001:4860:4860::8888"}) {
    EXPECT_TRUE(is_public(text)) << text;
  }
  for (const char* text : {"0.0.0.0",
                           "0.1.2.3",
                           "10.1.2.3",
                           "100.64.0.1",
                           "100.127.255.255",
                           "127.0.0.1",
                           "127.255.255.254",
                           "169.254.169.254",
                           "172.16.0.1",
                           "172.31.255.255",
                           "192.0.0.8",
                           "192.0.2.1",
                           "192.88.99.1",
                           "192.168.1.1",
                           "198.18.0.1",
                           "198.19.255.255",
                           "198.51.100.1",
                           "203.0.113.1",
                           "224.0.0.1",
                           "239.255.255.255",
                           "240.0.0.1",
                           "255.255.255.255",
                           "::",
                           "::1",
                           "::ffff:127.0.0.1",
                           "::ffff:8.8.8.8",
                           "::127.0.0.1",
                           "64:ff9b::7f00:1",
                           "64:ff9b:1::1",
                           "100::1",
                           "2001::1",
                           "2001:20::1",
                           "2001:db8::1",
                           "2002:7f00:1::",
                           "3fff::1",
                           "fc00::1",
                           "fd12::1",
                           "fe80::1",
                           "fec0::1",
                           "ff02::1",
                           "5f00::1"}) {
    EXPECT_FALSE(is_public(text)) << text;
  }
}

TEST(AddressRange, holds_what_shares_its_first_bits) {
  const auto holds = [](const char* range, const char* address) {
    const auto parsed = AddressRange::parse(range);
    return parsed.ok() && parsed->contains(*IpAddress::parse(address));
  };
  EXPECT_TRUE(holds("127.0.0.1", "127.0.0.1"));
  EXPECT_FALSE(holds("127.0.0.1", "127.0.0.2"));
  EXPECT_TRUE(holds("10.0.0.0/9", "10.127.255.255"));
  EXPECT_FALSE(holds("10.0.0.0/9", "10.128.0.0"));
  EXPECT_TRUE(holds("0.0.0.0/0", "255.255.255.255"));
  EXPECT_FALSE(holds("0.0.0.0/0", "::1"));
  EXPECT_TRUE(holds("fd00::/8", "fdff::1"));
  EXPECT_FALSE(holds("fd00::/8", "fc00::1"));
  EXPECT_TRUE(IpAddress::parse("::ffff:10.0.0.1")->unmapped().is_v4);
  for (const char* text : {"", "/8", "10.0.0.0/", "10.0.0.0/33", "10.0.0.0/-1", "10.0.0.0/8x",
                           "10.0.0/8", "::/129", "localhost"}) {
    EXPECT_FALSE(AddressRange::parse(text).ok()) << text;
  }
}

TEST(HostName, has_no_port_and_no_brackets) {
  for (const auto& [host, name] : {std::pair{"", ""},
                                   {"x", "x"},
                                   {"x:80", "x"},
                                   {"x:", "x"},
                                   {"127.0.0.1:8080", "127.0.0.1"},
                                   {"[::1]", "::1"},
                                   {"[::1]:80", "::1"}}) {
    EXPECT_EQ(host_name(host), name) << host;
  }
  for (const char* host :
       {"[::1].evil.example", "[::1]x", "[::1", "::1]", "::1", "[]", "[127.0.0.1]", "[x]",
        "x:80.evil.example", "x:80:90", "x:y", "x:-1", "a[::1]"}) {
    EXPECT_FALSE(host_name(host)) << host;
  }
}

}  // namespace
}  // namespace sightline
