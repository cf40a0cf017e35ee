#include "server/http/request_head.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

const std::string kLine = "POST /a HTTP/1.1\r\n";
const std::string kHost = "Host: x\r\n";

/// The code of the fault, or "".
std::string fault_of(const std::string& text, RequestHead& head) {
  HeadScan scan;
  const HeadLimits limits;
  switch (scan.look(text, limits)) {
    case HeadScan::State::kMore:
      return "MORE";
    case HeadScan::State::kFault:
      return scan.fault().code;
    case HeadScan::State::kWhole:
      break;
  }
  const auto fault = parse_request_head(
      std::string_view(text).substr(scan.begin(), scan.size() - scan.begin()), limits, head);
  return fault ? fault->code : "";
}

std::string fault_of(const std::string& text) {
  RequestHead head;
  return fault_of(text, head);
}

TEST(RequestHead, reads_what_is_plain) {
  RequestHead head;
  EXPECT_EQ(fault_of(kLine + kHost + "content-LENGTH:  12 \r\nX-Request-Id: me\r\n\r\nbody", head),
            "");
  EXPECT_EQ(head.method, "POST");
  EXPECT_EQ(head.target, "/a");
  EXPECT_EQ(head.length, 12u);
  EXPECT_EQ(head.request_id, "me");
  EXPECT_FALSE(head.chunked || head.close || head.expects_continue || head.http10);
}

TEST(RequestHead, finds_the_same_end_however_the_bytes_come) {
  const std::string text = "\r\n" + kLine + kHost + "\r\n";
  HeadScan scan;
  const HeadLimits limits;
  for (std::size_t size = 0; size < text.size(); ++size) {
    ASSERT_EQ(scan.look(std::string_view(text).substr(0, size), limits), HeadScan::State::kMore);
  }
  EXPECT_EQ(scan.look(text + "GET", limits), HeadScan::State::kWhole);
  EXPECT_EQ(scan.size(), text.size());
  EXPECT_EQ(scan.begin(), 2u);
}

TEST(RequestHead, refuses_every_head_that_can_be_read_in_two_ways) {
  const std::string length = "Content-Length: 1\r\n", chunked = "Transfer-Encoding: chunked\r\n";
  for (const std::string& fields :
       {length + length, length + chunked, chunked + chunked, std::string("Content-Length: +1\r\n"),
        std::string("Content-Length: 1, 1\r\n"), std::string("Content-Length:\r\n"),
        std::string("Content-Length: 0x1\r\n"), std::string("Content-Length: %31\r\n"),
        std::string("Content-Length: 99999999999999999999\r\n"),
        std::string("Transfer-Encoding: gzip, chunked\r\n"),
        std::string("Transfer-Encoding: chunked,\r\n")}) {
    EXPECT_EQ(fault_of((kLine + kHost).append(fields).append("\r\n")), "FRAMING_AMBIGUOUS")
        << fields;
  }
  EXPECT_EQ(fault_of("POST /a HTTP/1.0\r\n" + chunked + "\r\n"), "FRAMING_AMBIGUOUS");
}

TEST(RequestHead, needs_one_host) {
  EXPECT_EQ(fault_of(kLine + "\r\n"), "HOST_INVALID");
  EXPECT_EQ(fault_of(kLine + kHost + "host: y\r\n\r\n"), "HOST_INVALID");
  for (const char* host : {"a,b", "a/b", "u@a", "a b", "a\\b", "a?b", "[::1].evil.example", "[::1",
                           "127.0.0.1:80.evil.example", "a:b"}) {
    EXPECT_EQ(fault_of(kLine + "Host: " + host + "\r\n\r\n"), "HOST_INVALID") << host;
  }
  EXPECT_EQ(fault_of("GET / HTTP/1.0\r\n\r\n"), "");
}

TEST(RequestHead, refuses_malformed_lines_where_they_stand) {
  const std::string nul("X: a\0b", 6);
  for (const std::string& text :
       {std::string("GET / HTTP/1.1\nHost: x\n\n"),
        std::string("GET / HTTP/1.1\r"
                    "Host: x\r\n\r\n"),
        std::string("\r\n\r\n\r\n"), (kLine + kHost).append(nul).append("\r\n"),
        std::string("\0", 1)}) {
    EXPECT_EQ(fault_of(text), "REQUEST_MALFORMED") << text;
  }
  for (const char* field :
       {"X : a", " X: a", "\tX: a", ": a", "X", "X\x01: a", "X: a\x01", "X: \x7f", "X(: a"}) {
    EXPECT_EQ(fault_of(kLine + kHost + field + "\r\n\r\n"), "REQUEST_MALFORMED") << field;
  }
  for (const char* line : {"GET  / HTTP/1.1", "GET /a b HTTP/1.1", "GET / HTTP/1.1 ", "GET /",
                           "GET", "G(T / HTTP/1.1", " / HTTP/1.1", "GET / http/1.1",
                           "GET /\x01 HTTP/1.1", "GET /a#b HTTP/1.1", "GET # HTTP/1.1"}) {
    EXPECT_EQ(fault_of(std::string(line) + "\r\n" + kHost + "\r\n"), "REQUEST_MALFORMED") << line;
  }
  for (const char* version : {"HTTP/2.0", "HTTP/1.2", "HTTP/0.9", "HTTP/1.10"}) {
    EXPECT_EQ(fault_of("GET / " + std::string(version) + "\r\n" + kHost + "\r\n"),
              "VERSION_UNSUPPORTED");
  }
}

