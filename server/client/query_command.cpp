#include "proto/json/hit_lines.h"
#include "server/client/api_client.h"
#include "server/client/commands.h"
#include "server/client/ray_question.h"

namespace sightline {

int run_query(const QueryCommand& command, std::istream& in, std::ostream& out,
              std::ostream& complaints) {
  const auto client = ApiClient::open(command.server);
  if (!client) return complain(complaints, client.error());
  const std::string path = "/v1/scenes/" + percent_encoded(command.scene) +
                           "/rays:" + std::string(question_kind(command.mode));
  const auto answer = [&](const std::string& lines, std::size_t) -> Result<std::string> {
    auto told = (*client)->ask("POST", path, lines, std::string(kLinesMediaType));
    if (!told) return told.error();
    if (told->good()) return std::move(told->body);
    return Error{ErrorKind::kInvalid, "SERVER_REFUSES", problem_text(*told), ""};
  };
  return ask_rays(command, answer, in, out, complaints);
}

}  // namespace sightline
