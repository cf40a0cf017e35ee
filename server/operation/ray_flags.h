#pragma once
/// The flags of the commands cast, query and mcp.

#include <CLI/CLI.hpp>

#include <string>

#include "server/operation/cli.h"

namespace sightline {

/// Values of flags about a ray, as text. The finish_ functions parse them after all flags are
/// known.
struct RayFlags {
  std::string origin, direction, tmin, tmax;
};
/// Flags that choose the question: at most one of `any`, `all` and `count`; none: the closest hit.
struct ModeFlags {
  std::string crossings = "every";
  bool any = false, all = false, count = false;
};
/// The flags that cast and query have in common.
struct CastFlags {
  RayFlags ray;
  ModeFlags mode;
  std::string fields, format;
  bool json = false;
};
/// The flags of query are those of cast.
using QueryFlags = CastFlags;

// define_ functions add the flags of a command to `app`; parsing writes to `command` and `flags`,
// which must outlive `app`. finish_ functions, called after parsing, convert the values into
// `command`; they throw CLI::ParseError.
void define_cast(CLI::App& app, CastCommand& command, CastFlags& flags);
void finish_cast(CastCommand& command, const CastFlags& flags);
void define_query(CLI::App& app, QueryCommand& command, QueryFlags& flags);
void finish_query(QueryCommand& command, const QueryFlags& flags);
void define_mcp(CLI::App& app, McpCommand& command);

}  // namespace sightline

// Tests: tests/unit/server/cli_test.cpp
