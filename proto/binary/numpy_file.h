#pragma once
/// Parts of NumPy's file formats: NPY 1.0 and NPZ. For files of this room only.

#include <cstdint>
#include <cstring>
#include <string>

namespace sightline {

/// The most bytes of an .npz file: a ZIP archive states sizes in 32 bits.
inline constexpr std::uint64_t kNpzBytes = 0xffff0000u;

/// Appends the bytes of a number, little-endian.
template <class Number>
void append_number(std::string& out, Number number) {
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  out.append(bytes, sizeof number);
}

/// The head of an .npy file, whose length is a multiple of 64. `type` is a Python literal, such as
/// "'<f8'"; `shape` is the inside of a tuple, such as "5," or "5,3".
std::string npy_head(const std::string& type, const std::string& shape);

/// A ZIP archive whose files are not compressed. Precondition: it has at most kNpzBytes.
class ZipArchive {
 public:
  /// Appends a file.
  void add(const std::string& name, const std::string& bytes);
  /// Returns the archive; called once, after all files.
  std::string take();

 private:
  std::string out_, directory_;
  std::uint16_t files_ = 0;
};

}  // namespace sightline

// Tests: tests/integration/tables_test.py
