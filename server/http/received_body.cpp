#include "server/http/received_body.h"

#include <algorithm>
#include <cstring>

namespace sightline {

std::size_t ReceivedBody::room_for(std::size_t wanted) {
  // After the first byte in the file all go there: they are read in this order.
  if (file_.size() > 0) return 0;
  const std::size_t most = in_parts_ ? kPart : kWhole;
  // Whole bodies may wait long for a worker: requests that run have more of the memory.
  const std::uint64_t part = in_parts_ ? 2 : kPartForWhole;
  while (wanted > kInMemory && charged_ < std::min(wanted, most) && budget_.charge(kPart, part)) {
    charged_ += kPart;
  }
  return std::max<std::size_t>(charged_, kInMemory);
}

bool ReceivedBody::store(std::string_view payload) {
  const std::size_t room = room_for(memory_.size() + payload.size());
  const std::size_t here = std::min(payload.size(), room - std::min(room, memory_.size()));
  if (here < payload.size() && !file_.append(payload.substr(here))) return false;
  memory_.append(payload.substr(0, here));
  return true;
}

bool ReceivedBody::take(char* input, std::size_t size, std::size_t& taken) {
  if (!is_chunked_) {
    taken = static_cast<std::size_t>(std::min<std::uint64_t>(left_, size));
    left_ -= taken;
    return store({input, taken});
  }
  std::string_view coded(input, size);
  // The payload is never longer than its chunks, and takes their place.
  const std::size_t count = chunks_.decode(coded, input);
  taken = size - coded.size();
  return store({input, count});
}

std::size_t ReceivedBody::read(char* data, std::size_t size) {
  std::size_t count = 0;
  if (at_ < memory_.size()) {
    count = memory_.copy(data, size, static_cast<std::size_t>(at_));
    at_ += count;
  }
  if (count == size || at_ < memory_.size()) return count;
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(size - count, unread()));
  const std::size_t got = file_.read(at_ - memory_.size(), data + count, wanted);
  has_failed_ = has_failed_ || got < wanted;
  at_ += got;
  return count + got;
}

void ReceivedBody::begin_part() {
  dropped_ += at_;
  at_ = 0;
  std::string().swap(memory_);
  file_.clear();
  budget_.release(charged_);
  charged_ = 0;
  in_parts_ = true;
}

}  // namespace sightline