TEST(RequestHead, is_bounded_in_bytes_and_fields) {
  EXPECT_EQ(fault_of("GET /" + std::string(9000, 'a')), "URI_TOO_LONG");
  EXPECT_EQ(fault_of(kLine + "X: " + std::string(9000, 'a')), "HEADER_TOO_LARGE");
  std::string many = kLine + kHost;
  for (int i = 0; i < 101; ++i) many += "X: a\r\n";
  EXPECT_EQ(fault_of(many + "\r\n"), "HEADER_TOO_LARGE");
  std::string large = kLine + kHost;
  for (int i = 0; i < 3; ++i) large += "X: " + std::string(7000, 'a') + "\r\n";
  EXPECT_EQ(fault_of(large), "HEADER_TOO_LARGE");
  EXPECT_EQ(fault_of(large + "\r\n"), "HEADER_TOO_LARGE");
}

TEST(RequestHead, wants_a_host_in_a_target_that_names_one) {
  RequestHead head;
  for (const char* target : {"http:///healthz", "http://", "HTTP://?a", "http://a,b/c",
                             "http://me@host/", "http://a\\b/"}) {
    EXPECT_EQ(fault_of("GET " + std::string(target) + " HTTP/1.1\r\n" + kHost + "\r\n"),
              "REQUEST_MALFORMED")
        << target;
  }
  EXPECT_EQ(fault_of("GET http://[::1]:80?a HTTP/1.1\r\n" + std::string(kHost) + "\r\n", head), "");
  EXPECT_EQ(head.target, "/?a");
}

TEST(RequestHead, takes_none_of_two_request_ids) {
  RequestHead head;
  EXPECT_EQ(fault_of(kLine + kHost + "X-Request-Id: a\r\nx-request-id: b\r\n\r\n", head), "");
  EXPECT_EQ(head.request_id, "");
}

TEST(RequestHead, keeps_what_a_body_is_and_what_is_wanted) {
  RequestHead head;
  EXPECT_EQ(
      fault_of(kLine + kHost + "content-type: A/b\r\nContent-Type: c\r\nACCEPT: d\r\n\r\n", head),
      "");
  EXPECT_EQ(head.content_type, "A/b");
  EXPECT_EQ(head.accept, "d");
  EXPECT_EQ(head.coding, Coding::kIdentity);
  EXPECT_EQ(fault_of(kLine + kHost + "Content-Encoding: gzip\r\n\r\n", head), "");
  EXPECT_EQ(head.coding, Coding::kGzip);
  EXPECT_EQ(head.content_type, std::nullopt);
  for (const char* codings : {"Content-Encoding: br\r\n\r\n",
                              "Content-Encoding: gzip\r\nContent-Encoding: gzip\r\n\r\n"}) {
    EXPECT_EQ(fault_of(kLine + kHost + codings, head), "");
    EXPECT_EQ(head.coding, std::nullopt);
  }
}

TEST(RequestHead, takes_what_is_decided_before_the_handler) {
  RequestHead head;
  EXPECT_EQ(
      fault_of("BREW http://other/a?b HTTP/1.1\r\nHost: x\r\nRange: bytes=x\r\nExpect: "
               "100-Continue\r\nConnection: foo, Close\r\nAccept-Encoding: gzip\r\nREMOTE_ADDR: "
               "1.1.1.1\r\nIf-Match: b\r\nIf-match:c, d\r\n\r\n",
               head),
      "");
  EXPECT_EQ(head.method, "BREW");
  EXPECT_EQ(head.target, "/a?b");
  EXPECT_EQ(head.if_match, "b, c, d");
  EXPECT_EQ(head.if_none_match, std::nullopt);
  EXPECT_TRUE(head.close && head.expects_continue);
  EXPECT_EQ(fault_of(kLine + kHost + "Authorization: Bearer a\r\nX-Request-Id: b\r\n\r\n", head),
            "");
  EXPECT_EQ(head.authorization, "Bearer a");
  EXPECT_EQ(fault_of(kLine + kHost + "authorization: a\r\nAuthorization: a\r\n\r\n", head), "");
  EXPECT_EQ(head.authorization, "");
  EXPECT_EQ(fault_of(kLine + kHost + "Expect: more\r\n\r\n"), "EXPECTATION_UNKNOWN");
}

}  // namespace
}  // namespace sightline
