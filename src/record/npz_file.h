#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "twin/record/columns.h"
#include "twin/record/partial_file.h"

namespace twin::record {

/// A NumPy archive being written: a zip of .npy files, without compression, the same for the same
/// columns. `.partial` until Commit(), removed without it.
/// Sources: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html, PKWARE APPNOTE.
///
/// Threads: one thread. Real-time: no. Errors: those of PartialFile; InputError beyond 4 GiB.
class NpzFile {
 public:
  explicit NpzFile(const std::filesystem::path& path);

  /// Adds array `name`, and of texts their numbers, and `name.names`.
  void Add(const Column& column, std::size_t rows);

  void Commit();

 private:
  void AddMember(const std::string& name, const std::string& type, const std::string& shape,
                 std::span<const std::byte> values);

  PartialFile file_;
  std::vector<std::byte> directory_;
  std::uint16_t members_ = 0;
};

}  // namespace twin::record
