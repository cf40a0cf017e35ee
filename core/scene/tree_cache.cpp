#include "core/scene/tree_cache.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "core/base/content_hash.h"
#include "core/base/parallel.h"
#include "core/bvh/tree_source.h"
#include "core/bvh/validate.h"
#include "core/scene/tree_cache_format.h"

namespace sightline {

using namespace tree_cache;

namespace {

Error refused(const char* code, std::string message) {
  return {ErrorKind::kMalformed, code, "stored trees: " + std::move(message), ""};
}

/// Precondition: the bytes are there.
template <class T>
T read_at(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

Status check_header(std::span<const std::byte> bytes, std::uint64_t content) {
  if (bytes.size() < sizeof(Header)) {
    return refused("TREES_FOREIGN", std::to_string(bytes.size()) + " bytes hold no header of " +
                                        std::to_string(sizeof(Header)));
  }
  const auto header = read_at<Header>(bytes, 0);
  if (!std::equal(std::begin(kMagic), std::end(kMagic), header.magic))
    return refused("TREES_FOREIGN", "the file begins with something else");
  if (header.hash != hash_of(header)) return refused("TREES_DAMAGED", "the header's hash differs");
  const Header own = make_header();
  if (std::memcmp(&header.version, &own.version,
                  offsetof(Header, content) - offsetof(Header, version)) != 0) {
    return refused("TREES_STALE", "written by version " + std::to_string(header.version) +
                                      " or by another kind of machine; this is version " +
                                      std::to_string(own.version));
  }
  if (header.content != content) return refused("TREES_STALE", "they are of another scene");
  if (header.file_bytes != bytes.size()) {
    return refused("TREES_DAMAGED", "the file has " + std::to_string(bytes.size()) +
                                        " bytes, not " + std::to_string(header.file_bytes));
  }
  const std::size_t room = (bytes.size() - sizeof(Header)) / sizeof(Record);
  if (header.tree_count > room) {
    return refused("TREES_DAMAGED", std::to_string(header.tree_count) +
                                        " records are stated, there is room for " +
                                        std::to_string(room));
  }
  const auto records = bytes.subspan(sizeof(Header), header.tree_count * sizeof(Record));
  if (hash_of(records) != header.records_hash)
    return refused("TREES_DAMAGED", "the hash of the records differs");
  return success();
}

/// Reads one tree after the other.
class StoredTrees {
 public:
  /// Precondition: check_header.
  StoredTrees(std::span<const std::byte> bytes, const std::shared_ptr<const void>& owner)
      : bytes_(bytes), owner_(owner), count_(read_at<Header>(bytes, 0).tree_count) {}

  /// Its shape and content are still to be proved.
  Result<WideTree> next() {
    const std::string name = "tree " + std::to_string(next_);
    if (next_ == count_) return refused("TREES_DAMAGED", name + " is missing");
    const auto record = read_at<Record>(bytes_, sizeof(Header) + next_++ * sizeof(Record));
    if (record.offset % kAlign != 0 || record.bytes % kAlign != 0 ||
        record.offset > bytes_.size() || record.bytes > bytes_.size() - record.offset) {
      return refused("TREES_DAMAGED", name + " lies outside of the file");
    }
    const auto arena = bytes_.subspan(record.offset, record.bytes);
    if (hash_in_pieces(arena) != record.hash)
      return refused("TREES_DAMAGED", "the hash of " + name + " differs");
    WideTree tree;
    tree.arena = Arena(arena.data(), arena.size(), owner_);
    tree.root = record.root;
    tree.scale_exponent = record.scale_exponent;
    for (int k = 0; k < 3; ++k) {
      tree.bounds.min[k] = record.lower[k];
      tree.bounds.max[k] = record.upper[k];
    }
    tree.node_count = record.node_count;
    tree.block_count = record.block_count;
    tree.depth = record.depth;
    return tree;
  }
  bool at_end() const { return next_ == count_; }

 private:
  std::span<const std::byte> bytes_;
  const std::shared_ptr<const void>& owner_;
  std::uint64_t count_;
  std::uint64_t next_ = 0;
};

Error invalid(const Error& fault) { return refused("TREES_DAMAGED", fault.message); }

}  // namespace

std::uint64_t content_hash(const ScenePlan& plan) {
  std::vector<std::uint64_t> hashes(plan.meshes.size());
  parallel_for(plan.meshes.size(), [&](std::size_t i) {
    if (plan.facts[i].uses == 0) return;
    const std::uint64_t both[] = {hash_in_pieces(std::as_bytes(plan.meshes[i].positions)),
                                  plan.meshes[i].indices.size(),
                                  hash_in_pieces(std::as_bytes(plan.meshes[i].indices.listed()))};
    hashes[i] = hash_of(std::as_bytes(std::span(both)));
  });
  ContentHash hash;
  hash.add(std::as_bytes(std::span(&kVersion, 1)));
  hash.add(std::as_bytes(std::span(hashes)));
  for (const PlacementView& placement : plan.placements) {
    hash.add(std::as_bytes(std::span(&placement.mesh, 1)));
    hash.add(std::as_bytes(std::span(placement.world_from_mesh.m)));
    if (placement.hidden) hash.add(std::as_bytes(std::span("hidden")));
  }
  return hash.value();
}

EncodedTrees encode_trees(const SceneTree& tree, std::uint64_t content) {
  std::vector<const WideTree*> trees;
  for (const auto& one : tree.trees) trees.push_back(one.get());
  if (tree.entries > 1) trees.push_back(&tree.top);
  EncodedTrees encoded;
  std::vector<Record> records;
  std::uint64_t end = sizeof(Header) + trees.size() * sizeof(Record);
  for (const WideTree* one : trees) {
    const std::span<const std::byte> arena(one->arena.at(0), one->arena.used());
    Record record{};
    record.offset = end;
    record.bytes = arena.size();
    record.root = one->root;
    record.scale_exponent = one->scale_exponent;
    for (int k = 0; k < 3; ++k) {
      record.lower[k] = one->bounds.min[k];
      record.upper[k] = one->bounds.max[k];
    }
    record.node_count = one->node_count;
    record.block_count = one->block_count;
    record.depth = one->depth;
    record.hash = hash_in_pieces(arena);
    records.push_back(record);
    encoded.arenas.push_back(arena);
    end += arena.size();
  }
  Header header = make_header();
  header.content = content;
  header.file_bytes = end;
  header.tree_count = trees.size();
  header.records_hash = hash_of(std::as_bytes(std::span(records)));
  header.hash = hash_of(header);
  const auto head = std::as_bytes(std::span(&header, 1));
  encoded.head.assign(head.begin(), head.end());
  const auto table = std::as_bytes(std::span(records));
  encoded.head.insert(encoded.head.end(), table.begin(), table.end());
  return encoded;
}

Result<SceneTree> decode_trees(const ScenePlan& plan, std::uint64_t content,
                               std::span<const std::byte> bytes,
                               const std::shared_ptr<const void>& owner) {
  if (Status good = check_header(bytes, content); !good) return std::move(good).error();
  StoredTrees stored(bytes, owner);
  TreeSource source;
  source.triangles =
      [&](std::span<const TreePart> parts) -> Result<std::shared_ptr<const WideTree>> {
    auto tree = stored.next();
    if (!tree) return std::move(tree).error();
    if (Status good = validate_triangle_tree(*tree, parts); !good) return invalid(good.error());
    return std::make_shared<const WideTree>(std::move(*tree));
  };
  source.top = [&](std::span<const Box3d> boxes, const Box3d&) -> Result<WideTree> {
    auto tree = stored.next();
    if (!tree) return tree;
    if (Status good = validate_top_tree(*tree, boxes); !good) return invalid(good.error());
    return tree;
  };
  auto tree = assemble_scene_tree(plan, Joining::kMeasured, source);
  if (tree && !stored.at_end())
    return refused("TREES_DAMAGED", "there are more trees than asked for");
  return tree;
}

}  // namespace sightline
