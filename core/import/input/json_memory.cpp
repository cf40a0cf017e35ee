#include "core/import/input/json_memory.h"

#include <sys/mman.h>

#include <nlohmann/json.hpp>

#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

/// A block of the heap begins with its size and is a multiple of 16.
constexpr std::uint64_t block(std::uint64_t bytes) { return (bytes + 8 + 15) / 16 * 16; }

/// A vector that grows holds its old and its new storage, which is twice as large.
constexpr std::uint64_t kGrowing = 3;

/// malloc takes address space for other threads than the first in heaps of this size.
constexpr std::uint64_t kHeap = 64ull << 20;

}  // namespace

std::uint64_t document_bytes(const JsonSize& size) {
  using nlohmann::json;
  // std::map stores an element with a colour and three pointers.
  constexpr std::uint64_t kMember = block(sizeof(std::pair<const std::string, json>) + 32);
  return kGrowing * sizeof(json) *
             (size.elements + size.values)  // in arrays; at the end, on a stack
         + kMember * size.members + block(sizeof(json::array_t)) * size.arrays +
         block(sizeof(json::object_t)) * size.objects +
         block(sizeof(json::string_t)) * size.strings
         // Strings and keys of their own blocks, each with a head; the text, growing, of a dump.
         + 16 * (size.strings + size.members) + (1 + kGrowing) * size.bytes;
}

Status try_memory(std::uint64_t bytes) {
  const std::uint64_t wanted = 2 * bytes + kHeap;
  void* memory = ::mmap(nullptr, wanted, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) {
    return Error{
        ErrorKind::kOutOfSpace, "GLTF_OUT_OF_MEMORY",
        "not enough memory for this file: its JSON may need " + std::to_string(bytes) + " bytes",
        ""};
  }
  ::munmap(memory, wanted);
  return success();
}

}  // namespace sightline::gltf
