#pragma once
/// Something that traces a set of rays: columns in, columns out, filling and unpacking of its own
/// ray structs included.

#include <memory>
#include <string>
#include <vector>

#include "core/query/hit_batch.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/ray_set.h"

namespace sightline::bench {

/// Slots of all rays of a set; sized before the clock starts.
struct Answers {
  HitBatch hits;    ///< ids by everybody, t by contestants that compute in float64
  Column<float> t;  ///< by contestants that compute in float32
  Column<std::uint8_t> occluded;

  void resize(std::size_t count) {
    hits.resize(count);
    t.resize(count);
    occluded.resize(count);
  }
};

class Contestant {
 public:
  explicit Contestant(std::string name) : name_(std::move(name)) {}
  Contestant(const Contestant&) = delete;
  Contestant& operator=(const Contestant&) = delete;
  virtual ~Contestant() = default;

  const std::string& name() const { return name_; }
  /// True if its t and ids are promised to be exact.
  virtual bool exact() const { return false; }
  /// True if its t is in Answers::hits, false if it is in Answers::t.
  virtual bool float64() const { return exact(); }
  /// Precondition: the answers have as many slots as there are rays.
  virtual void closest(const RaySet& rays, Answers& answers) const = 0;
  virtual void any(const RaySet& rays, Answers& answers) const = 0;
  /// False if it must not be asked for any-hit here.
  virtual bool knows_any() const { return true; }
  /// What one closest pass did per ray, for reading beside the time; empty if unknown.
  virtual std::string explain(const RaySet&) const { return {}; }

 private:
  std::string name_;
};

/// "sightline" (batches of 262,144), "sightline_1024", "sightline_64", "sightline_1";
/// "sightline_keep_all" and "sightline_keep_fronts" with a filter that leaves out nothing or all
/// hits of backs; with "@KERNEL" behind it, e.g. "sightline_64@sse4", that kernel.
std::vector<std::string> sightline_names();
/// Null for an unknown kernel name; empty: the best of this machine. The scene must outlive it.
std::unique_ptr<Contestant> make_sightline(const std::string& name, const std::string& kernel,
                                           const BenchScene& scene);

/// embree1[_avx2|_robust], embree{8,16}_{coherent,incoherent}[_robust],
/// embree_stream_{coherent,incoherent}[_robust]; with "@avx2" or "@sse4.2" behind it that isa of
/// Embree.
std::vector<std::string> embree_names();
/// Those of `names` that are Embree's. Each combination of device and scene flags that is needed is
/// built once, with all threads.
std::vector<std::unique_ptr<Contestant>> make_embree(const std::vector<std::string>& names,
                                                     const BenchScene& scene);

/// The triangle tests of the literature on the product's tree
/// (tests/contestants/textbook_kernel.h); closest only.
std::vector<std::string> textbook_names();
/// Null for an unknown name, and for a scene that they cannot trace.
std::unique_ptr<Contestant> make_textbook(const std::string& name, const BenchScene& scene);

/// "sightline_unrounded": Sightline's decisions, t as plain float64 arithmetic gives it
/// (tests/contestants/unrounded_kernel.h); closest only. Null for a scene that it cannot trace.
std::unique_ptr<Contestant> make_unrounded(const BenchScene& scene);

}  // namespace sightline::bench
