#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "record/column_sources.h"
#include "record/log_fields.h"
#include "twin/record/columns.h"
#include "twin/record/mcap_reader.h"

namespace twin::record {

/// Rows of a table that are being decoded.
struct RowBuffer {
  struct Part : Column {
    const ColumnSource* source = nullptr;
    bool has_width = false;  ///< `width` is known
    std::size_t count = 0;   ///< values of the open row, of a repeated field
    std::uint64_t bits = 0;  ///< of the open row, kErrors
    std::optional<pb::Violation> violation{};
    std::unordered_map<std::string, std::int32_t> codes{};  ///< of `texts`
  };

  std::size_t rows = 0;
  std::vector<Part> parts{};

  [[nodiscard]] std::size_t Bytes() const;
  void Clear();
};

/// Appends messages of log.proto to columns, straight from the wire format, of which it decodes
/// only the columns that are wanted. Untrusted bytes: as LogDecoder, but a group is an error.
///
/// Threads: one thread. Real-time: no.
class RowDecoder {
 public:
  /// @param columns  numbers in the table; the first is 0. @param interval  of the kept rows.
  RowDecoder(const TableInfo& table, std::span<const std::size_t> columns,
             const Interval& interval = {});

  /// @throws InputError if the topic is the table's, and the type of its messages another one.
  [[nodiscard]] bool Takes(const McapChannel& channel) const;
  /// @throws InputError naming the field that is wrong.
  void Decode(std::span<const std::byte> message);

  [[nodiscard]] RowBuffer& rows() { return rows_; }
  /// @returns the rows, and begins anew.
  [[nodiscard]] RowBuffer Take();

 private:
  static constexpr std::size_t kFields = 64;  ///< our field numbers are below

  /// What to do with a field.
  struct Use {
    enum class Kind : std::uint8_t { kSkip, kColumn, kMessage, kRow };
    Kind kind = Kind::kSkip;
    std::size_t place = 0;  ///< of the column in `rows_`, or of the node
  };
  using Node = std::array<Use, kFields>;

  class Wire;

  void AddUse(std::size_t node, const ColumnSource& source, std::size_t part);
  void DecodeMessage(std::span<const std::byte> message, std::size_t node);
  void TakeField(Wire& wire, std::uint32_t type, RowBuffer::Part& part);
  void TakeDoubles(std::span<const std::byte> values, RowBuffer::Part& part);
  void BeginRow();
  void EndRow();

  const TableInfo& table_;
  const TableSource& source_;
  Interval interval_;
  RowBuffer empty_;
  RowBuffer rows_;
  std::vector<Node> nodes_;  ///< of the topic's message, of the row's, of those within
  std::vector<std::span<const std::byte>> row_messages_;
};

/// @returns the rows of all buffers, one after another; the buffers are emptied.
[[nodiscard]] Table Join(const TableInfo& table, std::span<RowBuffer> buffers);

}  // namespace twin::record
