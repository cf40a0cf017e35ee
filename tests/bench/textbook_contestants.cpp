#include "tests/bench/contestant.h"
#include "tests/contestants/textbook_kernel.h"
#include "tests/contestants/unrounded_kernel.h"

namespace sightline::bench {

namespace {

class TextbookContestant : public Contestant {
 public:
  TextbookContestant(const contestants::TextbookKernel& kernel, const Scene& scene)
      : Contestant(std::string(kernel.name)), kernel_(kernel), scene_(scene) {}

  void closest(const RaySet& rays, Answers& answers) const override {
    kernel_.closest(scene_, rays.rays, 0, rays.size(), answers.hits);
  }
  void any(const RaySet&, Answers&) const override {}
  bool knows_any() const override { return false; }
  bool float64() const override { return true; }

 private:
  contestants::TextbookKernel kernel_;
  const Scene& scene_;
};

}  // namespace

std::vector<std::string> textbook_names() {
  std::vector<std::string> names;
  for (const auto& kernel : contestants::textbook_kernels()) names.emplace_back(kernel.name);
  return names;
}

std::unique_ptr<Contestant> make_textbook(const std::string& name, const BenchScene& scene) {
  if (!contestants::can_trace(*scene.scene)) return nullptr;
  for (const auto& kernel : contestants::textbook_kernels()) {
    if (kernel.name == name) return std::make_unique<TextbookContestant>(kernel, *scene.scene);
  }
  return nullptr;
}

std::unique_ptr<Contestant> make_unrounded(const BenchScene& scene) {
  if (!contestants::can_trace_unrounded(*scene.scene)) return nullptr;
  return std::make_unique<TextbookContestant>(contestants::unrounded_kernel(), *scene.scene);
}

}  // namespace sightline::bench
